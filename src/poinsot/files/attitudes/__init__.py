"""Files of attitudes."""
