"""Numbers alone: quaternions, derivatives by dual numbers, sums of two doubles, solid harmonics."""
