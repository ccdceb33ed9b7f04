"""What moves inside bodies, one class each: `Part`s with one formula each."""
