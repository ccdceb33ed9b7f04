"""The public names of poinsot.observables, by the module of each, as `make face` writes them."""

from .readings import Readings

__all__ = [
    "Readings",
]
