"""Motions that this installation repeats: published, computed by other programs, and the problems of the paper."""
