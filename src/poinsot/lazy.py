"""Attributes that are computed when they are read first."""

from __future__ import annotations

import functools
from typing import TYPE_CHECKING, Any

import numpy as np

from poinsot.immutable import read_only

__all__ = ["cached_property"]

if TYPE_CHECKING:
    from functools import cached_property
else:

    class cached_property(functools.cached_property):  # noqa: N801
        """A cached property without a lock, as in Python 3.12, whose arrays are read-only.

        A lock doubles the time. Two threads may both compute a value; one of the two values stays.
        """

        def __get__(self, instance: Any, owner: type | None = None) -> Any:
            if instance is None:
                return self
            value = self.func(instance)
            if value.__class__ is np.ndarray or self.attrname[0] != "_":  # a private dictionary may be a cache
                value = read_only(value)
            instance.__dict__[self.attrname] = value
            return value
