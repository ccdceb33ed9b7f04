"""Attitudes, Euler angles, Andoyer variables, moving axes, and states of one body and of two."""
