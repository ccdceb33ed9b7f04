"""Files of shapes and gravity fields."""
