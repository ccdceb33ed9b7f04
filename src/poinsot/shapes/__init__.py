"""Bodies from shapes: what a distribution of mass has as moments of inertia and as a gravity field."""
