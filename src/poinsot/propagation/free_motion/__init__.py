"""Torque-free rotation in closed form."""
