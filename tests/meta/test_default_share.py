"""The default run takes the same share of large tests in every process, and `-m slow` exactly the rest."""

import os
import subprocess
import sys
from pathlib import Path

TESTS = Path(__file__).parents[1]
MODULE = """
import pytest

COLOURS = [*"abcdefghijkl"]


@pytest.fixture(params=range(9))
def number(request):
    return request.param


@pytest.mark.parametrize("colour", COLOURS)
@pytest.mark.parametrize("size", range(12))
def test_product(colour, size):
    pass


@pytest.mark.parametrize("colour", COLOURS)
def test_the_same_list(colour):
    pass


@pytest.mark.parametrize(("one", "another"), [(1, x) for x in "abcdefghijkl"])
def test_a_list_of_its_own(one, another):
    pass


@pytest.mark.samples
@pytest.mark.parametrize("seed", range(12))
def test_samples(seed):
    pass


@pytest.mark.parametrize("side", [pytest.param(1, marks=pytest.mark.slow), 2])
def test_with_a_fixture(number, side):
    pass


@pytest.mark.parametrize("few", range(3))
def test_few(few):
    pass


def test_one():
    pass
"""


def collected(folder, seed, *options):
    """Return the cases that a process of its own would run: name of the test and its entries."""
    command = [sys.executable, "-m", "pytest", "--collect-only", "-q", "-p", "default_share", "--rootdir", folder]
    (folder / "pytest.ini").write_text("[pytest]\nmarkers =\n    slow: the rest\n    samples: alike\n")
    (folder / "test_large.py").write_text(MODULE)
    own = {"PYTHONPATH": str(TESTS), "PYTHONHASHSEED": seed, "PYTEST_DISABLE_PLUGIN_AUTOLOAD": "1"}
    output = subprocess.check_output([*command, *options], text=True, cwd=folder, env=os.environ | own)
    return [line.split("::")[1] for line in output.splitlines() if "::" in line]


def of(cases, test):
    return [case.partition("[")[2].rstrip("]").split("-") for case in cases if case.partition("[")[0] == test]


def test_share_and_rest_are_all_cases_in_every_process(tmp_path):
    share, rest = (collected(tmp_path, "1", "-m", mark) for mark in ("not slow", "slow"))
    assert share == collected(tmp_path, "2", "-m", "not slow")
    assert not set(share) & set(rest)
    assert sorted(share + rest) == sorted(collected(tmp_path, "3"))
    product = of(share, "test_product")
    assert 36 <= len(product) <= 48  # of 144
    assert {size for size, _ in product} == {str(size) for size in range(12)}
    assert {colour for _, colour in product} == {*"abcdefghijkl"}
    assert len(of(share, "test_the_same_list")) == len(of(share, "test_samples")) == 3
    assert len(of(share, "test_a_list_of_its_own")) == 12
    assert sorted(of(share, "test_with_a_fixture")) == [[str(number), "2"] for number in range(9)]
    assert len(of(share, "test_few")) == 3
    assert "test_one" in share


def test_who_names_one_test_gets_every_entry(tmp_path):
    assert len(collected(tmp_path, "1", "-m", "not slow", "test_large.py::test_the_same_list")) == 12
