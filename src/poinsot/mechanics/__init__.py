"""Description without an integrator: body, state, attitude, frames, forces, events, the system and its environment.

The names for authors of own forces, parts and frames are in `__init__.pyi`; each is imported when it is used first.
"""

from poinsot.suggestions import attached

__getattr__, __dir__, __all__ = attached(__name__, __file__)
