"""What follows from the modules was written: stubs, the JSON Schema and the tables of the pages."""

import subprocess
import sys
from pathlib import Path

ROOT = Path(__file__).parents[2]

CHANGED = """
from tools.face import ROOT, face
print(*(path.relative_to(ROOT) for path, text in face().items() if not path.exists() or path.read_text() != text))
"""


def test_make_face_has_been_run():
    """In another process, where no test has classes of its own."""
    done = subprocess.run([sys.executable, "-c", CHANGED], cwd=ROOT, capture_output=True, text=True, check=True)
    assert done.stdout.split() == [], "run `make face`"
