"""Keys of the tables of a scenario, derived from classes."""

import pytest

from poinsot.scenarios import registry
from poinsot.scenarios.builder import Parts
from poinsot.scenarios.registry import RENAMED, RENAMED_TYPES, makers

TEXT = """
[body]
moments = [3, 2, 1]
[state]
quaternion = [1, 0, 0, 0]
omega_body = [0, 0, 1]
[[forces]]
type = "UniformGravity"
weight = 2
center_of_mass = [0, 0, 1]
[times]
stop = 1
count = 2
[ensemble]
members = 3
seed = 1
[[ensemble.spread]]
of = "forces[0].weight"
size = 0.5
"""


@pytest.fixture
def renamed(monkeypatch):
    """Let `weight` of a uniform gravity have been `heaviness` in an earlier version."""
    monkeypatch.setitem(RENAMED, ("UniformGravity", "heaviness"), "weight")


@pytest.mark.usefixtures("renamed")
def test_files_of_earlier_versions_have_former_keys():
    now, before = (Parts(text, "it").system() for text in (TEXT, TEXT.replace("weight", "heaviness")))
    assert now.members == (3,)
    assert repr(now) == repr(before)
    assert "heaviness" not in repr(before)


@pytest.mark.usefixtures("renamed")
def test_a_key_is_given_once_under_either_name():
    with pytest.raises(ValueError, match=r"it, line 10: unknown key 'heaviness' in forces\[0\]"):
        Parts(TEXT.replace("weight = 2", "weight = 2\nheaviness = 2", 1), "it")


def test_former_keys_are_unknown_without_a_row():
    with pytest.raises(ValueError, match="it, line 9: unknown key 'heaviness'"):
        Parts(TEXT.replace("weight", "heaviness"), "it")


def test_rows_of_renamed_keys_name_a_present_key_of_their_type():
    known = {name: maker for group in registry.BASES for name, maker in makers(group).items()}
    for (kind, former), present in RENAMED.items():
        names = {key.name for key in known[kind].keys}
        assert present in names
        assert former not in names


ORBITS = """
[body]
moments = [3, 2, 1]
[state]
quaternion = [1, 0, 0, 0]
omega_body = [0, 0, 1]
[times]
stop = 1
count = 2
[calendar]
zero = "2026-01-01T00:00:00"
scale = "TDB"
[orbits.earth]
type = "planet_orbit"
body = "earth"
attractor = "sun"
start = "2026-01-01T00:00:00 TDB"
stop = "2026-01-02T00:00:00 TDB"
[orbits.converted]
type = "kilometres_to_metres"
orbit = "earth"
[orbits.total]
type = "composite_orbit"
orbits = ["converted", "converted"]
[[forces]]
type = "GravityGradient"
orbit = "total"
"""


def test_files_of_earlier_versions_have_former_types():
    before = ORBITS
    for former, present in RENAMED_TYPES.items():
        assert present in makers("orbit")
        assert former not in makers("orbit")
        before = before.replace(present, former)
    assert before.count("in_metres") == before.count("orbit_sum") == 1
    now, then = (Parts(text, "it").system() for text in (ORBITS, before))
    assert repr(now) == repr(then)
