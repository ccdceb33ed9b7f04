"""Light and air on facets: motions of other programs, and sunlight behind spheres by quadrature."""

import itertools
import json
from pathlib import Path
from typing import Any

import numpy as np
import pytest
from scipy.integrate import quad, solve_ivp
from scipy.optimize import brentq
from scipy.spatial.transform import Rotation

import poinsot as pt
from poinsot.forces import AtmosphericDrag, ExponentialAtmosphere, Facets, Occulter, RadiationPressure

CASES = json.loads((Path(__file__).parent / "surfaces.json").read_text())["cases"]
AU, SUN_RADIUS = 149597870700.0, 6.957e8


def largest(difference):
    return np.max(np.abs(difference))


def facets_of(case):
    names = ("area", "normal", "position", "specular", "diffuse", "drag")
    return Facets(*([row[name] for row in case["facets"]] for name in names), closed=True)


def force_of(name):
    case = CASES[name]
    if name == "srp_facets":
        sun = pt.orbits.FixedPosition(1.327e20, position=-AU * np.array(case["sun_direction_space"]))
        return RadiationPressure(sun, facets_of(case), pressure=case["pressure"])
    orbit = pt.KeplerOrbit(
        case["mu"],
        semimajor_axis=case["semimajor_axis"],
        eccentricity=0.0,
        inclination=case["inclination"],
        node=case["node"],
        argument_of_periapsis=case["argument_of_latitude0"],
    )
    air = ExponentialAtmosphere(case["rho0"], case["planet_radius"], case["scale_height"])
    return AtmosphericDrag(orbit, air, facets_of(case))


@pytest.mark.parametrize("formulation", ["lie_poisson", "canonical"])
@pytest.mark.parametrize("name", CASES)
def test_a_motion_through_every_edge_is_that_of_other_programs(name, formulation):
    case = CASES[name]
    system = pt.System(pt.Body.from_inertia(case["inertia"]), force_of(name))
    start = system.state(case["quaternion0"], omega_body=case["omega_body0"])
    assert largest(system.torque_body(start) - case["torque_body0"]) < 1e-14 * largest(case["torque_body0"])
    motion = pt.propagate(system, start, case["times"], formulation=formulation)
    signs = np.sign(np.sum(motion.quaternion * case["quaternion"], axis=-1))[:, None]
    bound = 20 * case["estimated_error_of_reference"]
    assert largest(signs * motion.quaternion - case["quaternion"]) < bound
    assert largest(motion.omega_body - case["omega_body"]) < bound


# ---------------------------------------------------------------------- the Sun's disc behind spheres


def seen_of_a_disc(a, b, c):
    """Return the part of a disc of radius a that one of radius b at a distance c leaves, by strips across it."""

    def width(x):
        own = np.sqrt(max(a * a - x * x, 0.0))
        other = np.sqrt(max(b * b - (x - c) ** 2, 0.0))
        return 2 * (own - min(own, other))

    inside = [x for x in (c - b, c + b, (c * c + a * a - b * b) / (2 * c)) if -a < x < a]
    edges = sorted([-a, a, *inside])
    total = 0.0
    for low, high in itertools.pairwise(edges):  # widths begin like roots at both ends
        middle, half = 0.5 * (low + high), 0.5 * (high - low)
        total += quad(lambda t: half * np.sin(t) * width(middle - half * np.cos(t)), 0, np.pi, epsabs=1e-11 * a * a)[0]  # noqa: B023
    return total / (np.pi * a * a)


def sunlight_at(sun_angle, sphere_angle, apart, distance=7e6):
    """Return what the force says for discs of angular radii that are an angle apart."""
    turn = Rotation.from_rotvec(np.array([0.3, -0.5, 0.8]))
    to_sphere = turn.apply((np.cos(apart), np.sin(apart), 0.0))
    sun = pt.orbits.FixedPosition(1.0, position=-AU * turn.apply((1.0, 0.0, 0.0)))
    place = pt.orbits.FixedPosition(1.0, position=-distance * to_sphere)
    occulter = Occulter(place, distance * np.sin(sphere_angle))
    plate = Facets([1.0], [(0, 0, 1)], [(0, 0, 0)])
    force = RadiationPressure(sun, plate, [occulter], sun_radius=AU * np.sin(sun_angle))
    system = pt.System(pt.Body((1, 1, 1)), force)
    return float(force.sunlight(system.at(system.state((1, 0, 0, 0), omega_body=(0, 0, 0)))))


@pytest.mark.parametrize(("a", "b"), [(0.00465, 1.1), (0.00465, 0.0163), (0.00465, 0.0046), (0.1, 0.03), (0.2, 0.7)])
def test_sunlight_is_the_part_of_the_disc_that_is_left(a, b):
    near, far = abs(a - b), a + b
    for share in (0.003, 0.1, 0.5, 0.9, 0.997):
        c = near + share * (far - near)
        # Rounding of angles and quadrature, over the smaller disc; contacts are smooth within a part of 1e-9 of it.
        assert abs(sunlight_at(a, b, c) - seen_of_a_disc(a, b, c)) < 1e-10
    assert sunlight_at(a, b, far + 1e-6) == 1.0
    deep = 0.0 if b > a else 1 - (b / a) ** 2
    assert abs(sunlight_at(a, b, max(near - 1e-6, 1e-9)) - deep) < 1e-13


def test_overlap_of_plane_discs_is_near_that_on_the_sphere():
    """As the documentation says: of the Sun behind the Earth, from 400 km above it, off by less than 0.003."""
    a, b = 0.00465, np.arcsin(6378.0 / 6778.0)
    for share in (0.25, 0.5, 0.75):
        c = b + (2 * share - 1) * a

        def covered(angle, c=c):
            """The part of a circle about the Sun's centre, of some angular radius, that is behind the sphere."""
            cosine = (np.cos(b) - np.cos(angle) * np.cos(c)) / (np.sin(angle) * np.sin(c))
            return np.arccos(np.clip(cosine, -1, 1)) / np.pi * np.sin(angle)

        kink = [abs(c - b)] if 0 < abs(c - b) < a else None
        on_sphere = 1 - quad(covered, 1e-12, a, points=kink, epsrel=1e-10)[0] / (1 - np.cos(a))
        assert 1e-5 < abs(seen_of_a_disc(a, b, c) - on_sphere) < 3e-3


RADIUS = 6.378137e6


def low_orbit():
    return pt.KeplerOrbit(
        3.986004415e14, semimajor_axis=7.0e6, eccentricity=0.05, inclination=0.4, node=0.7, argument_of_periapsis=0.2
    )


def contacts(orbit, direction, stop):
    """Return the times at which the body passes the cones of umbra and penumbra, by root search on their angles."""

    def angles(t):
        r = np.array(orbit.position_at(t), dtype=float)
        to_sun = AU * direction
        a, b = np.arcsin(SUN_RADIUS / np.linalg.norm(to_sun)), np.arcsin(RADIUS / np.linalg.norm(r))
        cosine = np.dot(-r, to_sun) / np.linalg.norm(r) / np.linalg.norm(to_sun)
        return a, b, np.arccos(cosine)

    found = []
    for sign in (1, -1):

        def gap(t, sign=sign):
            a, b, c = angles(t)
            return c - b - sign * a

        grid = np.linspace(0, stop, 400)
        values = [gap(t) for t in grid]
        changes = np.flatnonzero(np.diff(np.sign(values)))
        found += [brentq(gap, grid[i], grid[i + 1], xtol=1e-12) for i in changes]
    return sorted(found), angles


def test_a_motion_through_umbra_and_penumbra():
    """Euler's equations by another integrator, which stops at each contact and at no facet: one is lit all the way."""
    direction, orbit, stop = np.array([0.8, 0.48, 0.36]), low_orbit(), 6000.0
    times, angles = contacts(orbit, direction, stop)
    assert len(times) == 4
    assert 3 < times[1] - times[0] < 60
    moments, pressure, place, normal = np.array([0.3, 0.5, 0.4]), 1e-6, np.array([0.2, 0.3, -0.1]), direction
    area, specular, diffuse = 1.5, 0.3, 0.2

    def rates(t, y):
        q, omega = y[:4], y[4:]
        u = Rotation.from_quat(q, scalar_first=True).inv().apply(direction)
        a, b, c = angles(t)
        seen: Any = 1.0 if c >= a + b else 0.0 if c <= b - a else seen_of_a_disc_in_closed_form(a, b, c)
        cosine = float(np.maximum(normal @ u, 0.0))
        force = -pressure * seen * area * cosine * ((1 - specular) * u + 2 * (diffuse / 3 + specular * cosine) * normal)
        torque = np.cross(place, force)
        turn = 0.5 * np.array([-q[1:] @ omega, *(q[0] * omega + np.cross(q[1:], omega))])
        return np.concatenate([turn, (np.cross(moments * omega, omega) + torque) / moments])

    start = y = np.array([1.0, 0, 0, 0, 1e-5, -2e-5, 1.5e-5])
    for first, last in itertools.pairwise([0, *times, stop]):
        found = solve_ivp(rates, (first, last), y, "DOP853", rtol=3e-14, atol=1e-17)
        y = found.y[:, -1]

    sun = pt.orbits.FixedPosition(1.327e20, position=-AU * direction)
    facets = Facets([area], [normal], [place], [specular], [diffuse])
    force = RadiationPressure(sun, facets, [Occulter(orbit, RADIUS)], pressure=pressure)
    system = pt.System(pt.Body(moments), force)
    motion = pt.propagate(system, system.state(start[:4], omega_body=start[4:]), [0.0, stop])
    assert largest(motion.quaternion[-1] - y[:4]) < 1e-11  # twenty times what was seen
    assert largest(motion.omega_body[-1] - y[4:]) < 1e-14
    end = system.state(motion.quaternion[-1], omega_body=motion.omega_body[-1], time=stop)
    other = pt.propagate(system, end, [stop, 0.0])
    assert largest(other.quaternion[-1] - start[:4]) < 1e-13


def seen_of_a_disc_in_closed_form(a, b, c):
    """Montenbruck's and Gill's formula, but for the arccosine of what is nearly one where b is large."""
    x = (c * c + a * a - b * b) / (2 * c)
    y = np.sqrt(max(a * a - x * x, 0.0))
    area = a * a * np.arccos(np.clip(x / a, -1, 1)) + b * b * np.arcsin(y / b) - c * y
    return 1 - area / (np.pi * a * a)
