"""Figures of a trajectory, and the page that shows it in three dimensions."""
