"""Partial derivatives of a light curve against a reference with 50 digits, which shares no code with the package."""

import json
from pathlib import Path

import numpy as np
import pytest

import poinsot as pt
from poinsot.analysis import observed_partials
from poinsot.observables import LightCurve, LommelSeeliger

CASES = json.loads(Path(__file__).with_name("reading_partials_cases.json").read_text())["cases"]

BOUND = 2e-14
"""Three times the worst error of a column, 6e-15 of its largest derivative, over cases with perturbed times."""


class ThrustAndDamping(pt.Torque):
    direction: pt.BodyVector
    size: float
    damping: float

    def torque(self, instant):
        return self.size * pt.functions.Vector(self.direction) - self.damping * instant.omega_body


class Tide(pt.Torque):
    """Gravity gradient of a point at rest, also of the mass zero."""

    mu: float
    position: pt.SpaceVector

    def torque(self, instant):
        distance = pt.functions.norm(self.position)
        u = instant.attitude.to_body(self.position) / distance
        of_inertia = [pt.functions.dot(row, u) for row in instant.inertia]
        return 3 * self.mu / distance**3 * pt.functions.cross(u, of_inertia)


def set_up(case, kind="relative"):
    """Return system, initial state, light curve and the factor of its values for a brightness."""
    place = case["position_from_attractor"]
    known = case["mu"] > 0
    tide = pt.GravityGradient(pt.orbits.FixedPosition(case["mu"], position=place)) if known else Tide(0.0, place)
    force = ThrustAndDamping(case["torque_direction_body"], case["torque"], case["damping"])
    system = pt.System(pt.Body(case["moments"]), force, tide)
    q = np.array(case["quaternion"])
    start = system.state(q / np.linalg.norm(q), angular_momentum_body=case["angular_momentum_body"])
    sun, observer = (
        pt.orbits.FixedPosition(1.0, position=-1000 * np.array(case[name])) for name in ("to_sun", "to_observer")
    )
    shape = pt.shapes.Ellipsoid(case["semi_axes"], density=1.0)
    curve = LightCurve(shape, LommelSeeliger(case["w"]), sun, observer, kind=kind, light_time=False)
    return system, start, curve, sum(curve.shape.areas) / 4


@pytest.mark.parametrize("case", CASES, ids=[case["name"] for case in CASES])
def test_derivatives_by_start_moments_torque_damping_mu_and_semiaxes(case):
    system, start, curve, area = set_up(case)
    names = ["moments", "size", "damping", "forces[1].mu" if case["mu"] == 0 else "forces[1].orbit.mu", "stretch"]
    found = observed_partials(system, start, curve, case["times"], names)
    assert found.coordinates == tuple(case["parameters"][:6])
    assert np.allclose(found.values * area, case["brightness"], rtol=3e-15, atol=0)
    derivatives = np.concatenate([found.by_start, found.by_parameters], axis=-1) * area
    derivatives[:, -3:] /= case["semi_axes"]
    expected = np.array(case["derivatives"])
    errors = np.max(np.abs(derivatives - expected), axis=0) / np.max(np.abs(expected), axis=0)
    assert np.max(errors) < BOUND


@pytest.mark.parametrize("case", CASES, ids=[case["name"] for case in CASES])
def test_derivatives_of_magnitudes_follow_from_derivatives_of_the_flux(case):
    system, start, curve, _ = set_up(case)
    magnitude = set_up(case, "magnitude")[2]
    flux, other = observed_partials(system, start, [curve, magnitude], case["times"])
    expected = -2.5 / np.log(10) * flux.by_start / flux.values[:, None]
    assert np.allclose(other.by_start, expected, rtol=0, atol=1e-14 * np.max(np.abs(expected)))


def test_an_albedo_that_two_curves_share_is_one_parameter():
    system, start, curve, _ = set_up(CASES[1])
    second = LightCurve(curve.shape, curve.law, curve.sun, curve.observer, kind="flux", light_time=False)
    found = observed_partials(system, start, [curve, second], CASES[1]["times"], ["law.albedo"])
    for one in found:
        assert one.parameters == ("light_curve.law.albedo",)
        assert np.allclose(one.by_parameters[:, 0], one.values / curve.law.albedo, rtol=1e-14, atol=0)
