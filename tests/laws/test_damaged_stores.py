"""The same call mends a store whatever file of it is damaged, and a damaged store is never read as a whole one."""

import shutil
from typing import Any

import numpy as np
import pytest
import xarray

import poinsot as pt

BODY = pt.Body((1.25, 1.0, 0.75))
START = BODY.state((1, 0, 0, 0), omega_body=np.linspace((0.1, 1, 0.2), (1, 2, 3), 5))
TIMES = np.linspace(0, 9, 4)


def energies(data):
    return xarray.Dataset({"energy": data["kinetic_energy"].max("time"), "size": ("side", [1.0, data.sizes["member"]])})


def motions(out):
    events = [pt.events.SpinFlip((0, 1, 0))]
    return pt.propagate(pt.System(BODY), START, TIMES, events=events, out=out, chunk=3, progress=False)


def reductions(out):
    return pt.free_motion(BODY, START, TIMES, out=out, chunk=3, reduce=energies)


def indicators(out):
    return pt.analysis.chaos_indicators(pt.System(BODY), START, TIMES[1:], out=out, chunk=3, progress=False)


STORES = {each.__name__: each for each in (motions, reductions, indicators)}


def flipped(path):
    content = bytearray(path.read_bytes())
    content[len(content) // 2] ^= 4
    path.write_bytes(content)


def cut_short(path):
    path.write_bytes(path.read_bytes()[:-1])


DAMAGES = {"flipped": flipped, "cut short": cut_short, "removed": lambda path: path.unlink()}


def contents(store):
    return {str(path.relative_to(store)): path.read_bytes() for path in store.rglob("*") if path.is_file()}


def numbers(found: Any):
    """Everything that is read of a result in a store."""
    data = found.dataset if isinstance(found, pt.Trajectory) else found
    return {name: np.asarray(each) for name, each in data.variables.items() if each.dtype.kind == "f"}


def read_or_refused(out):
    """What is read of a damaged store, None if it is refused: some descriptions are for other readers."""
    try:
        return numbers(pt.load(out))
    except ValueError as refused:
        if str(out) not in str(refused):
            raise
        return None


QUICK = ("reductions", "flipped")
CASES = [
    pytest.param(kind, damage, marks=() if (kind, damage) == QUICK else pytest.mark.slow)
    for kind in STORES
    for damage in DAMAGES
]


@pytest.mark.parametrize(("kind", "damage"), CASES)
def test_whatever_is_damaged_is_computed_again(kind, damage, tmp_path):
    compute, out = STORES[kind], tmp_path / "it.zarr"
    whole = numbers(compute(out))
    before, untouched = contents(out), tmp_path / "untouched.zarr"
    shutil.copytree(out, untouched)
    refused = 0
    for name in sorted(before):
        DAMAGES[damage](out / name)
        read = read_or_refused(out)
        refused += read is None
        for key, values in (read or {}).items():  # of a chunk that counts as missing there are none
            assert np.isin(values[np.isfinite(values)], whole[key]).all(), (name, key)
        if name == "zarr.json":  # which problem it is of is not known
            with pytest.raises(ValueError, match=r"^out must be a new name or the store of this problem, got "):
                compute(out)
            shutil.copyfile(untouched / name, out / name)
        compute(out)
        assert contents(out) == before, name
    assert refused > len(before) / 4


@pytest.mark.parametrize(
    "kind", ["reductions", *(pytest.param(one, marks=pytest.mark.slow) for one in ("indicators", "motions"))]
)
def test_whatever_folder_is_missing_is_made_again(kind, tmp_path):
    compute, out = STORES[kind], tmp_path / "it.zarr"
    compute(out)
    before = contents(out)
    folders = sorted(path.relative_to(out) for path in out.rglob("*") if path.is_dir())
    for name in folders:
        shutil.rmtree(out / name)
        compute(out)
        assert contents(out) == before, name
        elsewhere = tmp_path / "elsewhere"
        (out / name).rename(elsewhere)
        (out / name).symlink_to(elsewhere)
        there = contents(elsewhere)
        compute(out)
        assert contents(elsewhere) == there  # nothing is written through a link
        assert not (out / name).is_symlink()
        assert contents(out) == before, name
        shutil.rmtree(elsewhere)
