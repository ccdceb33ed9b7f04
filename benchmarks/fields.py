"""Cost of a gravity field by its degree, relative to gravity gradient: a step, and the compilation."""

import os
import statistics
import time

import heyoka
import numpy as np

import poinsot as pt
from benchmarks.measure import pin
from benchmarks.problems import WIDE
from poinsot.kinematics.attitude import rotation_angle

ORBIT = pt.KeplerOrbit(1.0, semimajor_axis=5.0, eccentricity=0.1, inclination=0.4, node=0.3, argument_of_periapsis=0.7)
END = 200.0
SEMIAXES = (1.0, 0.7, 0.5)
OMEGA = (0.1, 0.3, -0.2)


def gravity_fields(short):
    """Return seconds of a step and of the first call, steps and error of each force, on one body after another."""
    pin(1)
    heyoka.llvm_state.set_diskcache_enabled(False)  # so that the first call compiles
    os.environ["POINSOT_CACHE"] = ""
    systems = {name: pt.System(body, force) for name, (body, force) in _forces(short).items()}
    first, steps, errors = {}, {name: [] for name in systems}, {}
    for name, system in systems.items():
        began = time.perf_counter()
        motion = _run(system)
        first[name] = time.perf_counter() - began - motion.run.wall_time
        wide = _run(system, formulation="canonical", precision=WIDE)
        errors[name] = float(rotation_angle(motion.quaternion[-1], wide.quaternion[-1]))
    for _ in range(3 if short else 25):
        for name, system in systems.items():
            motion = _run(system)
            steps[name].append(motion.run.wall_time / motion.run.steps)
    return {
        name: {
            "first": first[name],
            "seconds": statistics.median(steps[name]),
            "steps": _run(system).run.steps,
            "error": errors[name],
        }
        for name, system in systems.items()
    }


def _run(system, **options):
    start = system.body.state((0.5, 0.5, -0.5, 0.5), omega_body=OMEGA)
    return pt.propagate(system, start, [0.0, END], **options)


def _forces(short):
    """Return body and force by name, the gravity gradient first."""
    highest = 4 if short else 16
    field = _field(highest)
    body = pt.Body.from_inertia(field.inertia_deviator + 0.4 * np.eye(3))
    ellipsoid = pt.Body.from_ellipsoid(1.0, SEMIAXES)
    forces: dict[str, tuple[pt.Body, pt.Potential]] = {"`GravityGradient`": (body, pt.GravityGradient(ORBIT))}
    for degree in (2, 4, 8, 16):
        if degree <= highest:
            forces[f"`HarmonicGravity`, degree {degree}"] = (
                body,
                pt.forces.HarmonicGravity(ORBIT, field.truncated(degree)),
            )
    if not short:
        forces["`EllipsoidGravity`"] = ellipsoid, pt.forces.EllipsoidGravity(ORBIT, 1.0, SEMIAXES)
        forces["`MasconGravity`, 100 points"] = _points(100)
    return forces


def _field(degree):
    """Coefficients by chance, smaller with the degree."""
    sizes = 0.1 / np.maximum(np.arange(degree + 1), 1)[:, None] ** 2
    C, S = sizes * np.tril(np.random.default_rng(1).normal(size=(2, degree + 1, degree + 1)))
    C[:2], S[:2], S[:, 0] = 0, 0, 0
    return pt.GravityField.from_normalized(1.0, 1.0, C, S)


def _points(count):
    random = np.random.default_rng(2)
    masses, points = random.uniform(1, 2, count) / count, random.normal(size=(count, 3)) * (0.5, 0.35, 0.25)
    points -= masses @ points / masses.sum()
    return pt.Body.from_point_masses(masses, points), pt.forces.MasconGravity(ORBIT, masses, points)
