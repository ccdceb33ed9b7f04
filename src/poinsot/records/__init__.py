"""Records of numbers: parameters and their members, units, dates, and errors of formulas in records."""
