"""Rotation of rigid bodies: `propagate(System(body, *forces), state, times) -> Trajectory`.

The public names are in `__init__.pyi`; each is imported when it is used first.
"""

import lazy_loader

public_name, __dir__, __all__ = lazy_loader.attach_stub(__name__, __file__)

__version__ = "0.2.0"


def __getattr__(name: str) -> object:
    """Return a public name. The error of another name states the namespace that has it."""
    try:
        return public_name(name)
    except AttributeError:
        import pkgutil  # takes longer to import than all else here

        spaces = [space.name for space in pkgutil.iter_modules(__path__) if space.name in __all__]
        homes = [f"poinsot.{space}.{name}" for space in spaces if name in public_name(space).__all__]
        if name.startswith("_") or not homes:
            raise
        raise AttributeError(f"module 'poinsot' has no attribute '{name}'. Use {' or '.join(homes)}.") from None
