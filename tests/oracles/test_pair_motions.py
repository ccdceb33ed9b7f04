"""Motions of two bodies against integrations by two other programs in 30 digits.

`pair_cases.json` says of each state how far a plain integration by Taylor's method in double precision is off.
"""

import json
from pathlib import Path
from typing import Any

import numpy as np
import pytest

import poinsot as pt

CASES = {case["name"]: case for case in json.loads(Path(__file__).with_name("pair_cases.json").read_text())["cases"]}
SECOND_ORDER = [name for name, case in CASES.items() if case["model"] == "second_order"]


def pair_of(case):
    bodies = (pt.Body.from_inertia(case[f"inertia{i}"], case[f"mass{i}"]) for i in (1, 2))
    return pt.TwoBodies(*bodies, G=case["G"])


def start_of(case):
    attitudes, rates = ([case[f"{what}{i}"] for i in (1, 2)] for what in ("attitude", "omega"))
    return pair_of(case).state(case["position"], case["velocity"], attitudes, omega_body=rates)


def errors(motion, i, printed):
    """Return how far a motion is off, relative; of attitudes in radians."""
    own = {"position": motion.position[i], "velocity": motion.velocity[i]}
    for number, body in ((1, motion.primary), (2, motion.secondary)):
        own |= {f"attitude{number}": body.quaternion[i], f"omega{number}": body.omega_body[i]}
    found = {}
    for name, value in own.items():
        exact = np.array(list(map(float, printed[name])))
        if name.startswith("attitude"):
            found[name] = 2 * min(np.linalg.norm(value - exact), np.linalg.norm(value + exact))
        else:
            found[name] = np.linalg.norm(value - exact) / np.linalg.norm(exact)
    return found


def made_of_points(case):
    clouds = (np.array(case[f"points{i}"]) for i in (1, 2))
    shapes = (pt.shapes.Mascons(points[:, 0], points[:, 1:]) for points in clouds)
    return pt.TwoBodies(*map(pt.Body.from_shape, shapes), G=case["G"])


def gravity_of(case):
    if case["model"] == "second_order":
        return pt.forces.MutualGravity()
    return pt.forces.MutualMascons.of_shapes(made_of_points(case))


@pytest.mark.parametrize("name", CASES)
def test_motions(name):
    case = CASES[name]
    system = pt.System(pair_of(case), gravity_of(case))
    motion: Any = pt.propagate(system, start_of(case), [state["time"] for state in case["states"]])
    for i, printed in enumerate(case["states"]):
        allowed = printed["binary64_taylor_error"]
        for what, error in errors(motion, i, printed).items():
            # Three times the worst of ten shaken starts.
            assert error < 60 * allowed[what] + 4e-14, (printed["time"], what)
        size = motion.kinetic_energy[i] - motion.potential_energy[i]
        assert abs(motion.energy[i] - float(printed["energy"])) < 4e-15 * size  # 3 times the worst of these


@pytest.mark.parametrize("name", SECOND_ORDER)
def test_energy_and_angular_momentum_are_those_of_another_program(name):
    case = CASES[name]
    start, system = start_of(case), pt.System(pair_of(case), pt.forces.MutualGravity())
    assert [integral.symbol for integral in system.integrals] == ["H", "G1", "G2", "G3"]
    printed = case["states"][0]
    assert abs(system.energy(start) / float(printed["energy"]) - 1) < 1e-15
    exact = np.array(list(map(float, printed["angular_momentum"])))
    assert np.linalg.norm(start.angular_momentum_space - exact) < 1e-15 * np.linalg.norm(exact)
