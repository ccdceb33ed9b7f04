"""Tests of partial derivatives of readings: against differences of motions, of six points each."""

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

import poinsot as pt
from poinsot.algebra import quaternion as quat
from poinsot.analysis import observed_partials
from poinsot.observables import Lambert, LightCurve, LommelSeeliger, Readings
from poinsot.systems.named_parameters import NamedNumber

TIMES = np.array([0.0, 0.7, 3.0])
STEP = 3e-3
"""Step of the differences, whose error is about STEP^6 times a derivative, and rounding over the step."""
CLOSE = 3e-11


class Gyro(pt.Observable):
    bias: pt.BodyVector
    components = ("x", "y", "z")

    def reading(self, instant):
        return instant.omega_body + self.bias


class Sight(pt.Observable):
    """Formula of matrix, quaternion, orbit, time and a number, with or without light time."""

    orbit: pt.Orbit
    gain: float
    delayed: bool = False

    def reading(self, instant):
        u = instant.attitude.to_body(instant.direction(self.orbit))
        turn = instant.attitude.quaternion[1] ** 2
        return self.gain * u[0] * u[1] + u[2] + turn + pt.functions.sin(instant.time) * instant.omega_body[0]

    @property
    def light_path(self):
        return self.orbit if self.delayed else None


def difference(function):
    """Return the derivative at zero by six points."""
    value = {k: np.asarray(function(k * STEP)) for k in (-3, -2, -1, 1, 2, 3)}
    return (45 * (value[1] - value[-1]) - 9 * (value[2] - value[-2]) + value[3] - value[-3]) / (60 * STEP)


def turned(q, axis, angle):
    turn = np.zeros(4)
    turn[0], turn[1 + axis] = np.cos(angle / 2), np.sin(angle / 2)
    return quat.product(q, turn)


def moved(system, start, k, step):
    """Return the initial state with one coordinate of a body changed."""
    q, g = start.quaternion, start.angular_momentum_body
    own = {name: values.copy() for name, values in start.own.items()}
    if k < 3:
        q = turned(q, k, step)
    elif k < 6:
        g = g + step * np.eye(3)[k - 3]
    else:
        (name,) = own
        own[name] = own[name] + step
    return system.state(q, angular_momentum_body=g, time=start.time, **own)


def seen(system, start, observable, times=TIMES):
    return pt.observe(pt.propagate(system, start, times, dense=True), observable).values


def wheeled(orbit):
    wheel = pt.parts.ReactionWheel((0.6, 0, 0.8), 0.1)
    units = {"time": "s", "inertia": "kg km2"}
    system = pt.System(pt.Body((1.25, 1.0, 0.75)), wheel, pt.GravityGradient(orbit), units=units)
    return system, system.state((0.5, 0.5, -0.5, 0.5), omega_body=(0.1, 1.0, 0.2))


KEPLER = pt.KeplerOrbit(1.0, semimajor_axis=2.0, eccentricity=0.2)


@pytest.mark.parametrize("observable", [Gyro((0.1, 0, 0)), Sight(KEPLER, 1.5)], ids=["gyro", "sight"])
def test_derivatives_by_the_start_with_a_wheel(observable):
    system, start = wheeled(KEPLER)
    found = observed_partials(system, start, observable, TIMES)
    assert found.coordinates[-1] == "reaction_wheel.momentum"
    assert np.allclose(found.values, seen(system, start, observable), rtol=0, atol=1e-14)
    for k in range(7):
        expected = difference(lambda step, k=k: seen(system, moved(system, start, k, step), observable))
        assert np.allclose(found.by_start[..., k], expected, rtol=0, atol=CLOSE)


def test_derivatives_by_numbers_of_system_orbit_and_observable():
    system, start = wheeled(KEPLER)
    names = [
        "moments[0]",
        "moments[2]",
        "eccentricity",
        "mu",
        "gain",
        "bias",
    ]
    observables = [Gyro((0.1, 0, 0)), Sight(KEPLER, 1.5)]
    gyro, sight = observed_partials(system, start, observables, TIMES, names)
    assert gyro.parameters == (
        "body.moments[0]",
        "body.moments[2]",
        "forces[1].orbit.eccentricity",
        "forces[1].orbit.mu",
        "sight.gain",
        "gyro.bias[0]",
        "gyro.bias[1]",
        "gyro.bias[2]",
    )
    for i, name in enumerate(gyro.parameters[:4]):
        number = NamedNumber(system, name)

        def read(step, which, number=number):
            changed = number.system(number.value + step)
            own = observables[0] if which == 0 else Sight(changed.forces[1].orbit, 1.5)
            return seen(changed, start, own)

        assert np.allclose(gyro.by_parameters[..., i], difference(lambda step, f=read: f(step, 0)), rtol=0, atol=CLOSE)
        assert np.allclose(sight.by_parameters[..., i], difference(lambda step, f=read: f(step, 1)), rtol=0, atol=CLOSE)
    assert np.array_equal(gyro.by_parameters[..., 5:], np.broadcast_to(np.eye(3), (3, 3, 3)))
    assert np.array_equal(gyro.by_parameters[..., 4], np.zeros((3, 3)))
    expected = difference(lambda step: seen(system, start, Sight(KEPLER, 1.5 + step)))
    assert np.allclose(sight.by_parameters[:, 4], expected, rtol=0, atol=CLOSE)


def test_the_moments_enter_a_gyro_twice():
    """At the start the sensitivity S is zero, and the explicit term D of omega = g / I is not."""
    system, start = (
        pt.System(pt.Body((1.25, 1.0, 0.75))),
        pt.Body((1.25, 1.0, 0.75)).state((1, 0, 0, 0), omega_body=(0.1, 1.0, 0.2)),
    )
    found = observed_partials(system, start, Gyro((0, 0, 0)), [0.0], ["moments"])
    assert np.allclose(
        found.by_parameters[0], -np.diag([0.1, 1.0, 0.2] / np.array([1.25, 1.0, 0.75])), rtol=1e-15, atol=0
    )


@pytest.mark.parametrize("shared", [True, False])
def test_derivatives_of_the_light_time(shared):
    far = pt.KeplerOrbit(2e16, semimajor_axis=9e5, eccentricity=0.2, inclination=0.3)
    observable = Sight(far, 1.5, delayed=True)
    units = {"time": "s", "inertia": "kg km2"}
    body = pt.Body((1.25, 1.0, 0.75))
    system = pt.System(body, *([pt.GravityGradient(far)] if shared else []), units=units)
    start = body.state((0.5, 0.5, -0.5, 0.5), omega_body=(0.1, 1.0, 0.2))
    times = np.array([4.0, 6.0])
    found = observed_partials(system, start, observable, times, ["eccentricity"])

    def read(step):
        orbit = pt.KeplerOrbit(2e16, semimajor_axis=9e5, eccentricity=0.2 + 0.1 * step, inclination=0.3)
        own = pt.System(body, *([pt.GravityGradient(orbit)] if shared else []), units=units)
        motion = pt.propagate(own, start, np.linspace(-5, 10, 3), dense=True)
        return pt.observe(motion, Sight(orbit, 1.5, delayed=True), times=times).values

    assert np.allclose(found.values, read(0.0), rtol=0, atol=1e-13)
    assert np.allclose(0.1 * found.by_parameters[:, 0], difference(read), rtol=0, atol=CLOSE)
    fixed = observed_partials(
        system, start, Sight(far, 1.5), found.readings.observable.time_of_body(times, _units(system))
    )
    assert np.allclose(found.by_start, fixed.by_start, rtol=0, atol=1e-12)


def _units(system):
    from poinsot.records.units import DerivedUnits

    return DerivedUnits(system.units)


class Tracking(pt.Observable):
    """Distance of a point of the secondary from a point of the primary, which reads both bodies."""

    point: pt.BodyVector
    components = ("distance", "rate")

    def reading(self, instant):
        place = instant.separation + instant.secondary.attitude.to_space(self.point)
        along = instant.primary.attitude.to_body(instant.relative_velocity)
        return pt.functions.norm(place), along[0] * instant.secondary.omega_body[1]


def pair():
    bodies = pt.TwoBodies(*(pt.Body.from_ellipsoid(2.0, (1.2, 1.0, 0.8)) for _ in range(2)), 1.0)
    state = bodies.state(
        (4, 0, 0), (0, 1, 0), [(0.5, 0.5, 0.5, 0.5), (1, 0, 0, 0)], omega_body=[(0.1, 0, 1), (0, 0.2, 0.5)]
    )
    return pt.System(bodies, pt.forces.MutualGravity()), state


def changed_pair(start, name, step):
    """Return the state of two bodies with one coordinate changed."""
    kind, axis = name.rsplit("_", 1)
    unit = step * np.eye(3)[int(axis) - 1]
    each = dict(start.of_bodies)
    for body in ("primary", "secondary"):
        own = each[body]
        if kind == f"{body}.theta":
            q, g = turned(own.quaternion, int(axis) - 1, step), own.angular_momentum_body
        elif kind == f"{body}.g":
            q, g = own.quaternion, own.angular_momentum_body + unit
        else:
            continue
        each[body] = pt.State(q, 2 * quat.product(q, quat.pure(g)))
    position = start.position + unit * (kind == "position")
    momentum = start.momentum + unit * (kind == "momentum")
    return pt.PairState(position, momentum, each["primary"], each["secondary"])


def test_two_bodies():
    system, start = pair()
    observables = [Tracking((0.3, 0, 0.1)), Gyro((0, 0, 0)).on("secondary")]
    found = observed_partials(system, start, observables, TIMES, ["point[0]", "secondary.moments[1]"])
    assert found[1].parameters[0] == "tracking.point[0]"
    motion = pt.propagate(system, start, TIMES)
    for one, observable in zip(found, observables, strict=True):
        assert one.by_start.shape[-1] == 18
        assert np.allclose(one.values, pt.observe(motion, observable).values, rtol=0, atol=1e-13)

    for k, name in enumerate(found[0].coordinates):
        for one, observable in zip(found, observables, strict=True):
            expected = difference(lambda step, n=name, o=observable: seen(system, changed_pair(start, n, step), o))
            assert np.allclose(one.by_start[..., k], expected, rtol=0, atol=3e-10), name
    expected = difference(lambda step: seen(system, start, Tracking((0.3 + step, 0, 0.1))))
    assert np.allclose(found[0].by_parameters[..., 0], expected, rtol=0, atol=CLOSE)


@pytest.mark.parametrize("name", ["primary.theta_2", "secondary.theta_3", "secondary.g_1", "position_2", "momentum_3"])
def test_two_bodies_that_shadow_each_other(name):
    """The step is small, so that no face rises and no shadow passes a corner within it."""
    meshes = [pt.shapes.Ellipsoid(axes, density=1.0).mesh(80) for axes in ((1.2, 1.0, 0.8), (0.8, 0.7, 0.6))]
    bodies = pt.TwoBodies(*map(pt.Body.from_shape, meshes), 1.0)
    attitudes = [(0.5, 0.5, 0.5, 0.5), (1, 0, 0, 0)]
    start = bodies.state((3.5, 0, 0.1), (0, 1.6, 0), attitudes, omega_body=[(0.1, 0, 1), (0, 0.2, 0.5)])
    system, times, step = pt.System(bodies, pt.forces.MutualGravity()), [0.0, 0.75, 1.5], 1e-6
    sun, earth = (pt.orbits.FixedPosition(1.0, position=x) for x in ((-1e8, 2e6, 0), (-9e7, -2e7, 5e6)))
    laws = LommelSeeliger(0.2), Lambert(0.3)
    curve = LightCurve(
        tuple(meshes), laws[0], sun, earth, secondary_law=laws[1], kind="relative", light_time=False, shadows="exact"
    )
    alone = LightCurve(
        tuple(meshes), laws[0], sun, earth, secondary_law=laws[1], kind="relative", light_time=False, shadows=False
    )
    found = observed_partials(system, start, curve, times)
    assert np.all(found.values < pt.observe(pt.propagate(system, start, times), alone).values - 1e-4)
    high, low = (
        pt.observe(pt.propagate(system, changed_pair(start, name, x), times), curve).values for x in (step, -step)
    )
    column = found.by_start[:, found.coordinates.index(name)]
    assert np.allclose(column, (high - low) / (2 * step), rtol=0, atol=3e-10 + 1e-6 * np.max(np.abs(column)))


def test_members_of_states_numbers_and_observables():
    moments = np.array([[1.25, 1.0, 0.75], [1.5, 1.2, 1.0]])
    body = pt.Body(moments)
    system = pt.System(body)
    start = body.state((1, 0, 0, 0), omega_body=np.array([[0.1, 1.0, 0.2], [0.3, 0.2, 0.9]]))
    gains = np.array([1.5, 2.0])
    gyro, sight = Gyro(np.array([[0.1, 0, 0], [0, 0.2, 0]])), Sight(KEPLER, gains)
    many = observed_partials(system, start, [gyro, sight], TIMES, ["moments[1]", "gain"])
    for i in (0, 1):
        alone = [Gyro(gyro.bias[i]), Sight(KEPLER, gains[i])]
        one_body = pt.Body(moments[i])
        state = one_body.state((1, 0, 0, 0), omega_body=[(0.1, 1.0, 0.2), (0.3, 0.2, 0.9)][i])
        ones = observed_partials(pt.System(one_body), state, alone, TIMES, ["moments[1]", "gain"])
        for all_members, one in zip(many, ones, strict=True):
            for name in ("values", "by_start", "by_parameters"):
                assert np.allclose(getattr(all_members, name)[i], getattr(one, name), rtol=0, atol=1e-13)


def test_members_of_an_observable_of_one_body():
    body = pt.Body((1.25, 1.0, 0.75))
    start = body.state((1, 0, 0, 0), omega_body=(0.1, 1.0, 0.2))
    gains = np.array([1.5, 2.0, -1.0])
    many = observed_partials(pt.System(body), start, Sight(KEPLER, gains), TIMES, ["moments[1]", "gain"])
    assert many.by_start.shape == (3, 3, 6)
    for i, gain in enumerate(gains):
        one = observed_partials(pt.System(body), start, Sight(KEPLER, gain), TIMES, ["moments[1]", "gain"])
        for name in ("values", "by_start", "by_parameters"):
            assert np.allclose(getattr(many, name)[i], getattr(one, name), rtol=0, atol=1e-13)


def test_light_times_of_members():
    units = {"time": "s", "inertia": "kg km2"}
    body = pt.Body((1.25, 1.0, 0.75))
    system = pt.System(body, units=units)
    states = body.state((1, 0, 0, 0), omega_body=np.array([[0.1, 1.0, 0.2], [0.3, 0.2, 0.9]]))
    places = np.array([[3e5, 0, 1e5], [0, 6e5, 2e5]])
    observable = Sight(pt.orbits.FixedPosition(1.0, position=places), 1.5, delayed=True)
    one_state = body.state((1, 0, 0, 0), omega_body=(0.1, 1.0, 0.2))
    for start in (states, one_state):
        many = observed_partials(system, start, observable, TIMES, ["position[0]", "moments[0]"])
        for i in (0, 1):
            alone = Sight(pt.orbits.FixedPosition(1.0, position=places[i]), 1.5, delayed=True)
            own = (
                start
                if start is one_state
                else body.state((1, 0, 0, 0), omega_body=[(0.1, 1, 0.2), (0.3, 0.2, 0.9)][i])
            )
            one = observed_partials(system, own, alone, TIMES, ["position[0]", "moments[0]"])
            for name in ("values", "by_start", "by_parameters"):
                assert np.allclose(getattr(many, name)[i], getattr(one, name), rtol=0, atol=1e-12)


def test_orbits_from_tables():
    table = pt.orbits.Ephemeris.from_function(
        1.0, position=lambda t: np.stack([np.cos(t), np.sin(t), 0.5 + 0 * t], axis=-1), start=-1.0, stop=5.0
    )
    body = pt.Body((1.25, 1.0, 0.75))
    start = body.state((1, 0, 0, 0), omega_body=(0.1, 1.0, 0.2))
    system = pt.System(body)
    found = observed_partials(system, start, Sight(table, 1.5), TIMES, ["gain"])
    for k in range(6):
        expected = difference(lambda step, k=k: seen(system, moved(system, start, k, step), Sight(table, 1.5)))
        assert np.allclose(found.by_start[:, k], expected, rtol=0, atol=CLOSE)


def test_readings_give_times_in_any_order():
    body = pt.Body((1.25, 1.0, 0.75))
    start = body.state((1, 0, 0, 0), omega_body=(0.1, 1.0, 0.2))
    plan = Readings(Gyro((0, 0, 0)), [3.0, 0.0, 0.7, 0.0], sigma=0.1)
    found = observed_partials(pt.System(body), start, plan)
    sorted_times = observed_partials(pt.System(body), start, Gyro((0, 0, 0)), TIMES)
    assert np.array_equal(found.by_start, sorted_times.by_start[[2, 0, 1, 0]])
    assert found.readings.sigma == 0.1
    assert np.array_equal(found.readings.times, plan.times)


def test_derivatives_are_absent_where_the_reading_is():
    class Night(Sight):
        def validity(self, instant):
            return {"late": pt.functions.less(1.0, instant.time)}

    body = pt.Body((1.25, 1.0, 0.75))
    start = body.state((1, 0, 0, 0), omega_body=(0.1, 1.0, 0.2))
    with pytest.warns(UserWarning, match=r"Night must have a reading .* 3 times: late at 1\."):
        found = observed_partials(pt.System(body), start, Night(KEPLER, 1.5), TIMES, ["gain"])
    for array in (found.values, found.by_start, found.by_parameters):
        assert np.isnan(array[2]).all()
        assert np.isfinite(array[:2]).all()


def test_derivatives_are_absent_where_an_observer_does_not_see_the_body():
    class Window(pt.orbits.FixedPosition):
        def hidden_at(self, time):
            return {"behind a wall": pt.functions.less(1.0, time)}

    body = pt.Body((1.25, 1.0, 0.75))
    start = body.state((1, 0, 0, 0), omega_body=(0.1, 1.0, 0.2))
    with pytest.warns(UserWarning, match=r"Sight must have a reading .* 3 times: behind a wall at 1\."):
        found = observed_partials(pt.System(body), start, Sight(Window(1.0, position=(1, 2, 3)), 1.5), TIMES, ["gain"])
    for array in (found.values, found.by_start, found.by_parameters):
        assert np.isnan(array[2]).all()
        assert np.isfinite(array[:2]).all()


def test_the_dataset_names_the_columns():
    body = pt.Body((1.25, 1.0, 0.75))
    start = body.state((1, 0, 0, 0), omega_body=(0.1, 1.0, 0.2))
    data = observed_partials(pt.System(body), start, Gyro((0, 0, 0)), TIMES, ["bias"]).dataset
    assert data["by_start"].dims == ("time", "component", "coordinate")
    assert [*data.parameter_name.values] == ["gyro.bias[0]", "gyro.bias[1]", "gyro.bias[2]"]
    assert data["by_parameters"].sel(component="y", parameter_name="gyro.bias[1]").values.tolist() == [1.0] * 3


def test_a_second_observable_of_a_class_has_a_name_of_its_own():
    body = pt.Body((1.25, 1.0, 0.75))
    start = body.state((1, 0, 0, 0), omega_body=(0.1, 1.0, 0.2))
    first, second = Gyro((0, 0, 0)), Gyro((1, 0, 0))
    found = observed_partials(pt.System(body), start, [first, second], TIMES, ["gyro.bias[0]", "gyro_2.bias[0]"])
    assert found[0].by_parameters[0, 0].tolist() == [1.0, 0.0]
    assert found[1].by_parameters[0, 0].tolist() == [0.0, 1.0]


@pytest.mark.parametrize(
    ("names", "message"),
    [
        (["gian"], r"parameters must name single numbers of the system and the observables, got 'gian'\. Near: .*gain"),
        (["mass_of_nothing"], r"parameters must name single numbers"),
        (["gain", "gain"], r"parameters must name each number once, got 'sight\.gain' twice"),
    ],
)
def test_unknown_names(names, message):
    body = pt.Body((1.25, 1.0, 0.75))
    start = body.state((1, 0, 0, 0), omega_body=(0.1, 1.0, 0.2))
    with pytest.raises(ValueError, match=message):
        observed_partials(pt.System(body), start, Sight(KEPLER, 1.5), TIMES, names)


def test_arguments():
    body = pt.Body((1.25, 1.0, 0.75))
    system, start = pt.System(body), body.state((1, 0, 0, 0), omega_body=(0.1, 1.0, 0.2))
    with pytest.raises(ValueError, match="times must be given for an observable, got none"):
        observed_partials(system, start, Gyro((0, 0, 0)))
    with pytest.raises(ValueError, match="times must not be given for readings"):
        observed_partials(system, start, Readings(Gyro((0, 0, 0)), TIMES), TIMES)
    with pytest.raises(TypeError, match="observables must be"):
        observed_partials(system, start, 3.0, TIMES)
    with pytest.raises(ValueError, match=r"light_time must have known units of time and length"):
        observed_partials(system, start, Sight(KEPLER, 1.5, delayed=True), TIMES)


@settings(max_examples=15, deadline=None)
@given(st.lists(st.floats(-1.0, 1.0), min_size=4, max_size=4), st.lists(st.floats(-2.0, 2.0), min_size=3, max_size=3))
def test_no_rotation_of_space_changes_the_length_of_a_derivative(q, omega):
    """A rotation of all space rotates sight and attitude together: the derivative by theta stays."""
    if np.linalg.norm(q) < 0.1:
        q = [1.0, 0.0, 0.0, 0.0]
    turn = np.array(q) / np.linalg.norm(q)

    class Cosine(pt.Observable):
        direction: pt.SpaceVector

        def reading(self, instant):
            return instant.attitude.to_body(self.direction)[0]

    body = pt.Body((1.25, 1.0, 0.75))
    there = np.array([0.3, -0.5, 0.8])
    found = []
    for attitude, direction in (((1, 0, 0, 0), there), (turn, quat.rotate(turn, there))):
        start = body.state(attitude, omega_body=omega)
        found.append(observed_partials(pt.System(body), start, Cosine(direction), [0.0, 1.0]).by_start)
    assert np.allclose(*found, rtol=0, atol=1e-12)


def test_absent_readings_have_no_derivatives_and_one_warning():
    """The observer sees the night side of a ball during the whole time."""
    ball = pt.shapes.Ellipsoid((1, 1, 1), density=1.0)
    sun, observer = (pt.orbits.FixedPosition(1.0, position=(x, 0, 0)) for x in (1e8, -1e8))
    curve = pt.observables.LightCurve(
        ball, pt.observables.LommelSeeliger(0.2), sun, observer, kind="magnitude", light_time=False
    )
    body = pt.Body((1.25, 1.0, 0.75))
    start = body.state((1, 0, 0, 0), omega_body=(0.1, 1.0, 0.2))
    with pytest.warns(UserWarning, match=r"LightCurve must have a reading .* zero flux at 3\.") as seen:
        found = pt.analysis.observed_partials(pt.System(body), start, curve, [0.0, 1.0, 2.0], ["law.albedo"])
    assert len(seen) == 1
    assert np.isnan(found.values).all()
    assert np.isnan(found.by_start).all()
    assert np.isnan(found.by_parameters).all()


def test_members_that_are_read_apart_have_standard_deviations_of_their_own():
    body = pt.Body((1.25, 1.0, 0.75))
    system = pt.System(body, units={"time": "s", "inertia": "kg km2"})
    rates = [(0.1, 1.0, 0.2), (0.2, 1.0, 0.1)]
    start = body.state((1, 0, 0, 0), omega_body=rates)
    station = pt.orbits.FixedPosition(1.0, position=[(1e4, 2e4, 0), (2e4, 1e4, 0)])
    plan = pt.observables.Readings(pt.observables.Range(station, (1, 2, 3)), TIMES, sigma=[[1.0] * 3, [2.0] * 3])
    found = observed_partials(system, start, plan)
    assert np.array_equal(found.readings.sigma, plan.sigma)
    for i in range(2):
        alone = observed_partials(system, body.state((1, 0, 0, 0), omega_body=rates[i]), plan.isel(member=i))
        assert np.allclose(found.by_start[i], alone.by_start, rtol=1e-13, atol=1e-13)
