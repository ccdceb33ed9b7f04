"""Quaternions, ellipsoids and solid harmonics, as formulas for scalars of any kind."""
