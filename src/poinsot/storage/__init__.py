"""Stores of ensembles: arrays of members on disk, computed and written in chunks."""
