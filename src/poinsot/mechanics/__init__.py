"""Bodies and base classes of forces, parts, orbits, events and observables, with the instant that formulas read.

The names for authors of own forces, parts and frames are in `__init__.pyi`; each is imported when it is used first.
"""

from poinsot.suggestions import attached

__getattr__, __dir__, __all__ = attached(__name__, __file__)
