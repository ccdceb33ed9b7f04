"""Orbits from positions and velocities, and from each of their anomalies."""

import re
from decimal import Decimal

import numpy as np
import pytest
from scipy.spatial.transform import Rotation

import poinsot as pt
from poinsot.orbits.angle_reduction import angle_at
from poinsot.orbits.escape import EscapeOrbit
from poinsot.orbits.precessing import PrecessingOrbit
from poinsot.orbits.two_body import two_body_orbit

EPS = np.finfo(float).eps
MU, Q = 1.3, 0.9
PLANE = {"inclination": 0.0, "node": 0.0, "argument_of_periapsis": 0.0}
ELEMENTS = {"mu": 1.0, "semimajor_axis": 2.0, "eccentricity": 0.1, **PLANE}
ONE_ORBIT = pt.KeplerOrbit(**ELEMENTS)
TILTS = (0.0, 1e-300, 1e-16, 1e-8, 0.4, np.pi / 2, np.pi - 1e-8, np.pi)
ECCENTRICITIES = (0.0, 1e-15, 1e-8, 0.1, 0.7, 0.999, 1 - 1e-9, 1.0, 1 + 1e-12, 1.01, 2.0, 50.0)
CORNERS = (0.0, 1e-9, 0.5, -0.5, 0.9, -0.9, 0.999, 0.99999)


def floats(vector):
    return np.array([float(x) for x in vector])


def vectors(e, f, turn):
    """Position and velocity on a conic, from its equation r = p/(1 + e cos f)."""
    p = Q * (1 + e)
    r = p / (1 + e * np.cos(f)) * np.array([np.cos(f), np.sin(f), 0])
    v = np.sqrt(MU / p) * np.array([-np.sin(f), e + np.cos(f), 0])
    return turn.apply(r), turn.apply(v)


@pytest.mark.parametrize("tilt", TILTS)
@pytest.mark.parametrize("eccentricity", ECCENTRICITIES)
def test_position_comes_back_to_rounding(eccentricity, tilt):
    random = np.random.default_rng(8)
    farthest = np.arccos(max(-1.0, -1 / eccentricity)) if eccentricity > 0 else np.pi
    for corner in CORNERS:
        r, v = vectors(eccentricity, corner * farthest, Rotation.from_euler("ZXZ", [random.uniform(-3, 3), tilt, 0.7]))
        orbit = two_body_orbit(MU, position=r, velocity=v, epoch=7.0)
        distance = np.linalg.norm(r)
        assert np.linalg.norm(floats(orbit.position_at(7.0)) - r) < 12 * EPS * distance
        stretch = max(1.0, distance / orbit.periapsis_distance)
        assert np.linalg.norm(floats(orbit.velocity_at(7.0)) - v) < 8 * EPS * stretch * np.linalg.norm(v)


@pytest.mark.parametrize("eccentricity", [0.0, 0.4, 0.97, 1.0, 1.7])
def test_the_motion_goes_on_as_it_was(eccentricity):
    turn = Rotation.from_euler("ZXZ", [0.3, 1.0, -0.4])
    first = two_body_orbit(MU, **dict(zip(("position", "velocity"), vectors(eccentricity, 0.8, turn), strict=True)))
    second = two_body_orbit(
        MU, position=floats(first.position_at(2.5)), velocity=floats(first.velocity_at(2.5)), epoch=2.5
    )
    for time in (-1.0, 0.0, 2.5, 9.0):
        expected = floats(first.position_at(time))
        assert np.allclose(floats(second.position_at(time)), expected, rtol=0, atol=1e-13 * np.linalg.norm(expected))


def test_the_kind_follows_from_the_energy():
    speed = np.sqrt(2.0)  # which rounds up, and its square too
    assert isinstance(
        two_body_orbit(1.0, position=(1, 0, 0), velocity=(0, np.nextafter(speed, 0) - 1e-15, 0)), pt.KeplerOrbit
    )
    assert isinstance(two_body_orbit(1.0, position=(1, 0, 0), velocity=(0, speed, 0)), EscapeOrbit)
    exact = two_body_orbit(0.5, position=(1, 0, 0), velocity=(0, 1, 0))
    assert (type(exact), exact.eccentricity, exact.periapsis_distance) == (EscapeOrbit, 1.0, 1.0)


@pytest.mark.parametrize("offset", [1e-18, 1e-14, 1e-10])
def test_nothing_jumps_at_the_circle_in_the_equator(offset):
    """The motion of close vectors stays close, though node and periapsis may be anywhere."""
    reference = two_body_orbit(1.0, position=(1, 0, 0), velocity=(0, 1, 0))
    for change in np.concatenate([np.eye(3), -np.eye(3)]) * offset:
        for r, v in ((np.array([1, 0, 0]) + change, (0, 1, 0)), ((1, 0, 0), np.array([0, 1, 0]) + change)):
            orbit = two_body_orbit(1.0, position=r, velocity=v)
            for time in (0.0, 1.0, 2.0):
                difference = floats(orbit.position_at(time)) - floats(reference.position_at(time))
                assert np.linalg.norm(difference) < 10 * offset + 8 * EPS


def test_a_distant_encounter_keeps_its_plane():
    """r and v almost parallel: their product alone would lose the plane, and the position with it."""
    r, v = np.array([3e5, 1.0, -2e5]), np.array([-3.0, 1e-7, 2.00001])
    orbit = two_body_orbit(MU, position=r, velocity=v)
    assert np.linalg.norm(floats(orbit.position_at(0.0)) - r) < 12 * EPS * np.linalg.norm(r)
    assert np.linalg.norm(floats(orbit.velocity_at(0.0)) - v) < 1e-14 * np.linalg.norm(v)


# ---------------------------------------------------------------------- anomalies


@pytest.mark.parametrize("length", ["periapsis_distance", "semimajor_axis"])
@pytest.mark.parametrize("eccentricity", [0.0, 0.3, 0.95])
@pytest.mark.parametrize("E", [0.0, 0.7, -2.5, 3.0])
def test_anomalies_of_an_ellipse_name_one_place(eccentricity, E, length):
    e, plane = eccentricity, {"inclination": 0.4, "node": 1.1, "argument_of_periapsis": -0.7}
    size = {"periapsis_distance": 1.2 * (1 - e), "semimajor_axis": 1.2}[length]
    shape = {"mu": MU, length: size, "eccentricity": eccentricity, **plane}
    x, y = np.cos(E) - e, np.sqrt(1 - e * e) * np.sin(E)
    anomalies = {"eccentric_anomaly": E, "mean_anomaly": E - e * np.sin(E), "true_anomaly": np.arctan2(y, x)}
    positions = [
        floats(pt.KeplerOrbit.from_elements(**shape, **{name: value}, epoch=2.0).position_at(2.0))
        for name, value in anomalies.items()
    ]
    expected = 1.2 * Rotation.from_euler("ZXZ", [1.1, 0.4, -0.7]).apply([x, y, 0])
    assert np.allclose(positions, expected, rtol=0, atol=64 * EPS)


@pytest.mark.parametrize("length", ["periapsis_distance", "semimajor_axis"])
@pytest.mark.parametrize("H", [0.0, 0.7, -2.5, 9.0])
def test_anomalies_of_a_hyperbola_name_one_place(H, length):
    e, lengths = 1.6, {"periapsis_distance": 0.9, "semimajor_axis": -1.5}
    x, y = 1.5 * (e - np.cosh(H)), 1.5 * np.sqrt(e * e - 1) * np.sinh(H)
    anomalies = {"eccentric_anomaly": H, "mean_anomaly": e * np.sinh(H) - H, "true_anomaly": np.arctan2(y, x)}
    for name, value in anomalies.items():
        shape = {length: lengths[length], name: value}
        orbit = EscapeOrbit.from_elements(
            MU, eccentricity=e, inclination=0.4, node=1.1, argument_of_periapsis=-0.7, **shape, epoch=2.0
        )
        expected = Rotation.from_euler("ZXZ", [1.1, 0.4, -0.7]).apply([x, y, 0])
        loss = np.linalg.norm(expected) / 0.9 if name == "true_anomaly" else 1
        assert np.allclose(floats(orbit.position_at(2.0)), expected, rtol=0, atol=32 * EPS * loss * np.hypot(x, y))
        assert float(orbit.true_anomaly_at(2.0)) == pytest.approx(np.arctan2(y, x), abs=1e-14)


@pytest.mark.parametrize("f", [0.0, 1.0, -2.0, 3.0])
@pytest.mark.parametrize("eccentricity", [1.0, 1 + 1e-15, 1 + 1e-9])
def test_true_anomaly_of_a_parabola_and_next_to_it(eccentricity, f):
    orbit = EscapeOrbit.from_elements(MU, eccentricity=eccentricity, periapsis_distance=Q, true_anomaly=f, epoch=1.0)
    assert float(orbit.true_anomaly_at(1.0)) == pytest.approx(f, rel=1e-7 if eccentricity > 1 + 1e-12 else 1e-13, abs=0)


def test_members_from_mean_anomalies():
    M = np.array([0.1, 2.0, -1.0])
    orbit = pt.KeplerOrbit.from_elements(
        MU, semimajor_axis=1.2, eccentricity=0.3, inclination=0.4, node=1.1, argument_of_periapsis=-0.7, mean_anomaly=M
    )
    assert np.allclose(orbit.mean_anomaly_at(0.0), M, rtol=0, atol=4 * EPS)


# ---------------------------------------------------------------------- phases


def test_angles_of_a_million_turns_keep_their_digits():
    times = np.array([0.0, 1e6, 2.0**40, -(2.0**50)])
    angle = angle_at(0.25, 0.75, times, 0.0)
    import mpmath

    with mpmath.workdps(60):
        for found, t in zip(angle, times, strict=True):
            turns = (0.25 + 0.75 * mpmath.mpf(float(t)) - mpmath.mpf(float(found))) / (4 * mpmath.pi)
            assert abs(turns - mpmath.nint(turns)) < 4 * EPS
    assert np.all(np.abs(angle) <= 2 * np.pi + 1e-15)


def test_an_angle_as_a_whole_grows():
    assert angle_at(0.25, 0.75, 1e6, 0.0, whole=True) == 750000.25


# ---------------------------------------------------------------------- below the surface

AS_A_POINT = "the motion is computed as if the attractor were a point."
R_EARTH, SHAPES = 6378.137, {"ellipse": 0.2, "parabola": 1.0, "hyperbola": 1.7}
PERIGEES = {"ellipse": 5600.0, "parabola": 6378.0, "hyperbola": 6300.25}
DEPTHS = {"ellipse": "778.137", "parabola": "0.137", "hyperbola": "77.887"}  # R_EARTH less the perigee, by hand


def conic(e, q, **others):
    others |= {"eccentricity": e, "inclination": 0.4, "node": 1.1, "argument_of_periapsis": -0.7}
    if e < 1:
        return pt.KeplerOrbit(MU, semimajor_axis=q / (1 - e), **others)
    return EscapeOrbit(MU, periapsis_distance=q, **others)


def conic_from_elements(e, q, **others):
    ahead = {"true_anomaly": 0.0} | others
    if e < 1:
        return pt.KeplerOrbit.from_elements(
            MU,
            semimajor_axis=q / (1 - e),
            eccentricity=e,
            inclination=0.4,
            node=1.1,
            argument_of_periapsis=-0.7,
            **ahead,
        )
    return EscapeOrbit.from_elements(
        MU, eccentricity=e, inclination=0.4, node=1.1, argument_of_periapsis=-0.7, periapsis_distance=q, **ahead
    )


def conic_from_vectors(e, q, **others):
    return two_body_orbit(MU, position=(0, q, 0), velocity=(-np.sqrt(MU * (1 + e) / q), 0, 0), **others)


@pytest.mark.parametrize("way", [conic, conic_from_elements, conic_from_vectors])
@pytest.mark.parametrize("shape", SHAPES)
def test_a_periapsis_below_the_surface_is_reported_with_its_depth(way, shape):
    e, q = SHAPES[shape], PERIGEES[shape]
    with pytest.warns(UserWarning, match="surface") as warned:
        orbit = way(e, q, radius=R_EARTH)
    name, distance = type(orbit).__name__, f"(distance {q:g}, radius 6378.137)"
    assert [str(warning.message) for warning in warned] == [
        f"{name}: the periapsis is {DEPTHS[shape]} below the surface {distance}; {AS_A_POINT}"
    ]
    assert warned[0].filename == __file__
    assert orbit.radius == R_EARTH


@pytest.mark.parametrize("way", [conic, conic_from_elements, conic_from_vectors])
@pytest.mark.parametrize("shape", SHAPES)
def test_no_word_above_the_surface_or_of_a_point(way, shape):
    """Warnings are errors here."""
    for others in ({}, {"radius": 0.0}, {"radius": 6299.99}):
        assert way(SHAPES[shape], 6300.0, **others).radius == others.get("radius", 0.0)
    assert conic(SHAPES[shape], 6400.0, radius=6400.0).periapsis_distance == 6400.0


def test_of_an_ensemble_the_lowest_member_is_reported():
    with pytest.warns(UserWarning, match="lowest") as warned:
        pt.KeplerOrbit(MU, semimajor_axis=[7000, 6500, 9000, 6000], eccentricity=[0.2, 0.25, 0.1, 0.0], radius=6378.137)
    with pytest.warns(UserWarning, match="lowest") as warned_of_radii:
        EscapeOrbit(MU, periapsis_distance=5.0, eccentricity=1.5, radius=[4.0, 5.5, 5.25])
    assert [str(warning.message) for warning in (*warned, *warned_of_radii)] == [
        "KeplerOrbit: the periapsis of 3 of 4 members is below the surface, the lowest, member 1, 1503.137 below it "
        f"(distance 4875, radius 6378.137); {AS_A_POINT}",
        "EscapeOrbit: the periapsis of 2 of 3 members is below the surface, the lowest, member 1, 0.5 below it "
        f"(distance 5, radius 5.5); {AS_A_POINT}",
    ]


def test_a_surface_is_reported_once_and_moves_nothing():
    with pytest.warns(UserWarning, match="KeplerOrbit") as warned:
        orbit = pt.KeplerOrbit(**ELEMENTS, radius=1.9)
    assert len(warned) == 1
    moving = PrecessingOrbit.from_mean_motion(orbit, mean_motion=0.4, node_rate=0.01)
    assert (moving.radius, moving.periapsis_distance) == (1.9, 1.8)
    body = pt.Body((1, 1.2, 1.5))
    start = body.state((0.6, 0.8, 0, 0), omega_body=(0.1, 0.2, 0.3))
    for deep, point in (
        (orbit, ONE_ORBIT),
        (moving, PrecessingOrbit.from_mean_motion(ONE_ORBIT, mean_motion=0.4, node_rate=0.01)),
    ):
        ours, theirs = (pt.propagate(pt.System(body, pt.GravityGradient(o)), start, [0.0, 9.0]) for o in (deep, point))
        assert np.array_equal(ours.quaternion, theirs.quaternion)


def test_an_oblate_attractor_tells_what_its_orbit_did_not():
    flat = {"j2": 0.1, "equatorial_radius": 1.875, "pole": (0, 0, 1)}
    sentence = (
        "Oblateness: the periapsis is 0.075 below the equatorial radius (distance 1.8, radius 1.875); "
        "the field outside the attractor is continued inwards."
    )
    known = pt.KeplerOrbit(**ELEMENTS, radius=1.7)  # above that one
    for orbit in (
        ONE_ORBIT,
        PrecessingOrbit(ONE_ORBIT, node_rate=0.1),
        known,
        EscapeOrbit(1, periapsis_distance=1.8, eccentricity=1.5),
    ):
        with pytest.warns(UserWarning, match="equatorial") as warned:
            pt.forces.Oblateness(orbit, **flat)
        assert [str(warning.message) for warning in warned] == [sentence]
        assert warned[0].filename == __file__
    for still in (
        pt.orbits.FixedPosition(1.0, position=(0, 0, 0.8)),
        pt.orbits.RotatingPosition(1.0, position=(0.8, 0, 0), rate=0.3),
    ):
        with pytest.warns(UserWarning, match="is 1.075 below the equatorial radius"):
            pt.forces.Oblateness(still, **flat)
    two = pt.KeplerOrbit(1, semimajor_axis=2, eccentricity=np.array([0.01, 0.1]), radius=1.7)
    with pytest.warns(UserWarning, match="the periapsis of 1 of 2 members is below the equatorial radius"):
        pt.forces.Oblateness(two, **flat)
    with pytest.warns(UserWarning, match="KeplerOrbit"):
        orbit = pt.KeplerOrbit(**ELEMENTS, radius=1.9)
    for quiet in (
        orbit,
        PrecessingOrbit(orbit),
        pt.orbits.FixedPosition(1.0, position=(0, 0, 2)),
        pt.KeplerOrbit(1, semimajor_axis=2, eccentricity=0.01),
    ):
        pt.forces.Oblateness(quiet, **flat)


# ---------------------------------------------------------------------- wrong input

ANOMALIES = "true_anomaly, mean_anomaly, eccentric_anomaly"


def hyperbola(e=1.5, **others):
    return EscapeOrbit.from_elements(1.0, eccentricity=e, **others)


WRONG = {
    "bound_escape": (
        lambda: EscapeOrbit(1, periapsis_distance=1, eccentricity=0.5),
        "eccentricity must be at least 1, got 0.5. An ellipse is a KeplerOrbit.",
    ),
    "bound_member": (
        lambda: EscapeOrbit(1, periapsis_distance=1, eccentricity=[1.5, -3]),
        "eccentricity must be at least 1, got -3.0. An ellipse is a KeplerOrbit.",
    ),
    "mu_of_escape": (lambda: EscapeOrbit(0, periapsis_distance=1, eccentricity=1.5), "mu must be positive, got 0.0."),
    "periapsis": (
        lambda: EscapeOrbit(1, periapsis_distance=-1, eccentricity=1.5),
        "periapsis_distance must be positive, got -1.0.",
    ),
    "no_anomaly": (
        lambda: pt.KeplerOrbit.from_elements(**ELEMENTS),
        f"elements must have exactly one of {ANOMALIES}, got none.",
    ),
    "two_anomalies": (
        lambda: pt.KeplerOrbit.from_elements(**ELEMENTS, true_anomaly=1, mean_anomaly=1),
        f"elements must have exactly one of {ANOMALIES}, got true_anomaly and mean_anomaly.",
    ),
    "unbound_ellipse": (
        lambda: pt.KeplerOrbit.from_elements(1, semimajor_axis=2, eccentricity=1.5, mean_anomaly=0),
        "eccentricity must be in [0, 1), got 1.5. A Kepler orbit is an ellipse.",
    ),
    "negative_axis_of_an_ellipse": (
        lambda: pt.KeplerOrbit.from_elements(1, semimajor_axis=-2, eccentricity=0.5, mean_anomaly=0),
        "semimajor_axis must be positive, got -2.0.",
    ),
    "positive_axis": (
        lambda: hyperbola(semimajor_axis=2, true_anomaly=0),
        "semimajor_axis must be negative with an eccentricity above 1, got 2.0. A hyperbola has a = q/(1 - e).",
    ),
    "axis_of_a_parabola": (
        lambda: hyperbola(1, semimajor_axis=-2, true_anomaly=0),
        "semimajor_axis must belong to a hyperbola, but the eccentricity is 1. Give the periapsis_distance.",
    ),
    "mean_anomaly_of_a_parabola": (
        lambda: hyperbola(1, periapsis_distance=1, mean_anomaly=0),
        "mean_anomaly must belong to a hyperbola, but the eccentricity is 1. Give the true_anomaly.",
    ),
    "beyond_the_asymptote": (
        lambda: hyperbola(2, periapsis_distance=1, true_anomaly=2.5),
        "true_anomaly must be within the asymptotes, |f| < 2.0944, got 2.5.",
    ),
    "two_lengths": (
        lambda: hyperbola(periapsis_distance=1, semimajor_axis=-2, true_anomaly=0),
        "elements must have exactly one of periapsis_distance, semimajor_axis, "
        "got periapsis_distance and semimajor_axis.",
    ),
    "ellipse_for_an_escape": (
        lambda: EscapeOrbit.from_vectors(1, position=(1, 0, 0), velocity=(0, 1, 0)),
        "position and velocity must belong to a parabola or hyperbola, but the orbital energy is -0.5 < 0. "
        "An ellipse is a KeplerOrbit.",
    ),
    "at_the_attractor": (
        lambda: two_body_orbit(1, position=(0, 0, 0), velocity=(0, 1, 0)),
        "position must not be zero, got all components 0. The body would be at the attractor.",
    ),
    "radial": (
        lambda: two_body_orbit(1, position=(1, 2, 3), velocity=(2, 4, 6)),
        "position and velocity must span a plane, but they are parallel.",
    ),
    "dropped": (
        lambda: two_body_orbit(1, position=(1, 2, 3), velocity=(0, 0, 0)),
        "position and velocity must span a plane, but they are parallel.",
    ),
    "hollow": (
        lambda: pt.KeplerOrbit(**ELEMENTS, radius=-1),
        "radius must not be negative, got -1.0. A point has the radius 0.",
    ),
    "hollow_escape": (
        lambda: EscapeOrbit(1, periapsis_distance=1, eccentricity=1.5, radius=[0, -2]),
        "radius must not be negative, got -2.0. A point has the radius 0.",
    ),
    "repelling": (lambda: two_body_orbit(-1, position=(1, 0, 0), velocity=(0, 1, 0)), "mu must be positive, got -1.0."),
    "backwards": (
        lambda: PrecessingOrbit(ONE_ORBIT, node_rate=0, periapsis_rate=0, anomaly_rate=-2),
        "mean_motion must be positive, got -1.6464466094067263.",
    ),
    "mean_motion": (
        lambda: PrecessingOrbit.from_mean_motion(ONE_ORBIT, mean_motion=0),
        "mean_motion must be positive, got 0.0.",
    ),
    "rate": (
        lambda: PrecessingOrbit(ONE_ORBIT, node_rate=float("nan")),
        "node_rate must be finite, got node_rate = nan.",
    ),
}


@pytest.mark.parametrize("name", WRONG)
def test_wrong_input_gives_one_sentence(name):
    call, sentence = WRONG[name]
    with pytest.raises(ValueError, match=f"^{re.escape(sentence)}$"):
        call()


def test_only_ellipses_precess():
    with pytest.raises(TypeError, match=r"^orbit must be a KeplerOrbit, got EscapeOrbit\.$"):
        PrecessingOrbit(EscapeOrbit(1, periapsis_distance=1, eccentricity=1.5))


@pytest.mark.parametrize("name", ["mu", "position", "velocity"])
def test_numbers_of_other_packages_are_refused(name):
    given = {"mu": 1.0, "position": (1.0, 0, 0), "velocity": (0, 1.0, 0)}
    with pytest.raises(TypeError, match=rf"^{name} must be real numbers, got Decimal Decimal\('sNaN'\)\.$"):
        pt.orbits.osculating_elements(**{**given, name: Decimal("sNaN")})


PLACES = np.array([[1.0, 0.2, 0.1], [np.nan] * 3, [1.0, 0.0, 0.3]])
SPEEDS = np.array([[0.0, 0.3, 1.0], [np.nan] * 3, [0.1, 1.0, 0.0]])


def test_rows_of_nan_alone_have_elements_of_nan():
    found = pt.orbits.osculating_elements(2.0, position=PLACES, velocity=SPEEDS)
    assert np.isnan(found.eccentricity).tolist() == [False, True, False]


@pytest.mark.parametrize("number", [np.nan, np.inf])
@pytest.mark.parametrize("name", ["mu", "position", "velocity"])
def test_other_numbers_of_a_row_must_be_finite(name, number):
    given = {"mu": np.full(3, 2.0), "position": PLACES.copy(), "velocity": SPEEDS.copy()}
    given[name].flat[0] = number
    place = "0" if name == "mu" else "0, 0"
    with pytest.raises(ValueError, match=rf"^{name} must be finite, got {name}\[{place}\] = {number}\.$"):
        pt.orbits.osculating_elements(**given)


def test_a_row_without_a_position_alone_is_refused():
    with pytest.raises(ValueError, match=r"^position must be finite, got position\[1, 0\] = nan\.$"):
        pt.orbits.osculating_elements(2.0, position=PLACES, velocity=np.ones((3, 3)))
