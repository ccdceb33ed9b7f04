"""Records from numbers in the order of their fields, as tests and oracles list them."""

import dataclasses


def in_order(cls, *numbers, **others):
    """Return a record of a class from its first fields in their order, and others by name."""
    names = [field.name for field in dataclasses.fields(cls)]
    return cls(**dict(zip(names, numbers, strict=False)), **others)
