"""Files of orbits."""
