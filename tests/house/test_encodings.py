"""File names and terminals in ASCII: one message each, and text that stays readable."""

import os
import subprocess
import sys

import pytest

pytestmark = pytest.mark.skipif(os.name == "nt", reason="file names of Windows are in UTF-16")

IN_ASCII = {"PYTHONUTF8": "0", "PYTHONCOERCECLOCALE": "0", "LC_ALL": "C"}

SAVE = """
import sys
import poinsot as pt
assert sys.getfilesystemencoding() == "ascii"
body = pt.Body((1.25, 1.0, 0.75))
motion = pt.propagate(pt.System(body), body.state((0, 0.6, 0, 0.8), omega_body=(0, 1, 2)), [0.0, 1.0])
for name in ("\\xe9.nc", "\\udcc3\\udca9.nc"):
    try:
        pt.save(motion, name)
    except (TypeError, ValueError) as error:
        print(error)
"""
"""A name as another process writes it, and as this one receives it from the system."""


def printed(*arguments, folder, **environment):
    program = [sys.executable, *arguments]
    found = subprocess.run(program, cwd=folder, env=os.environ | environment, capture_output=True, check=False)
    return found.returncode, found.stdout.decode("ascii"), found.stderr.decode("ascii")


def test_names_beyond_the_encoding_of_file_names(tmp_path):
    terminal = {"PYTHONIOENCODING": "ascii:backslashreplace"}
    status, out, errors = printed("-c", SAVE, folder=tmp_path, **IN_ASCII, **terminal)
    first, second = out.splitlines()
    assert (status, errors) == (0, "")
    assert first.endswith("File names of this process are in ascii. Set PYTHONUTF8=1 in the environment for UTF-8.")
    assert second.startswith("\\udcc3\\udca9.nc must be a file that can be written, but its name contains characters ")
    assert second.endswith(". Set PYTHONUTF8=1 in the environment.")
    assert list(tmp_path.iterdir()) == []


COMMAND = ("-c", "import sys; from poinsot.cli import app; sys.argv[0] = 'poinsot'; app()")


def test_the_command_line_writes_escapes_where_the_terminal_has_no_such_letters(tmp_path):
    status, out, errors = printed(*COMMAND, "--help", folder=tmp_path, PYTHONIOENCODING="ascii")
    assert (status, errors) == (0, "")
    assert "\\u" in out
    assert "poinsot new" in out


def test_a_command_with_a_name_beyond_the_encoding_ends_in_one_sentence(tmp_path):
    assert printed(*COMMAND, "new", "top.toml", folder=tmp_path)[0] == 0
    status, out, errors = printed(*COMMAND, "run", "top.toml", "--out", "\xe9.nc", folder=tmp_path, **IN_ASCII)
    assert (status, out, errors.count("\n")) == (2, "", 1)
    assert "PYTHONUTF8=1" in errors
    assert sorted(path.name for path in tmp_path.iterdir()) == ["top.toml"]
