"""Files of observations: light curves, shapes and spins of DAMIT, ALCDEF, and readings as comma-separated values."""
