"""The error message for a quantity of one body where there are two bodies."""

from __future__ import annotations

from typing import TYPE_CHECKING, ClassVar, NoReturn

from poinsot.suggestions import refuse_attribute

__all__ = ["OfTwoBodies", "no_attribute"]


def no_attribute(noun: str, name: str) -> str:
    """Return the error message for an attribute that each of two bodies has, and the pair does not have."""
    return f"{noun} of two bodies has no {name}. Read primary.{name} or secondary.{name}."


class OfTwoBodies:
    """Base of the state, the instant and the motion of two bodies.

    Each of the two bodies has attributes that the pair does not have, such as an attitude. Reading one of them from the
    pair raises an error that names the body's attribute.
    """

    _one: ClassVar[type]
    """The class whose attributes each of the two bodies has."""
    _noun: ClassVar[str]
    """The noun of the error message, with an article."""

    if not TYPE_CHECKING:  # a type checker reports unknown attributes itself

        def __getattr__(self, name: str) -> NoReturn:
            if hasattr(self._one, name):
                raise AttributeError(no_attribute(self._noun, name), name=name, obj=self)
            refuse_attribute(self, name)
