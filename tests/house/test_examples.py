"""Every example runs in an empty folder and passes its own checks."""

import runpy
from pathlib import Path

import matplotlib as mpl
import matplotlib.pyplot as plt
import pytest

EXAMPLES = sorted((Path(__file__).parents[2] / "examples").glob("*.py"))


SUPPLIED = "eros_light_curves"
"""The example that reads a file of the user."""


@pytest.mark.slow  # `make docs` runs them too, for the gallery
@pytest.mark.parametrize("example", [path for path in EXAMPLES if path.stem != SUPPLIED], ids=lambda path: path.stem)
def test_example_runs(example, tmp_path, monkeypatch):
    monkeypatch.chdir(tmp_path)
    mpl.use("Agg")
    runpy.run_path(str(example))
    plt.close("all")
    assert list(tmp_path.iterdir())


def test_an_example_without_the_file_of_the_user_ends_with_a_message(monkeypatch):
    monkeypatch.setattr("sys.argv", ["eros_light_curves.py"])
    with pytest.raises(SystemExit, match=r"^This example reads light curves of Eros .* DAMIT"):
        runpy.run_path(str(EXAMPLES[0].with_name(f"{SUPPLIED}.py")))
