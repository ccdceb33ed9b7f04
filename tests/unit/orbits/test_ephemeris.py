"""Orbits from tables and functions: polynomials between knots, at each of which a kernel stops."""

import re
from typing import Any

import numpy as np
import pytest

import poinsot as pt
from poinsot.orbits import piecewise_chebyshev

KEPLER = pt.KeplerOrbit(
    398600.4418,
    semimajor_axis=7000.0,
    eccentricity=0.1,
    inclination=0.9,
    node=0.3,
    argument_of_periapsis=0.5,
    true_anomaly=0.2,
)
T = KEPLER.period
BODY = pt.Body((400.0, 500.0, 600.0))
ROUNDING = 4 * np.spacing(6 * T) * 8.3  # of a time, in kilometres of the way: 2.4e-10
START = BODY.state((0.5, 0.5, 0.5, 0.5), omega_body=(0.001, 0.0, 0.001))


def place(times):
    return np.stack(list(KEPLER.position_at(times)), axis=-1)


def speed(times):
    return np.stack(list(KEPLER.velocity_at(times)), axis=-1)


def table(rows):
    return pt.orbits.Ephemeris.from_table(KEPLER.mu, times=rows, positions=place(rows), velocities=speed(rows))


@pytest.fixture(scope="module")
def fitted():
    return pt.orbits.Ephemeris.from_function(KEPLER.mu, position=place, start=-T, stop=6 * T)


@pytest.fixture(scope="module")
def tabulated():
    return table(np.linspace(-T, 6 * T, 701))


def apart(ephemeris, first=-T, last=6 * T):
    """The largest errors of position and velocity."""
    times = np.linspace(first, last, 20011)
    return (
        np.max(np.linalg.norm(np.stack(list(got), axis=-1) - expected, axis=-1))
        for got, expected in (
            (ephemeris.position_at(times), place(times)),
            (ephemeris.velocity_at(times), speed(times)),
        )
    )


def test_a_fit_is_right_to_its_tolerance_and_says_its_error(fitted):
    position, velocity = apart(fitted)
    assert position < 1e-13 * 7700 * 2
    assert fitted.error / 3 < position < 3 * fitted.error
    assert velocity < 1e-10
    assert fitted.position_jump < 2e-11
    assert fitted.velocity_jump < 2e-10


def test_a_looser_fit_has_fewer_pieces(fitted):
    loose = pt.orbits.Ephemeris.from_function(KEPLER.mu, position=place, start=-T, stop=6 * T, tolerance=1e-6)
    assert len(loose.knots) < 0.4 * len(fitted.knots)
    position, _ = apart(loose)
    assert loose.error / 3 < position < 3 * loose.error < 3e-6 * 7700


@pytest.mark.parametrize(("rows", "bound"), [(71, 1.0), (141, 1e-2), (351, 1e-5), (701, 2e-9), (7001, 1e-10)])
def test_a_table_says_its_error(rows, bound):
    ephemeris = table(np.linspace(-T, 6 * T, rows))
    position, _ = apart(ephemeris)
    assert position < bound
    assert position / 3 < ephemeris.error + ROUNDING < 30 * position


def test_a_table_keeps_its_rows(tabulated):
    rows = np.linspace(-T, 6 * T, 701)
    assert np.max(np.abs(np.stack(list(tabulated.position_at(rows)), axis=-1) - place(rows))) < ROUNDING
    assert np.max(np.abs(np.stack(list(tabulated.velocity_at(rows)), axis=-1) - speed(rows))) < 4e-11
    assert tabulated.position_jump < 3e-11


def test_the_noise_of_a_table_is_its_error(rng):
    rows = np.linspace(-T, 6 * T, 701)
    noisy = pt.orbits.Ephemeris.from_table(
        KEPLER.mu, times=rows, positions=place(rows) + 1e-3 * rng.normal(size=(701, 3)), velocities=speed(rows)
    )
    assert 2e-4 < noisy.error < 1e-1  # 20 times the difference of two orders: nothing converges


def test_two_rows_make_a_cubic_of_unknown_error():
    ephemeris = table(np.array([0.0, 60.0]))
    assert np.isnan(ephemeris.error)
    position, _ = apart(ephemeris, 0, 60)
    assert position < 1e-3


def test_a_kink_is_found_between_two_knots():
    def bent(times):
        return np.stack([10 + np.abs(times - 1 / 3), 0 * times, 0 * times], axis=-1)

    ephemeris = pt.orbits.Ephemeris.from_function(1.0, position=bent, start=0.0, stop=1.0)
    assert np.min(np.abs(ephemeris.knots - 1 / 3)) < 2.0**-25  # a piece as short as that ends the bisection
    x, _, _ = ephemeris.position_at(np.array([0.2, 1 / 3, 0.9]))
    assert np.max(np.abs(x - [10 + 2 / 15, 10, 10 + 17 / 30])) < 4 * ephemeris.error < 8e-9


def steps(*places):
    """A circle that jumps by its number along z at each of some places."""

    def position(times):
        height = sum(((i + 1) * (times >= place) for i, place in enumerate(places)), 0 * times)
        return np.stack([np.cos(times), np.sin(times), height], axis=-1)

    return position


@pytest.mark.parametrize(
    ("places", "given"),
    [
        ((1 / 3,), "a jump of 1 at t = 0.3333333333"),
        ((1 / 3, 2 / 3), "2 jumps, the largest of 2 at t = 0.6666666667"),
        ((0.5,), "a jump of 1 at t = 0.5"),
        ((0.25, 0.25 + 1e-6), "2 jumps, the largest of 2 at t = 0.250001"),
    ],
)
def test_a_jump_becomes_a_knot_with_a_warning(places, given):
    sentence = (
        f"the position relative to attractor must be continuous from start to stop, got {given}. The orbit jumps there"
        " too. End it before, or begin it after the jump."
    )
    with pytest.warns(UserWarning, match=f"^{re.escape(sentence)}$"):
        ephemeris = pt.orbits.Ephemeris.from_function(1.0, position=steps(*places), start=0.0, stop=1.0)
    assert set(places) <= set(ephemeris.knots)
    assert ephemeris.position_jump == pytest.approx(len(places), rel=1e-12, abs=0)
    assert ephemeris.velocity_jump < 1e-7  # rounding of 1e-16 over the shortest piece, 1e-6, times 144 for degree 12
    times = np.concatenate([np.linspace(0, 1, 1001), places, np.nextafter(places, 0)])
    found = np.stack(list(ephemeris.position_at(times)), axis=-1)
    assert np.max(np.abs(found - steps(*places)(times))) < ephemeris.error < 1e-12


@pytest.mark.parametrize("place", [0.0, 1.0])
def test_a_jump_at_an_end_is_outside(place):
    ephemeris = pt.orbits.Ephemeris.from_function(1.0, position=steps(place), start=0.0, stop=1.0)
    inside = np.linspace(0.001, 0.999, 1001)
    found = np.stack(list(ephemeris.position_at(inside)), axis=-1)
    assert np.max(np.abs(found - steps(place)(inside))) < ephemeris.error < 1e-12


def test_velocity_and_acceleration_are_derivatives(fitted):
    times, h = np.linspace(0, T, 101), 1e-2
    for derived, of in ((fitted.velocity_at, fitted.position_at), (fitted.acceleration_at, fitted.velocity_at)):
        difference = (np.array(list(of(times + h))) - np.array(list(of(times - h)))) / (2 * h)
        assert np.allclose(np.array(list(derived(times))), difference, rtol=0, atol=1e-7)
    pull = np.stack(list(fitted.acceleration_at(times)), axis=-1)
    distance = np.linalg.norm(place(times), axis=-1, keepdims=True)
    assert np.max(np.abs(pull + KEPLER.mu * place(times) / distance**3)) < 1e-11


def test_its_frame_is_that_of_the_orbit(fitted):
    times = np.linspace(-T, 6 * T, 1001)
    q, expected = fitted.frame.quaternion(times), KEPLER.frame.quaternion(times)
    assert np.max(np.abs(np.abs(np.sum(q * expected, axis=-1)) - 1)) < 1e-14
    assert np.min(np.sum(q[1:] * q[:-1], axis=-1)) > 0.9
    assert np.max(np.abs(fitted.frame.omega_space(times) - KEPLER.frame.omega_space(times))) < 1e-13


def test_the_frame_of_a_plane_that_turns():
    n, node = 1.0, 0.13
    ellipse = pt.KeplerOrbit(
        1.0, semimajor_axis=1.0, eccentricity=0.2, inclination=0.7, node=0.3, argument_of_periapsis=0.5
    )
    orbit = pt.orbits.PrecessingOrbit(ellipse, node_rate=node)
    found = pt.orbits.Ephemeris.from_function(
        1.0, position=lambda t: np.stack(list(orbit.position_at(t)), axis=-1), start=0, stop=20
    )
    h, times = 1e-5, np.linspace(1, 19, 40) / n
    ahead, behind = found.frame.attitude(times + h), found.frame.attitude(times - h)
    turned = (ahead * behind.inv()).as_rotvec() / (2 * h)
    assert np.max(np.abs(turned - found.frame.omega_space(times))) < 1e-9


@pytest.mark.parametrize("kind", ["fitted", "tabulated"])
@pytest.mark.parametrize(
    "ways", [{}, {"dense": True}, {"precision": "quadruple"}], ids=["double", "dense", "quadruple"]
)
def test_a_run_stops_at_knots(kind, ways, request):
    ephemeris = request.getfixturevalue(kind)
    times = np.linspace(-T, 6 * T, 71)
    expected = pt.propagate(pt.System(BODY, pt.GravityGradient(KEPLER)), START, times, precision="quadruple")
    motion = pt.propagate(pt.System(BODY, pt.GravityGradient(ephemeris)), START, times, **ways)
    assert np.max(np.abs(motion.quaternion - expected.quaternion)) < 1e-12
    assert motion.run.steps >= len(ephemeris.knots) - 1
    if "dense" in ways:
        assert np.max(np.abs(motion(times).quaternion - expected.quaternion)) < 1e-12


def test_members_stop_each_at_every_knot(fitted):
    rates = np.linspace([0.001, 0.0, 0.001], [0.004, 0.001, 0.001], 19)
    times = np.linspace(3 * T, -T / 2, 15)
    members = BODY.state(np.tile([0.5, 0.5, 0.5, 0.5], (19, 1)), omega_body=rates, time=np.linspace(0, T, 19))
    expected = pt.propagate(pt.System(BODY, pt.GravityGradient(KEPLER)), members, times)
    motion = pt.propagate(pt.System(BODY, pt.GravityGradient(fitted)), members, times)
    assert not motion.failures
    assert np.max(np.abs(motion.quaternion - expected.quaternion)) < 1e-12
    assert np.allclose(motion.potential_energy, expected.potential_energy, rtol=1e-11, atol=0)


def test_two_tables_with_different_knots(fitted, tabulated):
    twice = pt.System(BODY, pt.GravityGradient(fitted), pt.GravityGradient(tabulated))
    motion = pt.propagate(twice, START, [3 * T])
    expected = pt.propagate(pt.System(BODY, *[pt.GravityGradient(KEPLER)] * 2), START, [3 * T], precision="quadruple")
    assert np.max(np.abs(motion.quaternion - expected.quaternion)) < 1e-12


def test_a_run_to_the_very_ends_of_a_table(tabulated):
    motion = pt.propagate(pt.System(BODY, pt.GravityGradient(tabulated)), START, [-T, 0, 6 * T])
    assert np.all(np.isfinite(motion.quaternion))


def test_new_tables_compile_nothing(tabulated):
    other = table(np.linspace(-T, 6 * T, 699))
    assert tabulated.between_knots(0.0).structure == other.between_knots(0.0).structure


def test_nothing_is_conserved_along_a_table(fitted):
    assert pt.System(BODY, pt.GravityGradient(fitted)).integrals == ()
    assert any(
        i.name == "angular_momentum_body_3" for i in pt.System(pt.Body((1, 1, 2)), pt.GravityGradient(fitted)).integrals
    )


def test_a_single_time_gives_scalars(fitted):
    for part in (fitted.position_at, fitted.velocity_at, fitted.acceleration_at):
        assert [np.shape(component) for component in part(5.0)] == [()] * 3
    assert fitted.frame.quaternion(5.0).shape == (4,)
    assert fitted.frame.omega_space(5.0).shape == (3,)


def test_it_says_what_it_is(fitted):
    assert repr(fitted).startswith("Ephemeris(mu=398600.4418, ")
    assert fitted.span == (-T, 6 * T)
    assert (fitted.reference_frame, fitted.origin, fitted.calendar) == ("space axes", "attractor", None)


def test_orbits_along_different_axes_do_not_meet(fitted):
    named = [
        pt.orbits.Ephemeris.from_function(1.0, position=place, start=0, stop=T, tolerance=1e-6, reference_frame=name)
        for name in ("ICRF", "TEME", "ICRF")
    ]
    with pytest.raises(ValueError, match="the orbits of a system must have one reference frame, got ICRF and TEME"):
        pt.System(BODY, *map(pt.GravityGradient, named[:2]))
    pt.System(BODY, pt.GravityGradient(named[0]), pt.GravityGradient(named[2]), pt.GravityGradient(fitted))


@pytest.mark.parametrize("scale", [1.0, 1e-5, 1e5], ids=["s", "days", "ten microseconds"])
def test_the_unit_of_time_costs_no_digit(scale):
    """The engine's step control looks at the events of knots too."""
    slow = pt.KeplerOrbit(
        398600.4418 * scale**2,
        semimajor_axis=400000.0,
        eccentricity=0.05,
        inclination=0.3,
        node=0.1,
        argument_of_periapsis=0.2,
    )
    few = pt.orbits.Ephemeris.from_function(
        slow.mu,
        position=lambda t: np.stack(list(slow.position_at(t)), axis=-1),
        start=-1e6 / scale,
        stop=2e6 / scale,
        tolerance=1e-13,
    )
    body = pt.Body((1.0, 2.0, 3.0))
    start = body.state((0.5, 0.5, 0.5, 0.5), omega_body=np.array([0.05, 0.03, 0.1]) * scale)
    times = np.array([0.0, 2000.0, 20000.0]) / scale
    motion = pt.propagate(pt.System(body, pt.GravityGradient(few)), start, times)
    expected = pt.propagate(pt.System(body, pt.GravityGradient(slow)), start, times)
    assert np.max(np.abs(motion.quaternion - expected.quaternion)) < 3e-11
    assert np.max(np.abs(motion.norm_error)) < 2.5e-14
    assert motion.run.steps > 0.9 * expected.run.steps


def test_an_orbit_below_the_surface_warns():
    with pytest.warns(UserWarning, match=r"Ephemeris: the periapsis is 7[78].\d* below the surface \(distance 6300"):
        low = pt.orbits.Ephemeris.from_function(KEPLER.mu, position=place, start=0, stop=T, radius=6378.137)
    assert low.periapsis_distance == pytest.approx(6300, rel=1e-4)
    assert pt.orbits.Ephemeris.from_function(KEPLER.mu, position=place, start=0, stop=T, radius=6200.0).radius == 6200.0
    with pytest.warns(UserWarning, match=r"Oblateness: the periapsis is 78."):
        pt.forces.Oblateness(
            pt.orbits.Ephemeris.from_function(KEPLER.mu, position=place, start=0, stop=T), 1e-3, 6378.137, (0, 0, 1)
        )


def test_members_of_mu_are_shown():
    assert repr(pt.orbits.Ephemeris.from_function([1.0, 2.0], position=place, start=0, stop=T)).startswith(
        "Ephemeris(mu=[1.0, 2.0], "
    )


def test_steps_may_change_along_a_table():
    rows = np.concatenate([np.arange(0, 600, 20.0), np.arange(600, 3000, 60.0), np.arange(3000, 5000, 200.0)])
    assert np.array_equal(table(rows).knots, rows)


BAD = {
    "one row missing": (lambda _: table(np.delete(np.arange(0, 3000, 60.0), 20)), r"no gaps, but 120 lie between"),
    "two gaps side by side": (
        lambda _: table(np.delete(np.arange(0, 6000, 60.0), [*range(50, 60), *range(61, 70)])),
        r"no gaps, but 660 lie between times\[49\]",
    ),
    "units": (
        lambda _: pt.orbits.Ephemeris.from_table(
            1, times=(rows := np.arange(0, 600, 60.0)), positions=place(rows), velocities=1e3 * speed(rows)
        ),
        r"positions and velocities must be of one smooth motion, but from row to row they miss each other by .* units",
    ),
    "too coarse": (lambda _: table(np.linspace(0, 10 * T, 9)), r"must be of one smooth motion, .* rows near enough"),
    "equilibria": (
        lambda e: pt.analysis.equilibria(pt.System(BODY, pt.GravityGradient(e))),
        "system must be the same at all times",
    ),
    "equilibria in its frame": (
        lambda e: pt.analysis.equilibria(pt.System(BODY), e.frame),
        "frame must be the same at all times",
    ),
    "periodic motion": (
        lambda e: pt.analysis.periodic_motion(pt.System(BODY, pt.GravityGradient(e)), START, 4 * T),
        "period must fit twice into the span of the orbits",
    ),
    "outside": (
        lambda e: e.position_at(7 * T),
        r"within the span of the ephemeris, \[-5828.516637\d*, 34971.0998261\d*\], got 40799",
    ),
    "run outside": (
        lambda e: pt.propagate(pt.System(BODY, pt.GravityGradient(e)), START, [0, 7 * T]),
        r"times must lie within the span of orbits, fields and tables, \[-5828.51",
    ),
    "state outside": (
        lambda e: pt.propagate(
            pt.System(BODY, pt.GravityGradient(e)), BODY.state((1, 0, 0, 0), omega_body=(0, 0, 1), time=-1e5), [0]
        ),
        r"the state's time must lie within the span of orbits, fields and tables",
    ),
    "unsorted": (
        lambda _: table(np.array([0, 60, 50, 70.0])),
        r"times must rise strictly, got times\[1\] = 60 and times\[2\] = 50",
    ),
    "twice": (lambda _: table(np.array([0, 60, 60, 70.0])), r"times must rise strictly, .* remove repeated times"),
    "gap": (
        lambda _: table(np.array([0, 60, 120, 900, 960.0])),
        r"no gaps, but 780 lie between times\[2\] = 120 and the next, 13 times",
    ),
    "gap at the end": (lambda _: table(np.array([0, 60, 120, 900.0])), r"no gaps, but 780 lie between times\[2\]"),
    "one row": (lambda _: table(np.array([0.0])), r"times must be two or more, got 1"),
    "shape": (
        lambda _: pt.orbits.Ephemeris.from_table(1, times=[0, 1], positions=[[0, 0]], velocities=[[0, 0]]),
        r"positions must have shape \(2, 3\)",
    ),
    "order": (
        lambda _: pt.orbits.Ephemeris.from_function(1, position=place, start=1, stop=0),
        r"stop must be after start, got start = 1 and stop = 0",
    ),
    "function": (
        lambda _: pt.orbits.Ephemeris.from_function(1, position=lambda t: t, start=0, stop=1),
        r"position\(times\) must have shape \(23, 3\)",
    ),
    "mu": (lambda _: pt.orbits.Ephemeris.from_function(0, position=place, start=0, stop=1), r"mu must be positive"),
    "too long": (
        lambda _: pt.orbits.Ephemeris.from_function(1, position=place, start=0, stop=1e6 * T),
        r"so near that 2000 polynomials suffice",
    ),
}


@pytest.mark.parametrize("labels", [{"calendar": "2000-01-01"}, {"reference_frame": 3}, {"origin": ""}], ids=str)
def test_labels_are_checked(labels):
    with pytest.raises(TypeError, match=rf"^{next(iter(labels))} must be a "):
        pt.orbits.Ephemeris.from_function(1.0, position=place, start=0, stop=T, tolerance=1e-3, **labels)


def test_names_of_one_frame_are_one():
    named = [
        pt.orbits.Ephemeris.from_function(1.0, position=place, start=0, stop=T, tolerance=1e-3, reference_frame=x)
        for x in ("icrf", "GCRF", "EME2000")
    ]
    system: Any = pt.System(BODY, *map(pt.GravityGradient, named))
    assert system.forces[0].orbit.reference_frame == "ICRF"


@pytest.mark.parametrize("case", BAD)
def test_bad_input_gets_one_sentence(case, fitted, monkeypatch):
    monkeypatch.setattr(piecewise_chebyshev, "MAX_PIECES", 2000)
    call, sentence = BAD[case]
    with pytest.raises(ValueError, match=sentence):
        call(fitted)


def test_a_spike_is_found():
    """Some ten times shorter than a piece: a thousandth of the span."""

    def spike(times):
        return np.stack([10 + np.exp(-(((times - 0.123456) / 1e-4) ** 2)), 0 * times + 1, 0 * times], axis=-1)

    ephemeris = pt.orbits.Ephemeris.from_function(1.0, position=spike, start=-1.0, stop=1.0)
    times = np.linspace(0.122, 0.125, 3001)
    true = np.max(np.abs(np.stack(list(ephemeris.position_at(times)), axis=-1) - spike(times)))
    assert true < ephemeris.error < 1e-10


@pytest.mark.parametrize("seed", range(4))
def test_the_error_of_a_table_is_a_bound(seed):
    """Of ellipses with rows so far apart that no order is much better than another, or any nearer."""
    random = np.random.default_rng(seed)
    judged = 0
    for _ in range(12):
        orbit = pt.KeplerOrbit(
            KEPLER.mu,
            semimajor_axis=2e4,
            eccentricity=random.uniform(0, 0.7),
            inclination=0.5,
            node=0.3,
            argument_of_periapsis=0.7,
            true_anomaly=random.uniform(-3, 3),
        )
        rows = np.linspace(0, random.uniform(0.6, 3) * orbit.period, random.integers(7, 90))
        r, v = (np.stack(list(part(rows)), axis=-1) for part in (orbit.position_at, orbit.velocity_at))
        try:
            ephemeris = pt.orbits.Ephemeris.from_table(orbit.mu, times=rows, positions=r, velocities=v)
        except ValueError:
            continue  # too coarse to be read at all
        times = np.linspace(rows[0], rows[-1], 4001)
        between = np.stack(list(ephemeris.position_at(times))) - np.stack(list(orbit.position_at(times)))
        true, judged = np.max(np.linalg.norm(between, axis=0)), judged + 1
        assert true < ephemeris.error + 1e-10 < 1e3 * true + 1e-8
    assert judged > 5


def test_every_precision_takes_a_table(fitted):
    body = pt.Body((1.0, 1.2, 1.5))
    start = body.state((1, 0, 0, 0), omega_body=(1e-4, 2e-4, 1e-3))
    system = pt.System(body, pt.GravityGradient(fitted))
    runs = [
        pt.propagate(system, start, [-3e3, 3e3], precision=precision).quaternion
        for precision in ("double", "quadruple")
    ]
    for run in runs[1:]:
        np.testing.assert_allclose(run, runs[0], rtol=0, atol=1e-13)


def test_teme_goes_with_no_axes_without_a_name():
    teme = pt.orbits.Ephemeris.from_function(KEPLER.mu, position=place, start=0.0, stop=T, reference_frame="TEME")
    icrf = pt.orbits.Ephemeris.from_function(KEPLER.mu, position=place, start=0.0, stop=T, reference_frame="ICRF")
    body = pt.Body((1.0, 1.2, 1.5))
    pt.System(body, pt.GravityGradient(icrf), pt.GravityGradient(KEPLER))
    with pytest.raises(ValueError, match=r"one reference frame, got TEME and space axes\. Give reference_frame="):
        pt.System(body, pt.GravityGradient(teme), pt.GravityGradient(KEPLER))
    with pytest.raises(ValueError, match=r"one reference frame to be added, got TEME and space axes"):
        pt.orbits.composite_orbit(teme, KEPLER)


def test_metres_are_a_thousandth_of_kilometres():
    day = ("2026-01-01T00:00:00 TDB", "2026-01-02T00:00:00 TDB")
    mars = pt.orbits.planet_orbit("mars", "sun", *day)
    long, times = pt.orbits.kilometres_to_metres(mars), np.linspace(*mars.span, 7)
    for there, here in zip(long.position_at(times), mars.position_at(times), strict=True):
        assert np.allclose(there, 1000 * np.asarray(here), rtol=3e-15, atol=0)
    assert np.allclose(long.velocity_at(times), 1000 * np.asarray(list(mars.velocity_at(times))), rtol=3e-15, atol=0)
    assert (long.error, long.radius) == (1000 * mars.error, 1000 * mars.radius)
    assert (long.span, long.reference_frame, long.origin) == (mars.span, mars.reference_frame, mars.origin)
    assert np.isclose(np.sqrt(long.mu / 2.28e11**3), np.sqrt(mars.mu / 2.28e8**3), rtol=1e-15)  # the mean motion


@pytest.mark.parametrize(
    ("function", "given"),
    [(lambda: None, "<lambda>()"), (lambda *, a: a, "<lambda>(*, a)"), (lambda a, b: a + b, "<lambda>(a, b)")],
    ids=["of nothing", "of names", "of two values"],
)
def test_functions_that_take_something_else_are_refused(function, given):
    rule = "position must be a function of one value"
    with pytest.raises(TypeError, match=rf"^{re.escape(f'{rule}, got function {given}.')}$"):
        pt.orbits.Ephemeris.from_function(1.0, position=function, start=0.0, stop=1.0)


def test_a_function_that_takes_no_arrays_is_named():
    message = r"position must be a function of times, shape \(n,\), but on such an array it raised a TypeError: "
    with pytest.raises(TypeError, match=f"^{message}"):
        pt.orbits.Ephemeris.from_function(2.0, position=int, start=0.0, stop=3.0)


def test_positions_are_known_a_light_time_before_the_first_time():
    table = pt.orbits.planet_orbit("earth", "sun", 0.0, 4e6)
    longer = pt.orbits.planet_orbit("earth", "sun", -1e6, 5e6)
    light_time = 499.0  # of an astronomical unit, in seconds
    for time in (-light_time, 4e6 + light_time):
        found, expected = (np.array(orbit.position_at(time)) for orbit in (table, longer))
        np.testing.assert_allclose(found, expected, rtol=0, atol=3e-12 * np.linalg.norm(expected))
    for outside in (-501.0, 4e6 + 501.0):
        with pytest.raises(ValueError, match=r"time must lie within the span of the ephemeris, \[0\.0, 4000000\.0\]"):
            table.position_at(outside)
