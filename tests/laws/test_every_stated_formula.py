"""Formulas that readers are shown say what the code computes: their MathML is read again, and its arithmetic done."""

import dataclasses
from typing import Any
from xml.etree import ElementTree as ET

import numpy as np
import pytest
from scipy.spatial.transform import Rotation
from scipy.special import lpmv

import poinsot as pt
from kinds.control_laws import LAWS
from kinds.forces import AT_REST, BODIES, FORCES, TIME, label
from kinds.mutual_gravity import FORCES as GRAVITIES
from kinds.mutual_gravity import PAIR
from kinds.pairs import forces_of
from kinds.parts import PARTS
from poinsot.display.formulas import equations
from poinsot.display.notation import LATEX, MATHML, split_name
from poinsot.functions import Vector
from poinsot.mechanics.environment import orbits_of
from poinsot.parts import ControlMomentGyro
from poinsot.quantities import Along, annotated_with
from poinsot.records.parameters import Parametric
from poinsot.systems.symbolic_formula import formula_of

SIGNS = {
    "+": "))+((",
    "−": "))-((",
    "\u2062": "*",
    "×": "*",
    "(": "(((",
    ")": ")))",
    ",": ")),((",
    "·": ")@(",
    "⨯": ")%(",
}
"""Of operators that hold together the less tightly the more brackets are around them."""

TOO_LONG = {"EllipsoidGravity", "MutualHarmonics"}
"""Integrals and series that are described in words."""


class Vec(np.ndarray):
    """A vector: * with numbers, @ for the product that is a number, % for the one that is a vector."""

    def __mod__(self, other):
        return np.cross(self, other).view(Vec)


class Tensor:
    """A tensor, which is written before the vector on which it acts."""

    def __init__(self, rows):
        self.rows = np.asarray(rows)

    def __mul__(self, vector):
        return (self.rows @ vector).view(Vec)


class Indexed:
    """What has an index, as a function of it."""

    def __init__(self, function):
        self.function = function

    def __getitem__(self, index):
        return self.function(*index) if isinstance(index, tuple) else self.function(index)


def vec(components):
    return np.array([float(x) for x in components]).view(Vec)


def row(elements):
    """The arithmetic of elements one after the other, as Python."""
    text, inside = "", False
    for element in elements:
        if element.tag == "mo" and element.text == "|":
            text, inside = text + (")))" if inside else "size((("), not inside
        elif element.tag == "mo" and element.text == "−" and (not text or text.endswith("(")):
            text += "-"
        elif element.tag == "mrow" and element[0].tag in ("munder", "munderover"):
            text += total(element)
        else:
            text += read(element)
    return f"((({text})))"


def total(element):
    """A sum over an index: over all, or from a number to another."""
    under = element[0][1]
    index = (under if under.tag == "mi" else under[0]).text
    ends = "".join(f", {read(end)}" for end in (under[2], element[0][2])) if element[0].tag == "munderover" else ""
    return f"total({index!r}, lambda: {row(element[1:])}{ends})"


def below(element):
    """A name with an index: digits belong to the name, letters are looked up."""
    name, index = "".join(element[0].itertext()), list(element[1])
    if all(each.tag == "mn" for each in index):
        return f"at[{name + ''.join(each.text for each in index)!r}]"
    return f"at[{name!r}][{', '.join(map(read, index))}]"


READ = {
    "mfrac": lambda element: f"({row(element[0])} / {row(element[1])})",
    "msup": lambda element: f"({read(element[0])}) ** {read(element[1])}",
    "msqrt": lambda element: f"sqrt({row(element)})",
    "mover": lambda element: f"at['rate {element[0].text}']",
    "msub": below,
    "mi": lambda element: f"at[{element.text!r}]",
    "mo": lambda element: SIGNS[element.text],
    "mn": lambda element: element.text,
}


def read(element):
    """The arithmetic that a reader of MathML sees, as Python."""
    return READ.get(element.tag, row)(element)


def evaluated(equations, at):
    """All letters with those to the left of equations, each of which may need others."""
    at = dict(at)

    def sum_over(index, summand, first=0, last=None):
        end = at["count"][index] if last is None else last + 1
        return sum(at.update({index: i}) or summand() for i in range(int(first), int(end)))

    tools = {"at": at, "sqrt": np.sqrt, "size": np.linalg.norm, "total": sum_over}
    waiting = list(equations)
    while waiting:
        left, equals, *right = ET.fromstring(f"<math>{waiting[-1]}</math>")
        assert equals.text == "="
        formula = compile(row(right), left.text or "", "eval")
        name = f"rate {left[0].text}" if left.tag == "mover" else "".join(left.itertext())[:1]
        try:
            at[name] = (
                Indexed(lambda *_, formula=formula: eval(formula, tools))
                if left.tag == "msub"
                else eval(formula, tools)
            )
            waiting.pop()
        except KeyError:  # it needs one that comes before
            waiting.insert(0, waiting.pop())
    return at


def numbers_by_name(thing, turn):
    """The parameters of a record and of those in it by their names in its formula, vectors along the body axes."""
    found, axes = {}, annotated_with(type(thing), Along)
    for field in dataclasses.fields(thing):
        value, name = getattr(thing, field.name), field.name.replace("_", " ")
        if isinstance(value, pt.Orbit):
            continue
        if isinstance(value, Parametric):
            found = numbers_by_name(value, turn) | found
        elif isinstance(value, int | float | np.ndarray) and not isinstance(value, bool):
            array = np.asarray(value, dtype=float)
            if field.name in axes and axes[field.name].axes == "space axes":
                array = turn.inv().apply(np.array(array))
            letter, digits = split_name(field.name)
            found[f"{letter}{digits}".replace("_", " ")] = array.view(Vec) if array.ndim else float(array)
            found |= {f"{name}{i + 1}": x for i, x in enumerate(array)} if array.shape == (3,) else {}
            found |= {"count": {"i": len(array)}} if array.shape[1:] == (3,) else {}
            found |= {name: Tensor(array)} if array.shape == (3, 3) and field.name == "tensor" else {}
    return found


CALLS = {"clip": np.clip, "max": max, "sin": np.sin, "cos": np.cos, "trace": lambda tensor: np.trace(tensor.rows)}


def letters(force, body, turn, omega, instant):
    """What belongs to the motion, by its letter; fields and air at the place of the body are the package's."""
    at = {"I": Tensor(body.inertia), "ω": vec(omega), "t": TIME, **CALLS}
    at |= {f"R{i + 1}{j + 1}": x for (i, j), x in np.ndenumerate(turn.as_matrix())}
    at |= {f"s{i + 1}": row.view(Vec) for i, row in enumerate(turn.as_matrix())}
    at |= {
        f"{letter}{i + 1}": x for letter, values in (("I", body.moments), ("ω", omega)) for i, x in enumerate(values)
    }
    for orbit in list(orbits_of(force))[:1]:
        x, v = (turn.inv().apply([float(c) for c in part(TIME)]) for part in (orbit.position_at, orbit.velocity_at))
        r = np.linalg.norm(x)
        at |= {"μ": float(orbit.mu), "x": vec(x), "v": vec(v), "r": r, "u": vec(x / r)}
        at |= {"φ": np.arctan2(-x[1], -x[0])}
        at["P"] = Indexed(lambda n, m, height=-x[2] / r: (-1) ** m * lpmv(m, n, height))
    if hasattr(force, "field") and hasattr(force.field, "in_body"):
        at |= {"B": vec(force.field.in_body(instant)), "rate B": vec(force.field.rate_in_body(instant))}
    if hasattr(force, "field") and hasattr(force.field, "torque"):
        at["T"] = lambda direction: vec(force.field.torque(direction))
    if hasattr(force, "atmosphere"):
        at["w"] = vec(force.atmosphere.relative_velocity(instant, force.orbit))
        at["ρ"] = float(force.atmosphere.density(instant, force.orbit))
    if hasattr(force, "sunlight"):
        at["f"] = float(force.sunlight(instant))
    if hasattr(force, "target"):
        frame = force.orbit.frame if hasattr(force, "orbit") else pt.RotatingFrame((1, 0, 0, 0), (0, 0, 0))
        turned = Rotation.from_quat(np.array(force.target), scalar_first=True).inv() * frame.attitude(TIME).inv() * turn
        at["ε"] = vec(turned.as_quat(canonical=True)[:3])
        at["ν"] = vec(omega - turn.inv().apply(np.array(frame.omega_space(TIME))))
    return at


class Wind(pt.Torque):
    """A torque of the user's own, whose formula is read off its code."""

    strength: float
    axis: pt.BodyVector

    def torque(self, instant):
        f = pt.functions
        turning = f.sin(2.5e-7 * instant.time) / (1 + f.sqrt(instant.omega_body[0] ** 2 + 3))
        return f.cross(self.axis, instant.attitude.to_body((0, -self.strength, 0))) * turning


STATED = [force for force in (*FORCES, *LAWS, Wind(0.5, (0.1, 0, 1))) if type(force).__name__ not in TOO_LONG]
each_force = pytest.mark.parametrize("force", STATED, ids=label)


@pytest.fixture(autouse=True)
def any_body(monkeypatch):
    """A formula holds whether or not the body of a force is the one that turns."""
    for force in FORCES:
        monkeypatch.setattr(type(force), "check", lambda *_: None)


@each_force
def test_the_formula_of_a_force_is_what_it_computes(force):
    body, omega = BODIES[1] if force.formula else BODIES[0], np.array([0.4, -0.7, 0.3])
    system, computed, shown = pt.System(body, force), [], []
    for turn in Rotation.random(2, np.random.default_rng(3)):
        state = system.state(turn, omega_body=omega, time=TIME)
        at = numbers_by_name(force, turn) | letters(force, body, turn, omega, system.at(state))
        letter = "U" if isinstance(force, pt.Potential) else "N"
        shown.append(evaluated(equations(formula_of(force, body, list(orbits_of(force))[:1]), MATHML), at)[letter])
        computed.append(system.potential_energy(state) if letter == "U" else system.torque_body(state))
    assert np.min(np.max(np.abs(computed), axis=-1)) > 1e-9
    np.testing.assert_allclose(shown, computed, rtol=1e-11, atol=1e-13)


# ------------------------------------------------------------------ of two bodies

PAIR_FORCES = (
    *(force for force in GRAVITIES if type(force).__name__ not in TOO_LONG),
    *(force for name in ("third body", "flyby", "tides", "damping") for force in forces_of(name)),
)


@pytest.mark.parametrize("force", PAIR_FORCES, ids=label)
def test_the_formula_of_a_force_on_two_bodies_is_what_it_computes(force):
    """All vectors are along the space axes here."""
    system, computed, shown = pt.System(PAIR, force), [], []
    for seed in (1, 2):
        turns = Rotation.random(2, np.random.default_rng(seed))
        rates = np.array([(0.1, 0.2, 1.0), (-0.3, 0.1, 0.4)])
        start = PAIR.state((5.0, 1.0 - seed, 2.0), (-0.1, 0.6, 0.3), list(turns), omega_body=rates, time=TIME)
        at = numbers_by_name(force, Rotation.identity()) | of_two(force, PAIR, turns, rates, system.at(start))
        found = evaluated(equations(formula_of(force, PAIR, list(orbits_of(force))), MATHML), at)
        if isinstance(force, pt.Potential):
            computed.append(system.potential_energy(start))
            shown.append(found["U"])
        else:
            dynamics: Any = system.dynamics
            load, one = dynamics.load_at(dynamics.at(start)), ("primary", "secondary").index(force.body)
            computed += [load.force, turns[one].apply(vec(load.torques[one]))]
            shown += [found["F"], found["N"]]
    assert np.max(np.abs(np.asarray(computed, dtype=float))) > 1e-9
    np.testing.assert_allclose(shown, np.asarray(computed, dtype=float), rtol=1e-11, atol=1e-15)


def of_two(force, pair, turns, rates, instant):
    """What belongs to the motion of two bodies, by its letter."""
    tensors = [
        turn.as_matrix() @ body.inertia @ turn.as_matrix().T
        for turn, body in zip(turns, pair.bodies.values(), strict=True)
    ]
    masses = np.asarray(pair.masses)
    x, v = vec(instant.separation), vec(instant.relative_velocity)
    r = np.linalg.norm(x)
    at = {**CALLS, "G": float(pair.G), "x": x, "v": v, "r": r, "u": x / r}
    at |= {"m1": masses[0], "m2": masses[1], "I1": Tensor(tensors[0]), "I2": Tensor(tensors[1])}
    if hasattr(force, "body"):
        one = ("primary", "secondary").index(force.body)
        at |= {"ω": vec(turns[one].apply(rates[one])), "m": masses[1 - one]}
    shares = -masses[1] / masses.sum(), masses[0] / masses.sum()
    for orbit in orbits_of(force):
        at |= {"μ": float(orbit.mu), "R": vec(orbit.position_at(TIME))}
        at |= {"m": Indexed(lambda i: masses[int(i) - 1]), "I": Indexed(lambda i: Tensor(tensors[int(i) - 1]))}
        at |= {"y": Indexed(lambda i: shares[int(i) - 1] * x)}
    if hasattr(force, "sets"):
        for turn, (name, (points, positions)) in zip(turns, force.sets.items(), strict=True):
            at.setdefault("count", {})["i" if name == "primary" else "j"] = len(points)
            at |= {f"{name} masses": points, f"{name} positions": turn.apply(np.array(positions)).view(Vec)}
    return at


# ------------------------------------------------------------------ of parts


PARTS_IN_FULL = [part for part in PARTS if part.formula]


@pytest.mark.parametrize("part", PARTS_IN_FULL, ids=label)
def test_the_formula_of_a_part_is_what_it_computes(part):
    assert len(PARTS_IN_FULL) > 5
    own, omega = np.array([0.7, -0.4, 0.9])[: part.size], np.array([0.4, -0.7, 0.3])
    system = pt.System(BODIES[1], part)
    values = {part.name: own} if part.size else {}
    state = system.state((1, 0, 0, 0), omega_body=omega, time=TIME, **values)
    at = numbers_by_name(part, Rotation.identity()) | {"ω": vec(omega), **CALLS}
    letters_of_own = {1: "α" if isinstance(part, ControlMomentGyro) else "p", 2: "αp", 3: "h"}.get(part.size, "")
    at |= {"h": vec(own)} if part.size == 3 else dict(zip(letters_of_own, own, strict=True))
    found = evaluated(equations(formula_of(part, BODIES[1], []), MATHML), at)
    np.testing.assert_allclose(found["h"], vec(part.momentum(Vector(own), TIME)), rtol=1e-14)
    rates = np.ravel([found[f"rate {letter}"] for letter in letters_of_own])
    np.testing.assert_allclose(rates, vec(part.rates(system.at(state), Vector([0.0] * part.size))), rtol=1e-13)


def test_a_formula_is_the_law_of_every_force_but_long_ones():
    for force in (*FORCES, *LAWS, *GRAVITIES, *PAIR_FORCES):
        assert bool(equations(formula_of(force, BODIES[0], list(orbits_of(force))), MATHML)) == (
            type(force).__name__ not in TOO_LONG
        )


class Halved(pt.forces.LinearDamping):
    """Half of the torque of the class from which it derives, whose formula is not its own."""

    def torque(self, instant):
        return super().torque(instant) * 0.5


def test_a_class_that_computes_something_else_does_not_show_the_formula_of_its_base():
    (equation,) = equations(formula_of(Halved(0.3), BODIES[0], []), LATEX)
    assert "0.5" in equation


@pytest.mark.parametrize(
    "stated",
    [
        "N = 2 +",
        "N = x if y else z",
        "N = cross(x)",
        "N = rate()",
        "N = a % b",
        "N = a, b",
        "N = -x; = 3",
        "N = not x",
        "N = {x}",
    ],
)
def test_a_formula_that_is_not_written_as_one_is_refused_where_it_is_shown(stated):
    kind = type("Drag", (pt.forces.LinearDamping,), {"formula": stated})
    with pytest.raises(ValueError, match="formula of a class must be equations"):
        pt.System(BODIES[0], kind(0.3))._repr_latex_()


class Table(Wind):
    """A torque that looks something up."""

    def torque(self, instant):
        return pt.functions.Vector([np.interp(float(instant.time), [0, 1], [0, 1])] * 3)


def test_formulas_of_users_are_written_or_described():
    wind = pt.System(BODIES[0], Wind(0.5, (0, 0, 1)))
    assert "<mi>sin</mi><mo>(</mo>" in wind._repr_html_()
    assert "<mn>2.5</mn><mo>×</mo><msup><mn>10</mn><mn>-7</mn></msup>" in wind._repr_html_()
    assert r"\mathrm{strength}" in wind._repr_latex_()
    assert wind._repr_latex_().count("{") == wind._repr_latex_().count("}")
    assert equations(formula_of(Table(0.5, (0, 0, 1)), BODIES[0], []), MATHML) == []
    long = pt.System(BODIES[0], pt.forces.EllipsoidGravity(AT_REST, 1.1, (0.9, 0.6, 0.4)))
    assert "Exact gravity of an attractor on a homogeneous ellipsoid" in long._repr_html_()
