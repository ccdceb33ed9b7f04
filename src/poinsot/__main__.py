"""The command line as a module: `python -m poinsot`."""

from poinsot.cli import app

app(prog_name="poinsot")
