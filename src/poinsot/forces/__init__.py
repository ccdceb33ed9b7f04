"""Physical effects, one class and one formula each."""
