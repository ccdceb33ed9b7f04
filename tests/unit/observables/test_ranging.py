"""Tests of ranges and range rates against values with 50 digits, closed forms of light time, and wrong arguments."""

import json
from pathlib import Path

import numpy as np
import pytest

import poinsot as pt
from poinsot.algebra import quaternion as quat
from poinsot.functions import Vector
from poinsot.mechanics.environment import Environment
from poinsot.observables import Range, RangeRate
from poinsot.taylor.graph import Graph, tangents

EPS = np.finfo(float).eps
CASES = json.loads((Path(__file__).parents[2] / "oracles" / "radar_cases.json").read_text())["ranges"]
BODY = pt.Body((1.25, 1.0, 0.75))


class Line(pt.Orbit):
    """Straight line, the place of the body at the time 0 and its velocity."""

    mu: float
    start: pt.SpaceVector
    velocity: pt.SpaceVector

    def position_at(self, time):
        return Vector(self.start) + Vector(self.velocity) * time

    def velocity_at(self, time):  # noqa: ARG002
        return Vector(self.velocity)


def at(case, turn=(0.0, 0.0, 0.0)):
    q = np.array(case["quaternion"]) / np.linalg.norm(case["quaternion"])
    attitude = pt.Attitude.from_quaternion(q)
    small = quat.exponential(Vector(turn)) if isinstance(turn, Vector) else None
    attitude = attitude if small is None else attitude.turned(small)
    return pt.Instant(BODY, attitude, Environment(0.0), case["omega_body"])


@pytest.mark.parametrize("case", CASES)
def test_range_and_rate_agree_with_digits(case):
    station = Line(1.0, case["position_from_station"], case["velocity"])
    found = Range(station, case["reflector_body"]).reading(at(case))
    assert found == pytest.approx(case["range"], rel=4 * EPS, abs=0)
    rate = RangeRate(station, case["reflector_body"]).reading(at(case))
    # The products have the size of the speed, of which the rate is a part.
    assert rate == pytest.approx(case["range_rate"], rel=0, abs=32 * EPS * np.linalg.norm(case["velocity"]))


@pytest.mark.parametrize("case", CASES)
def test_derivatives_by_the_rotation_vector_agree_with_digits(case):
    station, graph = Line(1.0, case["position_from_station"], case["velocity"]), Graph()
    turn = Vector(graph.variable(0.0) for _ in range(3))
    reading = Range(station, case["reflector_body"]).reading(at(case, turn))
    found = [graph.evaluated(tangents([reading], {node: 1.0}))[0] for node in turn]
    assert np.allclose(found, case["range_by_rotation_vector"], rtol=0, atol=16 * EPS)


def test_the_rate_is_the_derivative_of_the_range():
    station = pt.KeplerOrbit(398600.4418, semimajor_axis=7000.0, eccentricity=0.1, inclination=0.7)
    point, times = (1.0, -2.0, 0.5), np.linspace(0.0, 20.0, 11)
    system = pt.System(BODY)
    motion = pt.propagate(system, system.state((1, 0, 0, 0), omega_body=(0.1, 0.3, 0.2)), [0.0, 21.0], dense=True)
    h = 1e-3
    low, high = (pt.observe(motion, Range(station, point, light_time=False), times=times + s) for s in (0.0, 2 * h))
    rate = pt.observe(motion, RangeRate(station, point, light_time=False), times=times + h).values
    # Central differences err by h^2/6 of the third derivative, |p| omega^3 = 0.12, and by four roundings over 2 h.
    bound = 0.12 * h**2 / 6 + 4 * np.spacing(7000.0) / (2 * h)
    assert np.allclose((high.values - low.values) / (2 * h), rate, rtol=0, atol=bound)


def test_the_body_is_read_when_the_light_left_it():
    """On a radial line r = r0 + v t the light left at (t - r0 / c) / (1 + v / c)."""
    c, distance, speed = 299_792.458, 2.0e8, 40.0
    station = Line(1.0, (distance, 0.0, 0.0), (speed, 0.0, 0.0))
    system = pt.System(BODY, units={"time": "s", "inertia": "kg km2"})
    times = np.array([1000.0, 2000.0])
    emitted = (times - distance / c) / (1 + speed / c)
    motion = pt.propagate(system, system.state((1, 0, 0, 0), omega_body=(0, 0, 1e-3)), [0.0, 2000.0], dense=True)
    seen = pt.observe(motion, Range(station, (0, 3.0, 0)), times=times)
    x = distance + speed * emitted - 3.0 * np.sin(1e-3 * emitted)
    expected = np.hypot(x, 3.0 * np.cos(1e-3 * emitted))
    assert np.allclose(seen.values, expected, rtol=4 * EPS, atol=0)
    assert not np.allclose(
        seen.values, pt.observe(motion, Range(station, light_time=False), times=times).values, rtol=1e-8, atol=0
    )


def test_a_ground_station_reads_above_its_horizon_only():
    earth = pt.orbits.RotationModel(0.0, np.pi / 2, -np.pi / 2, rate=7.292115e-5)
    orbit = pt.KeplerOrbit(398600.4418, semimajor_axis=8000.0, eccentricity=0.0, inclination=0.5)
    station = pt.orbits.GroundStation(
        orbit, earth, latitude=0.3, longitude=0.1, minimum_elevation=0.2, equatorial_radius=6378.137
    )
    motion = pt.propagate(pt.System(BODY), BODY.state((1, 0, 0, 0), omega_body=(0, 0, 1)), np.linspace(0, 7000, 71))
    with pytest.warns(UserWarning, match=r"^Range must have .* below the minimum elevation at "):
        values = pt.observe(motion, Range(station, light_time=False)).values
    assert np.array_equal(np.isnan(values), station.elevation_at(motion.times) < 0.2)
    assert 40 < np.isnan(values).sum() < 70


def test_the_horizon_is_that_of_the_time_of_reception():
    """The light of an asteroid at 1.4 au is 11.7 minutes late, in which the Earth turns by 3 degrees."""
    earth = pt.orbits.RotationModel(0.0, np.pi / 2, -np.pi / 2, rate=7.292115e-5)
    far = pt.orbits.FixedPosition(1.0, position=(2.1e8, 0, 0.3e8))
    station = pt.orbits.GroundStation(far, earth, latitude=0.3, longitude=0.1, equatorial_radius=6378.137)
    system, times = pt.System(BODY, units={"time": "s", "inertia": "kg km2"}), np.linspace(0, 86400, 289)
    start = system.state((1, 0, 0, 0), omega_body=(0, 0, 1e-3))
    motion = pt.propagate(system, start, times)
    with pytest.warns(UserWarning, match="below the minimum elevation at"):
        values = pt.observe(motion, Range(station)).values
    assert np.array_equal(np.isnan(values), station.elevation_at(times) < 0)
    with pytest.warns(UserWarning, match="below the minimum elevation at"):
        partials = pt.analysis.observed_partials(system, start, Range(station, (1, 0, 0)), times[::48], ["latitude"])
    assert np.array_equal(np.isnan(partials.values), np.isnan(values[::48]))
    assert np.array_equal(np.isnan(partials.by_start).all(axis=-1), np.isnan(values[::48]))


def test_two_bodies_are_at_places_of_their_own():
    ball = pt.Body.from_ellipsoid(2.0, (1.2, 1.0, 0.8))
    pair = pt.TwoBodies(ball, ball, G=1.0)
    start = pair.state((4, 0, 0), (0, 1, 0), [(1, 0, 0, 0)] * 2, omega_body=[(0, 0, 0)] * 2)
    motion = pt.propagate(pt.System(pair, pt.forces.MutualGravity()), start, [0.0])
    station = pt.orbits.FixedPosition(1.0, position=(10, 0, 0))
    for body, expected in (("primary", 8.0), ("secondary", 12.0)):
        found = pt.observe(motion, Range(station, light_time=False).on(body)).values
        assert found == pytest.approx([expected], rel=1e-15, abs=0)


def test_units_follow_those_of_the_system():
    motion = pt.propagate(pt.System(BODY), BODY.state((1, 0, 0, 0), omega_body=(0, 0, 1)), [0.0])
    station = pt.orbits.FixedPosition(1.0, position=(10, 0, 0))
    with pytest.raises(ValueError, match=r"^light_time must have known units of time and length to be computed, "):
        pt.observe(motion, Range(station))
    with pytest.raises(ValueError, match=r"^noise must not be negative, got -1\.0\.$"):
        Range(station, noise=-1.0)
    with pytest.raises(TypeError, match=r"^station must be an Orbit, got str\.$"):
        Range("Graz")
