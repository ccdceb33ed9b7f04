"""The command line as a module: `python -m poinsot`."""

from poinsot.cli import app

if __name__ == "__main__":
    app(prog_name="poinsot")
