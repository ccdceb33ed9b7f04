"""What a system claims to conserve it conserves, whatever its offsets and units; and it claims all of a list."""

import numpy as np
import pytest

import poinsot as pt
from poinsot import functions as fn

KEPT = 1e-12
"""Relative changes of conserved quantities: some hundreds of roundings. Other quantities change by far more."""

TRIAXIAL, SYMMETRIC = pt.Body((1.0, 1.2, 1.5)), pt.Body((1.0, 1.0, 0.7))
OBLIQUE = pt.Body.from_inertia([(1.2, 0.2, -0.1), (0.2, 1.0, 0.15), (-0.1, 0.15, 0.9)])
ALMOST_A_BALL = pt.Body((1.0, 1.0 + 1e-13, 1.0 + 3e-13))
ELLIPSE = pt.KeplerOrbit(
    1.0, semimajor_axis=1.0, eccentricity=0.3, inclination=1.1, node=0.4, argument_of_periapsis=0.7
)
NARROW = pt.KeplerOrbit(
    1.0, semimajor_axis=1.0, eccentricity=0.999999, inclination=1.1, node=0.4, argument_of_periapsis=0.7
)
CIRCLE = pt.KeplerOrbit(1.0, semimajor_axis=1.0, eccentricity=0.0)


class Offset(pt.Potential):
    """A slope along the vertical, over an offset."""

    constant: float
    slope: float

    def energy(self, instant):
        return self.constant + self.slope * instant.attitude.to_body((0.0, 0.0, 1.0))[0]


class Breathing(pt.Potential):
    """An offset, and a slope that changes with time."""

    constant: float

    def energy(self, instant):
        return self.constant + 1e-3 * fn.cos(instant.time) * instant.attitude.to_body((0.0, 0.0, 1.0))[0]


class Rotor(pt.Torque):
    """What a rotor at a constant rate does to its carrier: h x omega."""

    h: pt.mechanics.Vector

    def torque(self, instant):
        return fn.cross(self.h, instant.omega_body)


class Gyroscopic(pt.Torque):
    """A torque normal to the rate, which does no work."""

    size: float

    def torque(self, instant):
        return self.size * fn.cross(instant.attitude.to_body((0, 0, 1)), instant.omega_body)


class Sideways(pt.Torque):
    """A torque normal to the angular momentum."""

    size: float

    def torque(self, instant):
        g = instant.angular_momentum_body
        return self.size * fn.cross(instant.attitude.to_body((0.6, 0, 0.8)), g)


class AlongSpace(pt.Torque):
    """A torque along the third axis of space."""

    size: float

    def torque(self, instant):
        return instant.attitude.to_body((0, 0, self.size))


SYSTEMS = {
    **{f"offset {c:g}": pt.System(TRIAXIAL, Offset(c, 0.7)) for c in (0.0, -1e6, 1e12, 1e16)},
    **{f"oblique offset {c:g}": pt.System(OBLIQUE, Offset(c, 1e-3)) for c in (0.0, 1e9)},
    **{f"breathing {c:g}": pt.System(TRIAXIAL, Breathing(c)) for c in (0.0, 1e6, 1e12)},
    "free": pt.System(OBLIQUE),
    "ball on an ellipse": pt.System(pt.Body((1.0, 1.0, 1.0)), pt.GravityGradient(ELLIPSE)),
    "almost a ball on an ellipse": pt.System(ALMOST_A_BALL, pt.GravityGradient(NARROW)),
    "symmetric on an ellipse": pt.System(SYMMETRIC, pt.GravityGradient(ELLIPSE)),
    "circle": pt.System(TRIAXIAL, pt.GravityGradient(CIRCLE)),
    "circle and offset": pt.System(TRIAXIAL, pt.GravityGradient(CIRCLE), Offset(1e12, 0.0)),
    "rotor": pt.System(TRIAXIAL, Rotor((0.3, -0.2, 0.5))),
    "oblique rotor": pt.System(OBLIQUE, Rotor((3e-5, -2e-5, 5e-5))),
    "two rotors": pt.System(TRIAXIAL, Rotor((0.3, -0.2, 0.5)), Rotor((0.1, 0.1, 0.1))),
    "rotor and gravity": pt.System(TRIAXIAL, Rotor((0.3, -0.2, 0.5)), Offset(1e9, 0.7)),
    "gyroscopic": pt.System(TRIAXIAL, Gyroscopic(0.4)),
    "sideways": pt.System(TRIAXIAL, Sideways(0.4)),
    "along space": pt.System(TRIAXIAL, AlongSpace(1e-6)),
    "damped": pt.System(TRIAXIAL, pt.forces.LinearDamping(1e-6)),
}
ROTOR = np.array((0.3, -0.2, 0.5))
ROTORS = {"rotor": ROTOR, "oblique rotor": 1e-4 * ROTOR, "two rotors": ROTOR + 0.1}


def histories(name, motion):
    """The quantities of the list along a motion, by hand, each divided by its size; potentials without offsets."""
    g, G = motion.angular_momentum_body, motion.attitude.apply(motion.angular_momentum_body)
    size, T = np.max(np.linalg.norm(g, axis=-1)), motion.kinetic_energy
    forces = [Offset(0.0, force.slope) if isinstance(force, Offset) else force for force in motion.system.forces]
    forces = [Breathing(0.0) if isinstance(force, Breathing) else force for force in forces]
    H = T + pt.System(motion.system.body, *forces).potential_energy(motion(motion.times))
    return {
        "energy": H / np.max(T),
        "jacobi_energy": (H - G @ (0, 0, 1)) / np.max(T),
        **{f"angular_momentum_space_{k + 1}": G[:, k] / size for k in range(3)},
        "angular_momentum_size": np.linalg.norm(G, axis=-1) / size,
        "angular_momentum_size_with_rotor": np.linalg.norm(g + ROTORS.get(name, np.nan), axis=-1) / size,
        **{f"angular_momentum_body_{k + 1}": g[:, k] / size for k in range(3)},
    }


@pytest.mark.parametrize("name", SYSTEMS)
def test_the_integrals_of_a_system_are_those_that_its_motion_keeps(name):
    system = SYSTEMS[name]
    start = system.body.state((0.48, 0.6, 0.64, 0), omega_body=(0.2, -0.7, 0.9), time=-1.0)
    motion = pt.propagate(system, start, np.linspace(-1, 9, 41), dense=True)
    changes = {quantity: np.ptp(values) for quantity, values in histories(name, motion).items()}
    claimed = {integral.name for integral in system.integrals}
    conserved = {quantity for quantity, change in changes.items() if change < KEPT}
    if {f"angular_momentum_space_{k}" for k in (1, 2, 3)} <= conserved:  # which says it all
        conserved -= {"angular_momentum_size"}
    if "energy" in conserved:
        conserved -= {"jacobi_energy"}
    assert claimed & set(changes) == conserved
    others = claimed - set(changes)  # along axes of orbits: components of a conserved momentum
    assert not others or {f"angular_momentum_space_{k}" for k in (1, 2, 3)} <= conserved
    drifts = {quantity: np.max(np.abs(drift)) for quantity, drift in motion.drift.items()}
    assert all(drift < KEPT for drift in drifts.values())


def test_drift_of_a_momentum_is_relative_to_the_momentum(monkeypatch):
    """A quantity that moves shows as such, however large the energies."""
    system = pt.System(TRIAXIAL, Offset(1e16, 0.7))
    start = TRIAXIAL.state((0.6, 0, 0.8, 0), omega_body=(0.1, 0.2, 0.3))
    motion = pt.propagate(system, start, np.linspace(0, 20, 41))
    first = next(each for each in pt.System(TRIAXIAL).integrals if each.name == "angular_momentum_space_1")
    monkeypatch.setitem(system.__dict__, "integrals", (first,))
    G = motion.angular_momentum_space
    expected = np.max(np.abs(G[:, 0] - G[0, 0])) / np.max(np.linalg.norm(G, axis=-1))
    assert np.max(np.abs(motion.drift["angular_momentum_space_1"])) == pytest.approx(expected, rel=1e-14, abs=0)
    assert expected > 0.1


def test_members_claim_what_all_of_them_keep():
    bodies = pt.Body([(1.0, 1.2, 1.5), (0.8, 1.1, 1.2)])
    names = [each.name for each in pt.System(bodies, Rotor([(0.3, -0.2, 0.5), (0.0, 0.1, 0.4)])).integrals]
    assert names == ["energy", "angular_momentum_size_with_rotor"]
    start = bodies.state([(1.0, 0, 0, 0), (0.6, 0.8, 0, 0)], omega_body=(0.3, -0.5, 0.4))
    system = pt.System(bodies, Rotor([(0.3, -0.2, 0.5), (0.0, 0.1, 0.4)]))
    drift = pt.propagate(system, start, np.linspace(0, 9, 10)).drift["angular_momentum_size_with_rotor"]
    assert drift.shape == (2, 10)
    assert np.max(np.abs(drift)) < KEPT
