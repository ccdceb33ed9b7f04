"""Systems of two bodies with each force on two bodies, in any units."""

from typing import Any

import numpy as np

import poinsot as pt

TURNS = [np.array([0.8, 0.0, 0.6, 0.0]), np.array([0.5, 0.5, -0.5, 0.5])]
SPINS = [np.array([0.1, 0.2, 1.0]), np.array([0.05, 0.1, 0.4])]
POSITION, VELOCITY = np.array([6.0, 1.0, 2.0]), np.array([-0.1, 0.6, 0.3])
MASSES = [3.0, 0.5]
MOMENTS = [np.array([2.0, 2.5, 3.0]), np.array([0.1, 0.12, 0.15])]
ENDS = np.array([-9.0, 14.0, 30.0])


def sun(L, T):
    elements = {"eccentricity": 0.3, "inclination": 0.4, "node": 0.5, "true_anomaly": 0.7}
    return pt.KeplerOrbit(40.0 * L**3 / T**2, semimajor_axis=35.0 * L, **elements)


def flyby(L, T):
    plane = {"inclination": 0.9, "node": 0.2, "argument_of_periapsis": 0.4}
    return pt.orbits.EscapeOrbit(
        20.0 * L**3 / T**2, periapsis_distance=20.0 * L, eccentricity=1.4, epoch=10.0 * T, **plane
    )


class Attraction(pt.Potential):
    """The gravity of a third body on one of two, complete to second degree."""

    orbit: pt.Orbit
    mass: float

    def energy(self, instant):
        inverse, radial = instant.inverse_distance(self.orbit), instant.attitude.to_body(instant.direction(self.orbit))
        spread = sum(instant.body.moments) - 3 * instant.body.moment_about(radial)
        return -self.orbit.mu * inverse * (self.mass + 0.5 * inverse * inverse * spread)


def forces_of(name, first="primary", second="secondary", M=1.0, L=1.0, T=1.0):
    """The forces in addition to the mutual gravity, in units of mass, length and time."""
    rate = M * L**2 / T
    tide, damping = pt.forces.TidalFriction, pt.forces.LibrationDamping
    return {
        "gravity": lambda: (),
        "third body": lambda: (pt.forces.ThirdBody(sun(L, T)),),
        "flyby": lambda: (pt.forces.ThirdBody(flyby(L, T)),),
        "tides": lambda: (tide(first, 0.3, 1.4 * L, 0.2 * T), tide(second, 0.4, 0.7 * L, 0.3 * T)),
        "damping": lambda: (damping(second, 2e-3 * rate), damping(first, 1e-2 * rate)),
        "of one body": lambda: (
            Attraction(sun(L, T), 2.0 * M).on(first),
            pt.forces.LinearDamping(0.01 * rate).on(second),
        ),
    }[name]()


NAMES = ("gravity", "third body", "flyby", "tides", "damping", "of one body")
GRAVITIES = {pt.forces.MutualGravity, pt.forces.MutualHarmonics, pt.forces.MutualMascons}
PAIR_FORCES = {type(force) for name in NAMES for force in forces_of(name)} | GRAVITIES


def system_of(name, *, exchanged=False, M=1.0, L=1.0, T=1.0):
    bodies = [pt.Body(M * L**2 * x, mass=M * mass) for x, mass in zip(MOMENTS, MASSES, strict=True)]
    names = ("secondary", "primary") if exchanged else ("primary", "secondary")
    pair = pt.TwoBodies(*bodies[:: -1 if exchanged else 1], G=L**3 / (M * T**2))
    return pt.System(pair, pt.forces.MutualGravity(), *forces_of(name, *names, M=M, L=L, T=T))


def start_of(system, *, exchanged=False, L=1.0, T=1.0, shift=0.0):
    order = -1 if exchanged else 1
    return system.state(
        order * L * (POSITION + shift),
        order * L / T * VELOCITY,
        TURNS[::order],
        omega_body=[spin / T for spin in SPINS[::order]],
    )


def propagated(name, times=ENDS, **options) -> Any:
    system = system_of(name)
    return pt.propagate(system, start_of(system), times, **options)


def rows(motion):
    """Position, velocity, quaternions and rates of a motion, each over its size; of times, and members before them."""
    own = [motion.position, motion.velocity]
    own += [x for each in (motion.primary, motion.secondary) for x in (each.quaternion, each.omega_body)]
    return np.concatenate([x / np.max(np.linalg.norm(x, axis=-1)) for x in own], axis=-1)
