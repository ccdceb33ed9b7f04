"""Code that runs in a process of its own as by `python -c`, without the second and more that the imports take.

The process is forked from one that has imported the package, built the model of scenarios, and done nothing else.
"""

import functools
import json
import os
import pty
import select
import subprocess
import sys
import tempfile
from pathlib import Path

CLEAN = """
import atexit, gc, json, os, sys, traceback
import astropy.time, dask.distributed, llvmlite.binding, matplotlib.figure, netCDF4, typer, xarray
import poinsot.cli.app, poinsot.cli.runs, poinsot.integration.run, poinsot.files.netcdf
import poinsot.scenarios.schema
xarray.Dataset({"x": ("t", [0.0])}), poinsot.scenarios.schema.scenario_model()  # they import and build for long
gc.freeze()
for line in sys.stdin:
    child = os.fork()
    if not child:
        break
    print(os.waitstatus_to_exitcode(os.waitpid(child, 0)[1]), flush=True)
else:
    sys.exit()
asked = json.loads(line)
os.setsid()
for number, (name, mode) in enumerate(zip(asked["files"], (os.O_RDONLY, os.O_WRONLY, os.O_WRONLY))):
    os.dup2(os.open(name, mode), number)
sys.stdin, sys.stdout, sys.stderr = (open(number, mode, closefd=False) for number, mode in enumerate("rww"))
os.environ.clear()
os.environ.update(asked["environment"])
os.chdir(asked["folder"])
sys.argv = ["-c", *asked["arguments"]]
try:
    exec(asked["code"], {"__name__": "__main__"})
    status = 0
except SystemExit as error:
    status = error.code or 0
except BaseException:
    traceback.print_exc()
    status = 1
atexit._run_exitfuncs()
sys.stdout.flush()
os._exit(status)  # to forget all modules takes half a second
"""


@functools.cache
def _clean():
    return subprocess.Popen([sys.executable, "-c", CLEAN], stdin=subprocess.PIPE, stdout=subprocess.PIPE, text=True)


def _ask(code, arguments, files, **environment):
    asked = {
        "code": code,
        "arguments": [str(argument) for argument in arguments],
        "files": [str(name) for name in files],
        "environment": os.environ | environment,
        "folder": os.getcwd(),
    }
    print(json.dumps(asked), file=_clean().stdin, flush=True)


def run(code, *arguments):
    """Return how a process ended and what it wrote."""
    with tempfile.TemporaryDirectory() as folder:
        written = [Path(folder) / "stdout", Path(folder) / "stderr"]
        for path in written:
            path.touch()
        _ask(code, arguments, (os.devnull, *written))
        status = int(_clean().stdout.readline())
        return subprocess.CompletedProcess(code, status, *(path.read_bytes().decode() for path in written))


def on_terminal(code, *arguments, columns="80"):
    """Return all that a process writes on a terminal, and its status."""
    ours, theirs = pty.openpty()
    _ask(code, arguments, (os.ttyname(theirs),) * 3, TERM="xterm-256color", COLUMNS=columns)
    written, ended = b"", False
    while ready := select.select([ours] if ended else [ours, _clean().stdout], [], [], 0 if ended else None)[0]:
        ended = ended or _clean().stdout in ready
        if ours in ready:
            written += os.read(ours, 65536)
    for end in (ours, theirs):
        os.close(end)
    return written.decode(), int(_clean().stdout.readline())
