"""Numbers alone: quaternions, formulas as graphs and their derivatives, sums of two doubles, solid harmonics."""
