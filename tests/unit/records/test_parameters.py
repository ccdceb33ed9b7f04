"""Records with several records in one field: what holds for a record holds for each."""

from typing import Any

import numpy as np
import pytest

import poinsot as pt
from poinsot.files.scenario import read_scenario
from poinsot.records.members import members_of
from poinsot.records.parameters import Parametric
from poinsot.systems.named_parameters import NamedNumber, named_numbers

NEAR, FAR = (
    pt.orbits.FixedPosition(0.9, position=(0.8, -0.5, 0.7)),
    pt.KeplerOrbit(1.1, semimajor_axis=1.3, eccentricity=0.3, inclination=0.7),
)
BODY = pt.Body((1.3, 1.0, 0.7))


class Charge(Parametric):
    """A point that attracts along the first body axis."""

    orbit: pt.Orbit
    strength: float


class AttractionOfCharges(pt.Potential):
    """The sum over charges, and over orbits."""

    charges: tuple[Charge, ...] = ()
    orbits: tuple[pt.Orbit, ...] = ()

    def energy(self, instant):
        pairs = [(charge.orbit, charge.strength) for charge in self.charges] + [(orbit, 0.2) for orbit in self.orbits]
        terms = (k * instant.attitude.to_body(instant.direction(orbit))[0] ** 2 for orbit, k in pairs)
        return sum(terms, start=0.0)


class One(pt.Potential):
    """One of these terms."""

    orbit: pt.Orbit
    strength: float

    def energy(self, instant):
        return self.strength * instant.attitude.to_body(instant.direction(self.orbit))[0] ** 2


ALL = AttractionOfCharges([Charge(NEAR, 0.4), Charge(FAR, -0.3)], [FAR])
APART = (One(NEAR, 0.4), One(FAR, -0.3), One(FAR, 0.2))


def motion(*forces, members=()):
    start = BODY.state((0.1, 0.7, -0.5, 0.5), omega_body=np.broadcast_to((0.4, -0.6, 0.5), (*members, 3)))
    return pt.propagate(pt.System(BODY, *forces), start, np.linspace(0, 3, 4))


def test_a_motion_is_that_of_the_records_one_by_one():
    together, apart = motion(ALL), motion(*APART)
    # Sums in another order: rounding, amplified little in three units of time.
    assert np.max(np.abs(together.quaternion - apart.quaternion)) < 1e-14


def test_numbers_and_records_are_those_of_each_in_order():
    assert list(map(float, ALL.numbers)) == [float(x) for one in (*ALL.charges, FAR) for x in one.numbers]
    assert tuple(ALL.records) == (*ALL.charges, FAR)
    others = np.arange(len(ALL.numbers), dtype=float)
    copied = ALL.with_numbers(others)
    assert [float(x) for x in copied.numbers] == others.tolist()
    assert copied.structure == ALL.structure
    assert AttractionOfCharges(ALL.charges[:1], [FAR]).structure != ALL.structure


def test_names_have_the_place_of_each():
    system = pt.System(BODY, ALL)
    names = named_numbers(system)
    assert {"forces[0].charges[0].strength", "forces[0].charges[1].strength", "forces[0].charges[0].orbit.mu"} <= set(
        names
    )
    force: Any = NamedNumber(system, "charges[1].strength").system(0.7).forces[0]
    assert [float(charge.strength) for charge in force.charges] == [0.4, 0.7]
    assert force.charges[0] is ALL.charges[0]
    assert force.orbits[0] is FAR


def test_members_of_each():
    strengths = np.array([0.4, 0.1, -0.2])
    force = AttractionOfCharges([Charge(NEAR, strengths), Charge(FAR, -0.3)])
    every = motion(force)
    for i, strength in enumerate(strengths):
        one = motion(AttractionOfCharges([Charge(NEAR, strength), Charge(FAR, -0.3)]))
        assert np.max(np.abs(every.quaternion[i] - one.quaternion)) < 1e-14
    assert members_of(force, 2).charges[0].strength == -0.2
    assert np.array_equal(every.member(1).system.forces[0].charges[0].strength, 0.1)


def test_knots_are_those_of_each():
    times = np.linspace(0, 4, 21)
    position, velocity = (np.stack(np.broadcast_arrays(*f(times)), -1) for f in (FAR.position_at, FAR.velocity_at))
    table = pt.orbits.Ephemeris.from_table(1.1, times=times, positions=position, velocities=velocity)
    force = AttractionOfCharges([Charge(table, 0.4)], [table])
    assert np.array_equal(force.knots, times)
    assert np.max(np.abs(motion(force).quaternion - motion(One(table, 0.6)).quaternion)) < 1e-14


@pytest.mark.parametrize(
    ("given", "sentence"),
    [
        (NEAR, "orbits must be a list, each an Orbit, got FixedPosition"),
        ("near", "orbits must be a list, each an Orbit, got str"),
        ([NEAR, 3], r"orbits\[1\] must be an Orbit, got int"),
        ([pt.KeplerOrbit], r"orbits\[0\] must be an Orbit, got the class KeplerOrbit"),
    ],
)
def test_what_is_no_list_of_records_is_reported(given, sentence):
    with pytest.raises(TypeError, match=sentence):
        AttractionOfCharges((), given)


TEXT = """
[body]
moments = [1.3, 1.0, 0.7]

[state]
quaternion = [0.1, 0.7, -0.5, 0.5]
omega_body = [0.4, -0.6, 0.5]

[[forces]]
type = "AttractionOfCharges"
orbits = ["far"]

[[forces.charges]]
orbit = "near"
strength = 0.4

[[forces.charges]]
orbit = "far"
strength = -0.3

[orbits.near]
type = "FixedPosition"
mu = 0.9
position = [0.8, -0.5, 0.7]

[orbits.far]
type = "KeplerOrbit"
mu = 1.1
semimajor_axis = 1.3
eccentricity = 0.3
inclination = 0.7

[times]
stop = 3
count = 4
"""


def test_a_scenario_has_a_table_for_each(tmp_path):
    (tmp_path / "all.toml").write_text(TEXT)
    read = read_scenario(tmp_path / "all.toml").propagate()
    assert np.array_equal(read.quaternion, motion(ALL).quaternion)
    (tmp_path / "wrong.toml").write_text(TEXT.replace("strength = -0.3", "strenght = -0.3"))
    with pytest.raises(
        ValueError, match=r"line 19: unknown key 'strenght' in forces\[0\].charges\[1\]. Did you mean 'strength'\?"
    ):
        read_scenario(tmp_path / "wrong.toml")


class Steered(pt.Torque):
    """A class whose author writes an `__init__`, as in other packages."""

    gain: float

    def __init__(self, gain):
        self.gain = gain

    def torque(self, instant):
        return -self.gain * instant.omega_body


def test_a_record_that_is_changed_says_what_to_do_instead():
    hint = "got another value. Make another one; a class of your own needs no __init__, its annotated fields are its"
    with pytest.raises(AttributeError, match=rf"^Steered\.gain must stay as it was made, {hint} arguments\.$"):
        Steered(2.0)
    with pytest.raises(AttributeError, match=rf"^FixedPosition\.mu must stay as it was made, {hint} arguments\.$"):
        NEAR.mu = 3.0
    assert float(NEAR.mu) == 0.9


def test_internal_methods_are_not_listed():
    listed = dir(One(FAR, 1.0))
    assert {"orbit", "energy", "__init__"} <= set(listed)
    assert not {name for name in vars(Parametric) if not name.startswith("_")} & set(listed)

    class Structure(pt.Torque):
        """A torque with a field of the name of a method."""

        structure: float  # type: ignore[assignment]

        def torque(self, instant):
            return -self.structure * instant.omega

    assert "structure" in dir(Structure(1.0))


class Aimed(Parametric):
    """A record one of whose fields has alternatives, and one a shape."""

    target: pt.Orbit | Charge
    shape: pt.shapes.Shape
    gain: float


BALL = pt.shapes.Ellipsoid((1, 1, 1), mass=1.0)


def test_a_field_may_have_records_of_several_classes():
    on_orbit, on_charge = Aimed(NEAR, BALL, 2.0), Aimed(Charge(FAR, 0.3), BALL, 3.0)
    assert [*on_orbit.records] == [NEAR]
    assert len(on_orbit.numbers) == len(NEAR.numbers) + 1
    assert [name for name, _ in on_charge.number_names()][-2:] == ["target.strength", "gain"]
    copied = on_charge.with_numbers(2 * x for x in on_charge.numbers)
    assert (float(copied.target.strength), float(copied.gain), copied.shape) == (0.6, 6.0, BALL)
    assert on_orbit.structure != on_charge.structure
    assert Aimed(NEAR, BALL, 5.0).structure == on_orbit.structure


def test_a_field_of_several_classes_refuses_others():
    with pytest.raises(TypeError, match=r"^target must be an Orbit or a Charge, got Ellipsoid\.$"):
        Aimed(BALL, BALL, 1.0)
    with pytest.raises(TypeError, match=r"^shape must be a Shape, got KeplerOrbit\.$"):
        Aimed(NEAR, FAR, 1.0)
