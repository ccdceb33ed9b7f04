"""Plots of motions and of the results of analyses: `poinsot.plot.quaternions(motion)`, ...

The names are in `__init__.pyi`; each is imported when it is used first, and matplotlib at the first plot.
"""

from poinsot.suggestions import attached

__getattr__, __dir__, __all__ = attached(__name__, __file__)
