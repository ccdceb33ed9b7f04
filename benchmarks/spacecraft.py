"""Spacecraft: an orbit of the CubeSat of examples/cubesat.py with every torque, and facets that turn past their edges.

The peer is Basilisk with its own modules of facets, at several steps; the reference is that of independent programs.
"""

import itertools
import json
import time
from pathlib import Path

import numpy as np

import poinsot as pt
from benchmarks import peers
from benchmarks.measure import Contender, computed_by, in_a_line, interleaved, pin
from benchmarks.problems import WIDE
from poinsot.forces import (
    IGRF,
    AtmosphericDrag,
    ExponentialAtmosphere,
    Facets,
    MagneticMoment,
    Occulter,
    RadiationPressure,
)
from poinsot.kinematics.attitude import rotation_angle

FACET_CASES = Path(__file__).parents[1] / "tests" / "oracles" / "surfaces.json"
TITLES = {"srp_facets": "radiation pressure", "drag_facets_circular": "drag"}
POINSOT = "poinsot"
STEPS = (4.0, 1.0, 0.25, 0.05)
OUTPUTS = 600
ELEMENTS = (
    "1 99999U 26001A   26079.50000000  .00002000  00000-0  10000-3 0  9999",
    "2 99999  97.4000 130.0000 0012000  80.0000 280.0000 15.21900000    11",
)
REVOLUTION = 86400 / 15.219
LEVEL = (0.5, -0.5, -0.5, 0.5)


def cubesat(short):
    """Return time and error of an orbit of the CubeSat, and of facets compared with Basilisk."""
    pin(1)
    return {"orbit": _orbit(short), "outputs": OUTPUTS, "facets": _facets(short)}


def _orbit(short):
    """Return what an orbit takes, or why it was not measured: its dates and fields need further packages."""
    try:
        system, start = _cubesat()
    except ImportError as problem:
        return {"trouble": in_a_line(problem)}
    times = np.linspace(0.0, REVOLUTION, OUTPUTS)
    began = time.perf_counter()
    motion = pt.propagate(system, start, times)
    first = time.perf_counter() - began - motion.run.wall_time
    wide = pt.propagate(system, start, times[-1:], formulation="canonical", precision=WIDE).quaternion[-1]

    def run():
        return pt.propagate(system, start, times).quaternion[-1]

    contender = Contender(lambda: run, lambda q: float(rotation_angle(q, wide)))
    (outcome,) = interleaved({POINSOT: contender}, repeats=3 if short else 25, budget=4.0).values()
    return {**outcome, "first": first, "steps": motion.run.steps, "computed_by": computed_by(motion.run)}


def _cubesat():
    """Return the satellite of the example under all its torques, and its start, level and at rest in space; SI."""
    span = 0.0, 2.1 * REVOLUTION
    orbit = pt.orbits.kilometres_to_metres(pt.files.tle_orbit(ELEMENTS, *span, reference_frame="ICRF"))
    of_earth = pt.orbits.kilometres_to_metres(pt.orbits.planet_orbit("earth", "sun", *span, calendar=orbit.calendar))
    sun, earth = pt.orbits.composite_orbit(orbit, of_earth), pt.orbits.RotationModel.earth(calendar=orbit.calendar)
    facets = Facets.from_box(
        (0.226, 0.226, 0.341),
        (0.004, -0.003, 0.010),
        wing_areas=[0.18, 0.18],
        wing_normals=[(0, 0, 1), (0, 0, 1)],
        wing_positions=[(0, 0.42, 0.1), (0, -0.42, 0.1)],
        specular=0.2,
        diffuse=0.2,
    )
    air = ExponentialAtmosphere(1.0e-12, 6.878e6, 6.3e4, omega_space=earth.omega_space(0.0))
    law = pt.control.OrbitPointing(kp=0.02, kd=0.12, limit=2e-3, orbit=orbit, target=LEVEL)
    axes = np.array([(1, 1, 1), (-1, 1, 1), (-1, -1, 1), (1, -1, 1)]) / np.sqrt(3)
    system = pt.System(
        pt.Body.from_inertia([(0.62, 0.004, -0.003), (0.004, 0.31, 0.005), (-0.003, 0.005, 0.55)]),
        pt.parts.ReactionWheels(axes, 2.4e-5, law, largest_torques=4e-3, largest_speeds=630.0, friction=2e-8),
        pt.GravityGradient(orbit),
        AtmosphericDrag(orbit, air, facets),
        RadiationPressure(sun, facets, [Occulter(orbit, 6.3781e6)]),
        MagneticMoment((0.01, -0.02, 0.015), IGRF(orbit, earth, degree=8, radius=6.3712e6)),
        units={"time": "s", "inertia": "kg m2"},
    )
    return system, system.state(LEVEL, omega_body=(0, 0, 0), frame=orbit.frame)


def _facets(short):
    """Return times and errors of each problem of facets, by tool and step, and why a peer is missing."""
    cases = json.loads(FACET_CASES.read_text())["cases"]
    found, missing = peers.available(("basilisk_facets",))
    tools = {}
    for name in TITLES:
        case = cases[name]
        contenders = {POINSOT: _contender(case, _poinsot(case))}
        for peer in found.values():
            for setting in itertools.product(peer.INTEGRATORS, STEPS[:2] if short else STEPS):
                contenders["Basilisk, {}, steps of {:g} s".format(*setting)] = _contender(
                    case, lambda case=case, setting=setting, peer=peer: peer.prepare(case, *setting)
                )
        tools[name] = interleaved(contenders, repeats=3 if short else 15, budget=4.0)
    return {"tools": tools, "missing": missing}


def _contender(case, prepare):
    return Contender(prepare, lambda q: float(rotation_angle(np.asarray(q), np.array(case["quaternion"][-1]))))


def _poinsot(case):
    system = pt.System(pt.Body.from_inertia(case["inertia"]), _force(case))
    start = system.state(case["quaternion0"], omega_body=case["omega_body0"])

    def run():
        return pt.propagate(system, start, case["times"][-1:]).quaternion[-1]

    return lambda: run


def _force(case):
    names = ("area", "normal", "position", "specular", "diffuse", "drag")
    facets = Facets(*([row[name] for row in case["facets"]] for name in names), closed=True)
    if "pressure" in case:
        sun = pt.orbits.FixedPosition(1.327e20, position=-1.495978707e11 * np.array(case["sun_direction_space"]))
        return RadiationPressure(sun, facets, pressure=case["pressure"])
    orbit = pt.KeplerOrbit(
        case["mu"],
        semimajor_axis=case["semimajor_axis"],
        eccentricity=0.0,
        inclination=case["inclination"],
        node=case["node"],
        argument_of_periapsis=case["argument_of_latitude0"],
    )
    air = ExponentialAtmosphere(case["rho0"], case["planet_radius"], case["scale_height"])
    return AtmosphericDrag(orbit, air, facets)
