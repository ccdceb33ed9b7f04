"""Run the Python snippets of pages with the package that is installed: `python tools/snippets.py README.md`.

The snippets of a page run in order, as one program. A comment behind a `print` contains the numbers that it prints.
"""

from __future__ import annotations

import functools
import io
import os
import re
import sys
import tempfile
from collections import defaultdict
from pathlib import Path
from typing import Any

import matplotlib as mpl
import matplotlib.pyplot as plt
import numpy as np

__all__ = ["missing_numbers", "run_page"]

DECIMAL = r"(?<![(\d.:\w-])-?\d+\.\d+(?:e-?\d+)?(?![\d:])"


def run_page(page: Path) -> None:
    """Run the snippets of a page in the current folder; raise an error if a number in a comment is not printed."""
    names: dict[str, Any] = {"__name__": "snippet"}
    for number, code in enumerate(re.findall(r"```python\n(.*?)```", page.read_text(), re.DOTALL)):
        printed: dict[int, str] = defaultdict(str)
        names["print"] = functools.partial(_print, printed)
        exec(compile(code, f"{page.name}, snippet {number}", "exec", dont_inherit=True), names)  # noqa: S102 - our page
        lines = code.splitlines()
        for line, text in printed.items():
            if missing_numbers(lines[line - 1].rpartition("  # ")[2], text):
                raise AssertionError(f"{lines[line - 1]}\n{text}")
    plt.close("all")


def missing_numbers(comment: str, text: str) -> list[str]:
    """Return the decimal numbers of a comment that are not in a text, up to a unit of the last digit."""
    found = np.array([float(x) for x in re.findall(r"-?\d+\.?\d*(?:e[+-]?\d+)?", text)])
    missing = []
    for number in re.findall(DECIMAL, comment):
        digits, _, power = number.partition("e")
        unit = 10.0 ** (int(power or 0) - len(digits.partition(".")[2]))
        if not np.any(np.abs(found - float(number)) < unit):
            missing.append(number)
    return missing


def _print(printed: dict[int, str], *values: object) -> None:
    """Print values, and store the text with the line of the snippet."""
    text = io.StringIO()
    print(*values, file=text)
    print(text.getvalue(), end="")
    printed[sys._getframe(1).f_lineno] += text.getvalue()


if __name__ == "__main__":
    mpl.use("Agg")
    pages = [Path(name).resolve() for name in sys.argv[1:]]
    with tempfile.TemporaryDirectory() as folder:
        os.chdir(folder)
        for each in pages:
            run_page(each)
        os.chdir("/")
