"""Scenarios: propagations described in TOML."""
