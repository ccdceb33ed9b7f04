"""The command line."""

from poinsot.cli.app import app

__all__ = ["app"]
