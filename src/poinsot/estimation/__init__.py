"""Estimation: attitude and motion of a body from measurements.

The names are in `__init__.pyi`; each is imported when it is used first.
"""

from poinsot.suggestions import attached

__getattr__, __dir__, __all__ = attached(__name__, __file__)
