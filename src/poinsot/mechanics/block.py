"""Variables that are integrated along with attitude and angular momentum."""

from __future__ import annotations

import itertools
import re
from abc import ABC
from collections.abc import Mapping
from dataclasses import field
from typing import ClassVar

from typing_extensions import override

from poinsot.printable import quoted
from poinsot.records.parameters import Parametric, kinds_of, listed

__all__ = ["Block", "default_name"]

RESERVED = frozenset({"attitude", "angular_momentum", "time", "frame"})
"""Names that the results of a system and the arguments of `system.state` have already."""


class Block(Parametric, ABC):
    """Variables of a part or of an orbit that are integrated along; their rates may depend on the whole state.

    Parameters
    ----------
    name : str
        Name of the variables in results, states and formulas. Default: the class in lower case, `reaction_wheel`.
        Several parts of one class require different names.

    Raises
    ------
    ValueError
        If the name is no word of letters, digits and underscores.
    """

    name: str = field(default="", kw_only=True)
    variables: ClassVar[Mapping[str, int]] = {}
    """Number of scalars of each variable, in the order of the state vector."""
    momenta: ClassVar[frozenset[str]] = frozenset()
    """Names of the variables that are angular momenta, which scale with the momentum."""

    def __post_init__(self) -> None:
        super().__post_init__()
        object.__setattr__(self, "name", self.name or default_name(type(self)))
        if not self.name.isidentifier() or self.name in RESERVED or self.name.startswith(("omega", "angular_momentum")):
            raise ValueError(
                f"name must be a word such as {quoted(default_name(type(self)))} that no other variable has, got "
                f"{quoted(self.name)}."
            )

    @override
    def __repr__(self) -> str:
        names = [n for n in kinds_of(type(self)) if n != "name"]
        names += ["name"] * (self.name != default_name(type(self)))
        return f"{type(self).__name__}({', '.join(f'{n}={listed(getattr(self, n))}' for n in names)})"

    @property
    def size(self) -> int:
        """Number of scalars."""
        return sum(self.variables.values())

    @property
    def momentum_places(self) -> list[slice]:
        """Places of the angular momenta among the scalars."""
        ends = itertools.accumulate(self.variables.values())
        places = zip(self.variables.items(), ends, strict=True)
        return [slice(end - count, end) for (name, count), end in places if name in self.momenta]


def default_name(cls: type) -> str:
    """Return the name of a class in lower case with underscores."""
    return re.sub(r"(?<=[a-z0-9])(?=[A-Z])", "_", cls.__name__).lower()
