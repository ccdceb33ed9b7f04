"""Reading a motion."""
