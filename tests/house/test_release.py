"""What is released says the same everywhere: versions, and what the package needs."""

import re
import tomllib
from pathlib import Path

import poinsot as pt

ROOT = Path(__file__).parents[2]
PROJECT = tomllib.loads((ROOT / "pyproject.toml").read_text())["project"]
ON_CONDA = {"matplotlib": "matplotlib-base", "netCDF4": "netcdf4"}
"""Names of the same packages on conda-forge."""


def test_citation_and_recipe_have_the_version_of_the_package():
    assert f"\nversion: {pt.__version__}\n" in (ROOT / "CITATION.cff").read_text()
    assert f'\n  version: "{pt.__version__}"\n' in (ROOT / "recipe" / "recipe.yaml").read_text()


def test_the_recipe_needs_what_the_package_needs():
    _, _, run = (ROOT / "recipe" / "recipe.yaml").read_text().partition("\n  run:\n")
    listed = dict(re.findall(r"    - (\S+) >=(\S+)\n", run))
    needed = dict(each.split(">=") for each in PROJECT["dependencies"])
    assert listed == {"python": PROJECT["requires-python"].removeprefix(">=")} | {
        ON_CONDA.get(name, name): version for name, version in needed.items()
    }


def test_every_licence_that_the_project_names_is_there():
    assert PROJECT["license"] == "BSD-3-Clause AND MIT AND Apache-2.0"
    assert len(PROJECT["license-files"]) == 3
    assert all((ROOT / path).exists() for path in PROJECT["license-files"])
