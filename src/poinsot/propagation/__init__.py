"""From a system, a state and times to a trajectory."""
