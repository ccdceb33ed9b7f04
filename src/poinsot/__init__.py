"""Rotation of rigid bodies: `propagate(System(body, *forces), state, times) -> Trajectory`.

The public names are in `__init__.pyi`; each is imported when it is used first.
"""

from poinsot.suggestions import attached

__getattr__, __dir__, __all__ = attached(__name__, __file__)

__version__ = "0.3.0"
