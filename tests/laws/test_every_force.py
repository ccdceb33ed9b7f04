"""Laws of every shipped force; a new one joins by one instance in `kinds/forces.py`."""

import dataclasses
import gc

import mpmath
import numpy as np
import pytest
import sympy
from scipy.spatial.transform import Rotation

import formulas
import poinsot as pt
from kinds import concrete_subclasses
from kinds.forces import BODIES, FORCES, POTENTIALS, TIME, label, random_attitudes
from kinds.pairs import PAIR_FORCES
from poinsot.algebra.quaternion import product
from poinsot.functions import Vector
from poinsot.integration.scaling import sample_torque
from poinsot.quantities import Along, annotated_with
from poinsot.records.parameters import kinds_of, of_each, records_in
from poinsot.systems.formula_trials import ATTITUDES
from poinsot.taylor.graph import Node
from poinsot.taylor.lowering import Constants
from torques import compiled, compiled_torque, sympy_numbers, turned_orbit

PARTS = pt.Orbit | pt.GravityField | pt.forces.MagneticField | pt.orbits.RotationModel | pt.forces.DirectionalTorque
TIMES = np.linspace(0, 3, 4)


each_force = pytest.mark.parametrize("force", FORCES, ids=label)
each_potential = pytest.mark.parametrize("force", POTENTIALS, ids=label)
each_body = pytest.mark.parametrize("body", BODIES, ids=["principal axes", "oblique axes"])


@pytest.fixture(autouse=True)
def any_body(monkeypatch):
    """These laws hold whether or not the body of a force is the one that turns."""
    for force in FORCES:
        monkeypatch.setattr(type(force), "check", lambda *_: None)


def test_every_force_of_the_package_is_here():
    """Those on two bodies and control laws have laws of their own."""
    shipped = concrete_subclasses(pt.Potential, pt.Torque) - PAIR_FORCES
    forces = {kind for kind in shipped if not kind.__module__.startswith("poinsot.control")}
    assert forces == {type(force) for force in FORCES}


# ---------------------------------------------------------------------- the torque is the slope of the energy


def potential_energy(system, q, time):
    """The energy on numbers of 40 digits."""
    exact = formulas.copied(system, (mpmath.mpf(float(x)) for x in system.dynamics.numbers))
    return formulas.potential(exact, Vector(q), mpmath.mpf(time))


def torque_from_energy(system, q, time):
    """Minus the slope of the energy under small turns about the body axes, q -> q (cos, sin e_k), by differences."""
    step = mpmath.mpf(10) ** -10

    def turned(k, angle):
        turn = [mpmath.cos(angle / 2), 0, 0, 0]
        turn[k] = mpmath.sin(angle / 2)
        return potential_energy(system, product(Vector(map(mpmath.mpf, q)), Vector(turn)), time)

    return np.array([float((turned(k, -step) - turned(k, step)) / (2 * step)) for k in (1, 2, 3)])


TOO_LONG = pt.forces.EllipsoidGravity, pt.forces.AtmosphericDrag, pt.forces.BDot, pt.forces.MeshDrag
"""Forces whose formulas are too long to write out."""


def sympy_torque(system, time):
    if isinstance(system.forces[0], TOO_LONG):
        return lambda q, omega: np.array(sympy_numbers(system, q, omega, time), dtype=float)
    variables = sympy.symbols("q0:4 w1:4", real=True)
    torque = formulas.torque(system, variables[:4], variables[4:], time)
    function = sympy.lambdify(variables, list(torque), "numpy")
    return lambda q, omega: np.array(function(*q, *omega), dtype=float)


@each_body
@each_potential
def test_torque_is_the_slope_of_the_energy_in_both_engines(force, body):
    system, omega = pt.System(body, force), np.zeros(3)
    from_kernel, from_sympy = compiled_torque(system), sympy_torque(system, TIME)
    with mpmath.workdps(40):
        for q in random_attitudes():
            expected = torque_from_energy(system, q, TIME)
            assert np.max(np.abs(from_kernel(q, omega, TIME) - expected)) < 2e-14
            assert np.max(np.abs(from_sympy(q, omega) - expected)) < 2e-14


@each_body
@each_force
def test_torque_is_one_for_both_engines(force, body):
    system, omega = pt.System(body, force), np.array([0.4, -0.7, 0.2])
    from_kernel, from_sympy = compiled_torque(system), sympy_torque(system, TIME)
    torques = [from_kernel(q, omega, TIME) for q in random_attitudes()]
    assert np.count_nonzero(np.max(np.abs(torques), axis=-1) > 1e-3) > 1
    for q, torque in zip(random_attitudes(), torques, strict=True):
        assert np.max(np.abs(torque - from_sympy(q, omega))) < 2e-14


@each_body
@each_potential
def test_energy_is_one_for_floats_and_for_many_digits(force, body):
    system = pt.System(body, force)
    for q in random_attitudes():
        state = pt.State(q, np.zeros(4), TIME)
        with mpmath.workdps(40):
            exact = potential_energy(system, [mpmath.mpf(x) for x in q], TIME)
        assert abs(system.potential_energy(state) - float(exact)) < 6e-15


# ---------------------------------------------------------------------- the world has no preferred axes


def turned_world(record, turn):
    """The force with everything that it sees in space turned; uniform gravity stays along the vertical."""
    if isinstance(record, pt.Orbit):
        return turned_orbit(record, turn)
    if isinstance(record, pt.orbits.RotationModel):
        return turned_rotation(record, turn)
    axes = annotated_with(type(record), Along)
    directions = {
        name: turn.apply(np.array(getattr(record, name))) for name, along in axes.items() if along.axes == "space axes"
    }
    return with_each_part(dataclasses.replace(record, **directions), lambda part: turned_world(part, turn))


def turned_rotation(axes, turn):
    """The axes of a planet, and how they move at the time of the law; not for long."""
    attitude = turn * axes.attitude(TIME)
    first, middle, last = attitude.as_euler("ZXZ")
    about = np.stack([(0, 0, 1), (np.cos(first), np.sin(first), 0), attitude.apply((0, 0, 1))], axis=-1)
    ascending, rising, turning = np.linalg.solve(about, turn.apply(axes.omega_space(TIME)))
    return pt.orbits.RotationModel(
        first - np.pi / 2,
        np.pi / 2 - middle,
        last,
        rate=turning,
        right_ascension_rate=ascending,
        declination_rate=-rising,
        epoch=TIME,
    )


def with_each_part(force, change):
    parts = {name: of_each(getattr(force, name), change) for name in kinds_of(type(force))}
    return dataclasses.replace(force, **parts)


@each_body
@each_force
def test_energy_and_torque_are_unchanged_when_the_whole_world_turns(force, body):
    vertical = Rotation.from_rotvec([[0, 0, 1.3], [0, 0, np.pi]])
    anywhere = Rotation.random(3, np.random.default_rng(5))
    for turn in vertical if isinstance(force, pt.UniformGravity) else anywhere:
        before, after = (pt.System(body, turned_world(force, each)) for each in (Rotation.identity(), turn))
        for q in random_attitudes():
            attitude = Rotation.from_quat(q, scalar_first=True)
            here = body.state(attitude, omega_body=(0.4, -0.7, 0.2), time=TIME)
            there = body.state(turn * attitude, omega_body=(0.4, -0.7, 0.2), time=TIME)
            assert abs(after.potential_energy(there) - before.potential_energy(here)) < 2e-14
            assert np.max(np.abs(after.torque_body(there) - before.torque_body(here))) < 3e-14


# ---------------------------------------------------------------------- parameters


def real_fields(record):
    fields = {field.name: getattr(record, field.name) for field in dataclasses.fields(record)}
    return {name: value for name, value in fields.items() if isinstance(value, np.ndarray)}


def scaled(record, factor):
    """The same record with every real parameter multiplied that may be, parts included."""
    numbers = {name: factor * x for name, x in real_fields(record).items() if name != "normals"}
    return with_each_part(dataclasses.replace(record, **numbers), lambda part: scaled(part, factor))


def nudged(record):
    """The same record with one real parameter changed, in every possible way."""
    for name, value in real_fields(record).items():
        for index in np.ndindex(value.shape):
            if counts(name, index):
                other = value.copy()
                other[index] += 0.07  # to no zero, which has a kernel of its own
                if name == "normals":
                    other /= np.linalg.norm(other, axis=-1, keepdims=True)
                yield f"{name}{list(index)}", dataclasses.replace(record, **{name: other})
    for name in kinds_of(type(record)):
        value = getattr(record, name)
        for i, part in enumerate(records_in(value)):
            for what, other in nudged(part):
                new = other if part is value else (*value[:i], other, *value[i + 1 :])
                yield f"{name}.{what}", dataclasses.replace(record, **{name: new})


def counts(name, index):
    """Return True if a number of a field counts: S_n0, low degrees and numbers right of the diagonal do not."""
    if name in ("C", "S"):
        return index[0] >= 2 and (name == "S") <= index[1] <= index[0]
    if name[0] in "gh" and len(index) == 2:
        return index[0] >= 1 and (name[0] == "h") <= index[1] <= index[0]
    return name != "tensor"  # which stays symmetric


def heavier(body):
    return pt.Body.from_inertia(1.1 * body.inertia)


def motion(body, force):
    start = body.state((0.1, 0.7, -0.5, 0.5), omega_body=(0.4, -0.6, 0.5))
    return pt.propagate(pt.System(body, force), start, TIMES)


@each_body
@each_force
def test_other_numbers_use_the_same_kernel(force, body, forget_kernels):
    forget_kernels()
    first = motion(body, force)
    known = compiled()
    assert len(known) == 1
    second = motion(heavier(body), scaled(force, 1.2))
    assert compiled() == known
    assert np.max(np.abs(first.quaternion - second.quaternion)) > 1e-3


@each_body
@each_force
def test_reused_kernel_gives_what_a_new_one_gives(force, body, forget_kernels):
    forget_kernels()
    motion(body, force)
    reused = motion(heavier(body), scaled(force, 1.2))
    forget_kernels()
    new = motion(heavier(body), scaled(force, 1.2))
    assert np.array_equal(reused.quaternion, new.quaternion)
    assert np.array_equal(reused.conjugate_momenta, new.conjugate_momenta)


@each_body
@each_force
def test_a_system_knows_how_large_a_torque_is_whatever_numbers_its_formulas_were_traced_with(force, body):
    pt.System(body, force)
    system = pt.System(heavier(body), scaled(force, 1.2))
    time = 0.25 + next((orbit.sample_time for orbit in system.orbits if orbit.sample_time), 0.0)
    here, there = (system.state(q, omega_body=(0, 0, 0), time=time) for q in ATTITUDES)
    change = abs(system.potential_energy(there) - system.potential_energy(here))
    expected = max(np.linalg.norm(system.torque_body(here)), change)
    assert abs(sample_torque(system.dynamics) - expected) <= 1e-14 * expected


def test_a_formula_runs_for_the_first_system_of_a_structure_alone():
    calls = []

    class Spring(pt.Potential):
        stiffness: float

        def energy(self, instant):
            calls.append(self.stiffness)
            return 0.5 * self.stiffness * instant.attitude.to_body((0, 0, 1))[0] ** 2

    first = pt.System(BODIES[0], Spring(0.3))
    count = len(calls)
    others = [pt.System(heavier(BODIES[0]), Spring(k)) for k in (0.6, 1.2)]
    assert len(calls) == count
    assert np.allclose(
        [sample_torque(other.dynamics) for other in others],
        np.array((2, 4)) * sample_torque(first.dynamics),
        rtol=1e-14,
        atol=0,
    )


def nodes():
    gc.collect()
    return sum(type(found) is Node for found in gc.get_objects())


def test_known_kernels_keep_no_formula(forget_kernels):
    forget_kernels()
    before = nodes()
    known = [motion(BODIES[0], force).times for force in FORCES]  # and of the motions nothing that is computed from
    assert len(compiled()) == len(known)
    assert nodes() == before


@each_force
def test_each_number_of_a_force_reaches_the_motion(force, forget_kernels):
    forget_kernels()
    first = motion(BODIES[0], force)
    others = {name: motion(BODIES[0], other) for name, other in nudged(force)}
    assert len(compiled()) == 1
    inert = [name for name, other in others.items() if np.max(np.abs(other.quaternion - first.quaternion)) < 1e-3]
    assert len(others) > 0
    assert inert == [
        name for name in others if name.endswith(SURFACES) or name.startswith(IGNORED.get(label(force), ()))
    ]


SURFACES = ("orbit.radius[]", "field.extent[]", "maximum_error[]", "rms_error[]")
"""What is no matter of the motion: surfaces, and the errors of a fit."""
OF_AIR, OF_LIGHT = ("facets.drag", "facets.accommodation"), ("facets.specular", "facets.diffuse")
OF_FIELDS = ("sun_radius", "sun.radius", "field.maximum_error", "field.rms_error")
IGNORED = {
    "AtmosphericDrag KeplerOrbit ExponentialAtmosphere Facets": OF_LIGHT,
    "RadiationPressure KeplerOrbit Facets": (*OF_AIR, "sun_radius", "sun.radius"),
    "MeshDrag KeplerOrbit ExponentialAtmosphere DirectionalTorque": OF_FIELDS,
    "MeshRadiation KeplerOrbit DirectionalTorque": OF_FIELDS,
    "Yorp KeplerOrbit DirectionalTorque": OF_FIELDS,
    "RadiationPressure FixedPosition Facets Occulter": (*OF_AIR, "sun.mu", "occulters.orbit.mu"),
}
"""What forces do not need of the records that they share with others."""


def scalars_in(record):
    """The scalars of a record's real parameters in the order of their declaration."""
    for field in dataclasses.fields(record):
        value = getattr(record, field.name)
        if isinstance(value, int | str):  # structure
            continue
        parts = value if isinstance(value, tuple) else records_in(value)
        yield from (scalar for part in parts for scalar in scalars_in(part))
        if not isinstance(value, tuple) and not parts:
            yield from np.ravel(np.array(value, dtype=object))


@each_force
def test_numbers_make_the_round_trip(force):
    numbers = [float(x) for x in force.numbers]
    copied = force.with_numbers(iter(numbers))
    assert type(copied) is type(force)
    assert len(numbers) > 0
    assert list(scalars_in(copied)) == numbers


@each_body
@each_force
def test_with_its_own_numbers_a_system_is_the_same(force, body):
    system, omega = pt.System(body, force), np.array([0.4, -0.7, 0.2])
    copied = formulas.copied(system, iter(system.dynamics.numbers))
    for q in random_attitudes():
        here, there = (formulas.torque(each, Vector(q), Vector(omega), TIME) for each in (system, copied))
        assert list(here) == list(there)


def test_structure_tells_forces_apart_and_numbers_do_not():
    structures = [force.structure for force in FORCES]
    assert len(set(structures)) == len(FORCES)
    assert [scaled(force, 1.2).structure for force in FORCES] == structures


# ---------------------------------------------------------------------- parameters that are exactly zero


SYMMETRIC = pt.Body((1.2, 1.2, 0.7))
FREE_TO_BE_ZERO = (
    "center_of_mass",
    "position",
    "pole",
    "eccentricity",
    "inclination",
    "node",
    "argument_of_periapsis",
    "true_anomaly",
    "epoch",
    "C",
    "S",
    "masses",
    "positions",
    "right_ascension",
    "prime_meridian",
    "moment",
    "g11",
    "h11",
    "g",
    "h",
    "coefficients",
    "maximum_error",
    "rms_error",
    "specular",
    "omega_space",
)


def simple(record):
    """The same with zeros wherever they are allowed: vectors along one axis, angles and eccentricities gone."""
    fields = {name: value for name, value in vars(record).items() if name in FREE_TO_BE_ZERO}
    zeroed = dataclasses.replace(record, **{name: largest_alone(value) for name, value in fields.items()})
    return with_each_part(zeroed, simple)


def largest_alone(value):
    return np.where(np.abs(value) == np.max(np.abs(value)), 2 * value, 0.0) if np.ndim(value) else 0.0


@pytest.mark.parametrize("body", [SYMMETRIC, BODIES[0]], ids=["symmetric", "asymmetric"])
@each_force
def test_a_motion_without_the_zeros_is_that_with_them(force, body, monkeypatch):
    without = motion(body, simple(force))
    monkeypatch.setattr(Constants, "zeros", lambda *_: ())
    with_them = motion(body, simple(force))
    # The worst of 20 shaken starts is 4e-15, with mascons; without a zero, sums round otherwise.
    assert np.max(np.abs(without.quaternion - with_them.quaternion)) < 3e-14
    assert np.max(np.abs(without.angular_momentum_body - with_them.angular_momentum_body)) < 3e-14


@each_force
def test_zeros_select_a_kernel_and_other_numbers_do_not(force, forget_kernels):
    forget_kernels()
    motion(BODIES[0], force)
    motion(SYMMETRIC, simple(force))
    known = compiled()
    assert len(known) == 2
    motion(pt.Body((1.4, 1.1, 0.8)), force)
    motion(pt.Body((1.3, 1.3, 0.8)), simple(force))
    assert compiled() == known


def test_gravity_on_a_given_orbit_is_for_one_body():
    given = [force for force in FORCES if isinstance(force, pt.Potential) and hasattr(force, "orbit")]
    assert len(given) > 4
    for force in given:
        with pytest.raises(ValueError, match="leaves out parts that move their orbit"):
            force.on("secondary")
