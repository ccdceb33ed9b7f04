"""Bridge from a system to its integration: equations of motion, state vector, tangent vectors, events and runs."""
