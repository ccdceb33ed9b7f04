"""Numbers of twice the double precision."""

from poinsot.mechanics.double_double import HALF_PI, PI, DoubleDouble, pick

__all__ = ["HALF_PI", "PI", "DoubleDouble", "pick"]
