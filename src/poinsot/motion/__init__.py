"""What makes a trajectory."""
