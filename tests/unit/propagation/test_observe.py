"""Tests of readings along motions: bodies, members, times between rows, absent readings."""

import pickle

import numpy as np
import pytest

import poinsot as pt
from poinsot.observables import Readings

BODY = pt.Body((1.25, 1.0, 0.75))
START = BODY.state((1, 0, 0, 0), omega_body=(0.1, 0.3, 2))
TIMES = np.array([0.0, 1.0, 2.5])


class Rate(pt.Observable):
    bias: pt.BodyVector = (0, 0, 0)
    components = ("x", "y", "z")
    frame = "body"

    def reading(self, instant):
        return instant.omega_body + self.bias

    def unit(self, units):
        return units.rate


class Elevation(pt.Observable):
    """First component of the direction of an orbit, body axes; blind where it is negative."""

    orbit: pt.Orbit

    def reading(self, instant):
        return instant.attitude.to_body(instant.direction(self.orbit))[0]

    def validity(self, instant):
        return {"below the horizon": pt.functions.less(self.reading(instant), 0.0)}


class Distance(pt.Observable):
    orbit: pt.Orbit

    def reading(self, instant):
        return pt.functions.norm(instant.position(self.orbit))


class Delayed(pt.Observable):
    delay: float

    def reading(self, instant):
        return instant.attitude.quaternion[0]

    def time_of_body(self, time, units):  # noqa: ARG002
        delay = np.asarray(self.delay)
        return time - delay[:, None] if delay.ndim else time - delay


def moved(times=TIMES, **options):
    return pt.propagate(pt.System(BODY, units={"time": "s"}), START, times, **options)


def test_readings_follow_the_motion():
    motion = moved()
    seen = pt.observe(motion, Rate((0.5, 0, 0)))
    assert np.array_equal(seen.values, motion.omega_body + np.array([0.5, 0, 0]))
    assert np.array_equal(seen.times, motion.times)
    assert seen.attributes["units"] == "rad s-1"
    assert seen.attributes["frame"] == "body"
    assert seen.attributes["time_units"] == "s"
    assert seen.attributes["system"] == repr(motion.system)
    assert seen.attributes["version_poinsot"] == pt.__version__


def test_several_observables_give_a_tuple():
    first, second = pt.observe(moved(), Rate(), Rate((1, 0, 0)))
    assert np.allclose(second.values - first.values, [1, 0, 0], rtol=0, atol=1e-15)


@pytest.mark.parametrize("dense", [True, False])
def test_times_between_the_rows(dense):
    motion, times = moved(dense=dense), np.array([0.25, 1.0, 2.0, 2.25])
    seen = pt.observe(motion, Rate(), times=times)
    assert np.allclose(seen.values, moved(times).omega_body, rtol=0, atol=1e-14)


def test_times_among_the_rows_are_not_computed_again():
    motion = moved()
    assert np.array_equal(pt.observe(motion, Rate(), times=TIMES[[0, 2]]).values, motion.omega_body[[0, 2]])
    assert np.array_equal(pt.observe(motion, Rate(), times=TIMES[::-1]).values, motion.omega_body[::-1])


def test_a_plan_gives_times_and_sigma():
    plan = Readings(Rate(), [2.5, 0.0, 0.0, 1.0], sigma=[0.1, 0.2, 0.3, 0.4], name="gyro")
    seen = pt.observe(moved(), plan)
    assert np.array_equal(seen.values, moved().omega_body[[2, 0, 0, 1]])
    assert seen.name == "gyro"
    assert np.array_equal(seen.sigma[:, 0], [0.1, 0.2, 0.3, 0.4])
    with pytest.raises(ValueError, match=r"times must not be given for readings, which have times"):
        pt.observe(moved(), plan, times=[0.0])


def test_members_of_states():
    start = BODY.state((1, 0, 0, 0), omega_body=np.array([[0.1, 0.3, 2], [1, 0.1, 0.2]]))
    motion = pt.propagate(pt.System(BODY), start, TIMES)
    seen = pt.observe(motion, Rate())
    assert np.array_equal(seen.values, motion.omega_body)
    between = pt.observe(motion, Rate(), times=[0.5, 1.0])
    for i in (0, 1):
        assert np.array_equal(seen.isel(member=i).values, pt.observe(motion.member(i), Rate()).values)
        assert np.allclose(
            between.values[i], pt.observe(motion.member(i), Rate(), times=[0.5, 1.0]).values, rtol=0, atol=1e-14
        )


def test_members_of_numbers_and_orbits():
    bias, directions = np.array([[0.1, 0, 0], [0, 0.2, 0]]), np.array([[3.0, 0, 0.1], [0, 1, 0.5]])
    orbit = pt.orbits.FixedPosition(1.0, position=directions)
    start = BODY.state((1, 0, 0, 0), omega_body=np.array([[0.1, 0.3, 2], [1, 0.1, 0.2]]))
    ensemble = pt.propagate(pt.System(BODY), start, TIMES)

    class Sight(Elevation):
        def validity(self, instant):  # noqa: ARG002
            return {}

    for motion in (moved(), ensemble):
        rates, sights = pt.observe(motion, Rate(bias), Sight(orbit))
        for i in (0, 1):
            one = motion.member(i) if motion.is_ensemble else motion
            alone = Sight(pt.orbits.FixedPosition(1.0, position=directions[i]))
            assert np.array_equal(rates.values[i], pt.observe(one, Rate(bias[i])).values)
            assert np.allclose(sights.values[i], pt.observe(one, alone).values, rtol=0, atol=1e-15)


def test_members_must_be_as_many():
    start = BODY.state((1, 0, 0, 0), omega_body=np.ones((3, 3)))
    with pytest.raises(ValueError, match=r"observable must have as many members as the motion, 3, got 2\."):
        pt.observe(pt.propagate(pt.System(BODY), start, TIMES), Rate(np.zeros((2, 3))))


@pytest.mark.parametrize("dense", [True, False])
def test_light_from_before_the_first_time(dense):
    seen = pt.observe(moved(dense=dense), Delayed(0.7))
    earlier = moved(TIMES - 0.7).quaternion[:, 0]
    assert np.allclose(seen.values, earlier, rtol=0, atol=1e-14)


def test_orbits_that_are_known_for_a_short_time():
    def along(times):
        return np.stack([3 + times, 0 * times, 0 * times], axis=-1)

    orbit = pt.orbits.Ephemeris.from_function(1.0, position=along, start=2.0, stop=2.1)
    seen = pt.observe(moved(), Distance(orbit), times=[2.0, 2.05, 2.1])
    assert np.allclose(seen.values, [5.0, 5.05, 5.1], rtol=1e-12, atol=0)


def test_light_times_of_members():
    motion = moved(np.linspace(0, 3, 7))
    seen = pt.observe(motion, Delayed([0.5, 0.25])).values
    for i, delay in enumerate((0.5, 0.25)):
        alone = pt.observe(motion, Delayed(delay)).values
        assert np.array_equal(seen[i], alone)
        assert np.allclose(alone, moved(motion.times - delay).quaternion[:, 0], rtol=0, atol=1e-14)


def pair_motion():
    ball = pt.Body.from_ellipsoid(2.0, (1.2, 1.0, 0.8))
    pair = pt.TwoBodies(ball, ball, 1.0)
    state = pair.state((4, 0, 0), (0, 1, 0), [(1, 0, 0, 0)] * 2, omega_body=[(0.1, 0, 1), (0, 0.2, 0.5)])
    return pt.propagate(pt.System(pair, pt.forces.MutualGravity()), state, TIMES)


def test_one_of_two_bodies():
    motion = pair_motion()
    seen = pt.observe(motion, Rate().on("secondary"))
    assert np.array_equal(seen.values, motion.secondary.omega_body)
    assert np.array_equal(pt.observe(motion.secondary, Rate()).values, seen.values)
    assert seen.name == "Rate of the secondary"
    assert repr(seen.observable) == "Rate(bias=[0.0, 0.0, 0.0]).on('secondary')"


def test_positions_of_one_of_two_bodies_are_of_its_centre():
    class Place(pt.Observable):
        orbit: pt.Orbit
        components = ("x", "y", "z")

        def reading(self, instant):
            return instant.position(self.orbit)

    motion, orbit = pair_motion(), pt.orbits.FixedPosition(1.0, position=(7, 0, 0))
    for body, lever in (("primary", -0.5), ("secondary", 0.5)):
        for read in (pt.observe(motion, Place(orbit).on(body)), pt.observe(getattr(motion, body), Place(orbit))):
            assert np.allclose(read.values, [7, 0, 0] + lever * motion.position, rtol=1e-15, atol=1e-15)


def test_an_observable_of_one_body_must_be_on_one_of_two():
    with pytest.raises(TypeError, match=r"must be for the bodies of its system, but .* of two bodies"):
        pt.observe(pair_motion(), Rate())
    with pytest.raises(ValueError, match="body must be 'primary' or 'secondary', got 'third'"):
        Rate().on("third")


def test_absent_readings_are_nan_with_one_warning():
    orbit = pt.orbits.FixedPosition(1.0, position=(1, 0, 0.01))
    motion = moved(np.linspace(0, 3, 31))
    with pytest.warns(
        UserWarning, match=r"Elevation .* has none at some of 31 times: below the horizon at \d+"
    ) as caught:
        seen = pt.observe(motion, Elevation(orbit))
    assert len(caught) == 1
    expected = (motion.system.at(motion._reader.state).attitude.to_body((1, 0, 0.01))[0]) / np.hypot(1, 0.01)
    assert np.array_equal(np.isnan(seen.values), expected < 0)
    assert np.allclose(seen.values[expected >= 0], expected[expected >= 0], rtol=1e-14, atol=1e-15)
    assert "absent" in repr(seen)


def test_infinite_readings_are_absent():
    class Logarithm(pt.Observable):
        not_finite = "zero"

        def reading(self, instant):
            return pt.functions.log(instant.time)

    with pytest.warns(UserWarning, match="zero at 1"):
        seen = pt.observe(moved(), Logarithm())
    assert np.array_equal(np.isnan(seen.values), [True, False, False])


def test_rows_that_the_motion_does_not_reach_are_nan_without_a_warning():
    class Limit(pt.Event):
        terminal: bool = True

        def value(self, instant):
            return instant.time - 1.5

    start = BODY.state((1, 0, 0, 0), omega_body=np.array([[0.1, 0.3, 2], [1, 0.1, 0.2]]))
    motion = pt.propagate(pt.System(BODY), start, TIMES, events=[Limit()])
    seen = pt.observe(motion, Rate()).values
    assert np.isnan(seen[:, 2]).all()
    assert np.isfinite(seen[:, :2]).all()
    assert np.isnan(pt.observe(motion, Rate(), times=[1.25, 1.75]).values[:, 1]).all()
    one = pt.propagate(pt.System(BODY), START, TIMES, events=[Limit()])
    assert pt.observe(one, Rate(), times=[1.25, 1.75]).values.shape == (2, 3)


def test_motions_of_files_and_stores(tmp_path):
    start = BODY.state((1, 0, 0, 0), omega_body=np.random.default_rng(1).normal(size=(5, 3)))
    system = pt.System(BODY)
    motion = pt.propagate(system, start, TIMES)
    stored = pt.propagate(system, start, TIMES, out=tmp_path / "m.zarr", chunk=2)
    loaded = pt.load(pt.save(motion, tmp_path / "m.nc"))
    for other in (stored, loaded, pt.load(tmp_path / "m.zarr"), pickle.loads(pickle.dumps(motion))):
        assert np.array_equal(pt.observe(other, Rate()).values, motion.omega_body)
    assert pt.observe(loaded, Rate(), times=[0.5]).values.shape == (5, 1, 3)

    class Friction(pt.Torque):
        def torque(self, instant):
            return -0.1 * instant.omega_body

    own = pt.propagate(pt.System(BODY, Friction()), START, TIMES)
    unknown = pt.load(pt.save(own, tmp_path / "own.nc"))
    assert np.array_equal(pt.observe(unknown, Rate()).values, own.omega_body)
    with pytest.raises(ValueError, match=r"times must be among the times of a motion without formulas"):
        pt.observe(unknown, Rate(), times=[0.5])


def test_arguments():
    motion = moved()
    with pytest.raises(TypeError, match="observe must have at least one observable after the motion, got none"):
        pt.observe(motion)
    with pytest.raises(TypeError, match=r"observable must be an instance, got the class Rate\. Write Rate\(\.\.\.\)\."):
        pt.observe(motion, Rate)
    with pytest.raises(TypeError, match="observable must be an Observable or Readings, got"):
        pt.observe(motion, 3.0)
    with pytest.raises(TypeError, match="motion must be a Trajectory"):
        pt.observe(Rate(), motion)
    with pytest.raises(ValueError, match="strictly monotonic"):
        pt.observe(motion, Rate(), times=[0.0, 0.0])


def test_formulas_are_tried_first():
    class Two(pt.Observable):
        components = ("x", "y")

        def reading(self, instant):
            return instant.omega_body

    class Branch(pt.Observable):
        def reading(self, instant):
            return 1.0 if instant.time > 1 else 0.0

    with pytest.raises(TypeError, match=r"the reading of Two must be 2 scalars, got 3 components"):
        pt.observe(moved(), Two())
    with pytest.raises(TypeError, match=r"must not branch with `if`"):
        pt.observe(moved(), Branch())


def ephemeris(stop, frame):
    return pt.orbits.Ephemeris.from_pieces(
        1.0, knots=[0.0, stop], coefficients=[[[3.0], [0.0], [1.0]]], reference_frame=frame
    )


def test_times_outside_of_an_ephemeris():
    table = ephemeris(2.0, "space axes")
    with pytest.raises(ValueError, match=r"times must lie within the span of .* Elevation, \[0\.0, 2\.0\], got 2\.5"):
        pt.observe(moved(), Elevation(table))


def test_axes_of_system_and_observable_must_agree():
    first, second = ephemeris(9.0, "J2000"), ephemeris(9.0, "ECLIPJ2000")
    system = pt.System(BODY, pt.GravityGradient(first))
    motion = pt.propagate(system, START, TIMES)
    with pytest.raises(ValueError, match="must have one reference frame"):
        pt.observe(motion, Elevation(second))


def test_a_plan_with_a_calendar_has_the_unit_of_time_of_the_motion():
    body = pt.Body((1.25, 1.0, 0.75))
    start, times = body.state((1, 0, 0, 0), omega_body=(0.1, 1.0, 0.2)), [0.0, 1.0]
    motion = pt.propagate(pt.System(body, units={"time": "s"}), start, times)
    days, seconds = (pt.Calendar("2012-10-10", "TDB", unit) for unit in ("d", "s"))
    seen = pt.observe(motion, pt.observables.Readings(pt.observables.Gyro(), times, calendar=seconds))
    assert seen.calendar == seconds
    assert seen.attributes["time_units"] == "s"
    message = r"the calendar of readings must count in the unit of time of the system, 's', got one that counts 'd'"
    plan = pt.observables.Readings(pt.observables.Gyro(), times, calendar=days)
    far = pt.orbits.Ephemeris.from_function(
        1.0, position=lambda t: np.stack([2 + t, t, t], axis=-1), start=-1.0, stop=2.0, calendar=days
    )
    for each in (plan, pt.observables.VectorSensor(far)):
        with pytest.raises(ValueError, match=message):
            pt.observe(motion, each)
