"""What a motion conserves, what it does not, and what it must not depend on."""

import numpy as np
import pytest
from hypothesis import Phase, assume, example, given, settings
from hypothesis import strategies as st
from scipy.spatial.transform import Rotation

import poinsot as pt
from poinsot.functions import cross, dot

LAWS = settings(
    derandomize=True, max_examples=30, deadline=None, database=None, phases=(Phase.explicit, Phase.generate)
)
TIMES = np.linspace(0, 12, 25)
EXACT = 1e-13
"""Drift allowed in some tens of steps of double precision, for quantities of the order of one and larger."""

THREE_MOMENTA = {f"angular_momentum_space_{k}" for k in "123"}


# ---------------------------------------------------------------------- bodies and states


def moments_of(second_moments):
    a, b, c = second_moments
    return np.array([b + c, a + c, a + b])


def vectors(size):
    return st.tuples(*[st.floats(-size, size)] * 3).map(np.array)


def unit_from(x):
    length = np.linalg.norm(x)
    assume(length > 0.1)
    return x / length


GENERIC = st.tuples(*[st.floats(0.1, 1)] * 3).map(moments_of)
DEGENERATE = st.sampled_from(
    [
        (1.0, 1.0, 1.0),
        (1.0, 1.0, 1 + 1e-9),
        (1.0, 1.0, 0.6),
        (0.5, 1.0, 1.0),
        (1.0, 1 + 1e-10, 0.6),
        (0.4, 0.6, 1.0),
        (0.4, 0.6, 1 - 1e-12),
        (1.0, 1.0, 0.02),
    ]
).map(np.array)
MOMENTS = GENERIC | DEGENERATE
ROTATIONS = (
    st.tuples(*[st.floats(-1, 1)] * 4).map(np.array).map(unit_from)
    | st.sampled_from([(1.0, 0, 0, 0), (0, 1.0, 0, 0), (0, 0, 0, 1.0), (np.sqrt(0.5), np.sqrt(0.5), 0, 0)])
).map(lambda q: Rotation.from_quat(np.array(q), scalar_first=True))
MOMENTA = vectors(1.5) | st.sampled_from([(0.0, 0, 0), (0, 1.0, 0), (0, 1.0, 1e-9), (0, 0, -1.0)]).map(np.array)
LEVERS = vectors(1.0)


@st.composite
def states(draw):
    q = draw(ROTATIONS).as_quat(scalar_first=True)
    return pt.Body((1, 1, 1)).state(q, angular_momentum_body=draw(MOMENTA))


@st.composite
def bodies(draw):
    """Bodies along their principal axes and along others."""
    moments, turn = draw(MOMENTS), draw(st.none() | ROTATIONS)
    return pt.Body(moments) if turn is None else turned_body(pt.Body(moments), turn)


def turned_body(body, turn):
    """The same body, along axes of which `turn` gives the old in the new ones."""
    R = turn.as_matrix()
    tensor = R @ body.inertia @ R.T
    return pt.Body.from_inertia((tensor + tensor.T) / 2)


def orbit(eccentricity):
    return pt.KeplerOrbit(
        1.1,
        semimajor_axis=1.2,
        eccentricity=eccentricity,
        inclination=0.7,
        node=-0.4,
        argument_of_periapsis=1.9,
        true_anomaly=0.3,
        epoch=0.2,
    )


CIRCLE, ELLIPSE = orbit(0.0), orbit(0.3)
AT_REST = pt.orbits.FixedPosition(0.9, position=(0.8, -0.5, 0.7))


# ---------------------------------------------------------------------- quantities by hand


def kinetic_energy(motion):
    g = motion.angular_momentum_body
    return 0.5 * np.einsum("ni,ni->n", g, np.linalg.solve(motion.system.body.inertia, g.T).T)


def space_momentum(motion):
    return motion.attitude.apply(motion.angular_momentum_body)


def height(motion, lever):
    return motion.attitude.apply(lever)[:, 2]


def moment_towards_attractor(motion, positions):
    radial = motion.attitude.inv().apply(positions / np.linalg.norm(positions, axis=-1, keepdims=True))
    return np.einsum("ni,ij,nj->n", radial, motion.system.body.inertia, radial)


def gravity_gradient_energy(motion, orbit):
    positions = np.stack(np.broadcast_arrays(*orbit.position_at(motion.times)), axis=-1)
    strength = 1.5 * orbit.mu / np.linalg.norm(positions, axis=-1) ** 3
    return strength * moment_towards_attractor(motion, positions)


def variation(values, size=0.0):
    """The largest change since the first row, over the largest size, or over one where all is small."""
    return np.max(np.abs(values - values[0])) / max(1, np.max(np.abs(values)), np.max(np.abs(size)))


def is_conserved(motion):
    """Whether each integral that the system claims keeps its value."""
    energies, momenta = np.abs(motion.kinetic_energy) + np.abs(motion.potential_energy), motion.angular_momentum_body
    return all(
        variation(motion.integrals[integral.name], energies if integral.is_energy else momenta) < EXACT
        for integral in motion.system.integrals
    )


def names(system):
    return {integral.name for integral in system.integrals}


def same_attitudes(rotations, others, allowed):
    return np.max((rotations.inv() * others).magnitude()) < allowed


# ---------------------------------------------------------------------- what is conserved


@LAWS
@given(bodies(), states())
def test_free_motion_keeps_energy_and_momentum_in_space(body, state):
    motion = pt.propagate(pt.System(body), state, TIMES)
    assert {"energy", *THREE_MOMENTA} <= names(motion.system)
    assert variation(kinetic_energy(motion)) < EXACT
    assert variation(space_momentum(motion)) < EXACT
    assert is_conserved(motion)


@LAWS
@given(bodies(), states(), LEVERS)
def test_top_keeps_energy_and_vertical_momentum(body, state, lever):
    motion = pt.propagate(pt.System(body, pt.UniformGravity(0.7, lever)), state, TIMES)
    assert {"energy", "angular_momentum_space_3"} <= names(motion.system)
    T, U = kinetic_energy(motion), 0.7 * height(motion, lever)
    assert variation(T + U, np.abs(T) + np.abs(U)) < EXACT
    assert variation(space_momentum(motion)[:, 2], motion.angular_momentum_body) < EXACT
    assert is_conserved(motion)


@LAWS
@given(bodies(), states())
def test_circular_orbit_keeps_the_jacobi_integral(body, state):
    motion = pt.propagate(pt.System(body, pt.GravityGradient(CIRCLE)), state, TIMES)
    T, U = kinetic_energy(motion), gravity_gradient_energy(motion, CIRCLE)
    jacobi = T + U - np.sqrt(1.1 / 1.2**3) * space_momentum(motion) @ CIRCLE.normal
    assert variation(jacobi, np.abs(T) + np.abs(U)) < EXACT
    assert is_conserved(motion)


@LAWS
@given(bodies(), states())
def test_attractor_at_rest_keeps_energy_and_momentum_towards_it(body, state):
    motion = pt.propagate(pt.System(body, pt.GravityGradient(AT_REST)), state, TIMES)
    T, U = kinetic_energy(motion), gravity_gradient_energy(motion, AT_REST)
    assert {"energy", "angular_momentum_space_attractor"} <= names(motion.system)
    assert variation(T + U, np.abs(T) + np.abs(U)) < EXACT
    assert variation(space_momentum(motion) @ [0.8, -0.5, 0.7], motion.angular_momentum_body) < EXACT


@LAWS
@given(states(), st.sampled_from([0, 1, 2]), st.floats(0.05, 1.9), st.floats(-1, 1))
@example(pt.State((1, 0, 0, 0), (0, 0, 0, 2)), 2, 1.0, 1.0)
def test_symmetric_top_keeps_the_momentum_along_its_axis(state, axis, slenderness, lever):
    moments = np.ones(3)
    moments[axis] = slenderness
    system = pt.System(pt.Body(moments), pt.UniformGravity(0.7, lever * np.eye(3)[axis]))
    motion = pt.propagate(system, state, TIMES)
    assert f"angular_momentum_body_{axis + 1}" in names(system)
    assert variation(motion.angular_momentum_body[:, axis], motion.angular_momentum_body) < EXACT


@LAWS
@given(states(), st.sampled_from([CIRCLE, ELLIPSE, AT_REST]))
def test_gravity_gradient_leaves_the_spin_of_a_symmetric_body_alone(state, around):
    system = pt.System(pt.Body((1.0, 1.0, 0.6)), pt.GravityGradient(around))
    motion = pt.propagate(system, state, TIMES)
    assert "angular_momentum_body_3" in names(system)
    assert variation(motion.angular_momentum_body[:, 2], motion.angular_momentum_body) < EXACT


# ---------------------------------------------------------------------- what is not

BODY = pt.Body((1.3, 1.0, 0.7))
START = BODY.state((0.5, 0.5, -0.5, 0.5), angular_momentum_body=(0.4, -0.6, 0.5))


def test_generic_systems_claim_what_they_keep_and_nothing_else():
    lever = (0.3, -0.2, 0.5)
    assert names(pt.System(BODY)) == {"energy", *THREE_MOMENTA}
    assert names(pt.System(BODY, pt.UniformGravity(0.7, lever))) == {"energy", "angular_momentum_space_3"}
    assert names(pt.System(BODY, pt.GravityGradient(CIRCLE))) == {"jacobi_energy"}
    assert names(pt.System(BODY, pt.GravityGradient(AT_REST))) == {"energy", "angular_momentum_space_attractor"}
    both = pt.System(BODY, pt.UniformGravity(0.7, lever), pt.GravityGradient(AT_REST))
    assert names(both) == {"energy"}


@pytest.mark.parametrize(
    "forces",
    [
        (pt.GravityGradient(ELLIPSE),),
        (pt.GravityGradient(ELLIPSE), pt.UniformGravity(0.7, (0.3, -0.2, 0.5))),
        (pt.GravityGradient(CIRCLE), pt.UniformGravity(0.7, (0.3, -0.2, 0.5))),
        (pt.GravityGradient(CIRCLE), pt.GravityGradient(AT_REST)),
        (pt.forces.LinearDamping(0.1),),
        (pt.forces.LinearDamping(0.1), pt.UniformGravity(0.7, (0.3, -0.2, 0.5))),
    ],
)
def test_nothing_is_claimed_where_nothing_is_conserved(forces):
    system = pt.System(BODY, *forces)
    assert system.integrals == ()
    motion = pt.propagate(system, START, TIMES)
    assert variation(motion.energy) > 1e-2
    assert all(variation(component, motion.angular_momentum_body) > 1e-2 for component in space_momentum(motion).T)
    assert motion.drift == {}


@pytest.mark.parametrize("eccentricity", [1e-12, 1e-8, 1e-3, 0.9])
def test_no_jacobi_integral_next_to_the_circle(eccentricity):
    assert pt.System(BODY, pt.GravityGradient(orbit(eccentricity))).integrals == ()


@pytest.mark.parametrize("difference", [1e-13, 1e-10, 1e-3])
def test_no_momentum_along_an_axis_of_near_symmetry(difference):
    assert "angular_momentum_body_3" not in names(pt.System(pt.Body((1.0, 1 + difference, 0.6))))


def test_no_momentum_along_the_axis_of_a_top_with_its_weight_next_to_it():
    system = pt.System(pt.Body((1.0, 1.0, 0.6)), pt.UniformGravity(0.7, (1e-6, 0, 1)))
    assert "angular_momentum_body_3" not in names(system)


@LAWS
@given(bodies(), states(), st.floats(0.01, 0.5))
def test_damping_takes_energy_at_its_own_rate(body, state, coefficient):
    system = pt.System(body, pt.UniformGravity(0.7, (0.3, -0.2, 0.5)), pt.forces.LinearDamping(coefficient))
    assume(np.min(body.moments) > 0.1)
    assert "energy" not in names(system)
    motion, step = pt.propagate(system, state, [0, 6], dense=True), 0.02
    middle = np.linspace(0.1, 5.9, 30)
    neighbours = step * np.array([[-3], [-2], [-1], [1], [2], [3]])
    energies = np.array([system.energy(motion(times)) for times in middle + neighbours])
    rate = np.array([-1, 9, -45, 45, -9, 1]) @ energies / (60 * step)
    lost = coefficient * np.sum(body.omega(motion(middle).angular_momentum_body) ** 2, axis=-1)
    assert np.max(np.abs(rate + lost)) < 1e-7 * max(1, np.max(lost))
    assert np.all(np.diff(system.energy(motion(np.linspace(0, 6, 61)))) <= 1e-14)


# ---------------------------------------------------------------------- time


REVERSIBLE = {
    "free": (),
    "top": (pt.UniformGravity(0.7, (0.3, -0.2, 0.5)),),
    "attractor at rest": (pt.GravityGradient(AT_REST),),
}


@pytest.mark.parametrize("forces", REVERSIBLE.values(), ids=REVERSIBLE)
@LAWS
@given(body=bodies(), state=states())
def test_turning_the_momentum_over_runs_the_motion_back(forces, body, state):
    system = pt.System(body, *forces)
    there = pt.propagate(system, state, [6.0])
    turned_over = body.state(there.quaternion[0], angular_momentum_body=-there.angular_momentum_body[0])
    back = pt.propagate(system, turned_over, [6.0])
    allowed = 1e-12 * max(1, np.max(np.abs(body.omega(state.angular_momentum_body))))
    assert np.max(np.abs(back.quaternion[0] - state.quaternion)) < allowed
    assert np.max(np.abs(back.angular_momentum_body[0] + state.angular_momentum_body)) < allowed


SYSTEMS = {
    **{name: pt.System(BODY, *forces) for name, forces in REVERSIBLE.items()},
    "ellipse": pt.System(BODY, pt.GravityGradient(ELLIPSE)),
    "damped": pt.System(BODY, pt.GravityGradient(ELLIPSE), pt.forces.LinearDamping(0.05)),
}
each_system = pytest.mark.parametrize("system", SYSTEMS.values(), ids=SYSTEMS)


def close(motion, quaternions, momenta, allowed):
    assert np.max(np.abs(motion.quaternion - quaternions)) < allowed
    assert np.max(np.abs(motion.conjugate_momenta - momenta)) < allowed


@each_system
def test_order_of_the_times_changes_nothing(system):
    rising, falling = (pt.propagate(system, START, times) for times in (TIMES, TIMES[::-1]))
    assert np.array_equal(falling.times, TIMES[::-1])
    close(falling, rising.quaternion[::-1], rising.conjugate_momenta[::-1], 1e-15)


@each_system
def test_times_in_between_change_nothing(system):
    few, many = (pt.propagate(system, START, times) for times in (TIMES, np.linspace(0, 12, 241)))
    close(few, many.quaternion[::10], many.conjugate_momenta[::10], 1e-13)


@each_system
@pytest.mark.parametrize("index", [0, 7, 12, 24])
def test_start_anywhere_on_the_motion_is_the_same_motion(system, index):
    motion = pt.propagate(system, START, TIMES)
    state = BODY.state(
        motion.quaternion[index], angular_momentum_body=motion.angular_momentum_body[index], time=TIMES[index]
    )
    close(pt.propagate(system, state, TIMES), motion.quaternion, motion.conjugate_momenta, 1e-12)


@each_system
@pytest.mark.parametrize("start", [-1.0, 0.0, 5.3, 12.0, 13.0])
def test_dense_output_is_the_motion_on_the_grid(system, start):
    state = pt.State(START.quaternion, START.conjugate_momenta, start)
    dense, grid = (pt.propagate(system, state, TIMES, dense=dense) for dense in (True, False))
    close(dense, grid.quaternion, grid.conjugate_momenta, 1e-13)
    states = dense(TIMES[::-1])
    close(grid, states.quaternion[::-1], states.conjugate_momenta[::-1], 1e-13)


@pytest.mark.parametrize("name", ["free", "top", "attractor at rest"])
def test_clock_of_an_autonomous_system_is_arbitrary(name):
    later = pt.State(START.quaternion, START.conjugate_momenta, 1000.0)
    motion = pt.propagate(SYSTEMS[name], START, TIMES)
    close(
        pt.propagate(SYSTEMS[name], later, 1000 + TIMES),
        motion.quaternion,
        motion.conjugate_momenta,
        1e-11,
    )


# ---------------------------------------------------------------------- axes


def turned_orbit(orbit, turn):
    r, v = (np.array(x, dtype=float) for x in (orbit.position_at(orbit.epoch), orbit.velocity_at(orbit.epoch)))
    return pt.KeplerOrbit.from_vectors(
        float(orbit.mu), position=turn.apply(r), velocity=turn.apply(v), epoch=float(orbit.epoch)
    )


def turned_state(state, turn):
    attitude = turn * state.attitude
    return BODY.state(attitude, angular_momentum_body=state.angular_momentum_body, time=state.time)


def world_is_turned(turn, state, forces, turned_forces):
    motion = pt.propagate(pt.System(BODY, *forces), state, TIMES)
    elsewhere = pt.propagate(pt.System(BODY, *turned_forces), turned_state(state, turn), TIMES)
    assert same_attitudes(turn * motion.attitude, elsewhere.attitude, 1e-11)
    assert np.max(np.abs(motion.angular_momentum_body - elsewhere.angular_momentum_body)) < 1e-11
    assert np.max(np.abs(turn.apply(motion.omega_space) - elsewhere.omega_space)) < 1e-11


@LAWS
@given(ROTATIONS, states())
def test_turned_world_has_the_turned_motion(turn, state):
    lever, place = (0.3, -0.2, 0.5), (0.8, -0.5, 0.7)
    world_is_turned(turn, state, (), ())
    world_is_turned(
        turn,
        state,
        (pt.GravityGradient(ELLIPSE), pt.GravityGradient(AT_REST), pt.forces.LinearDamping(0.05)),
        (
            pt.GravityGradient(turned_orbit(ELLIPSE, turn)),
            pt.GravityGradient(pt.orbits.FixedPosition(0.9, position=turn.apply(place))),
            pt.forces.LinearDamping(0.05),
        ),
    )
    about_vertical = Rotation.from_rotvec([0, 0, turn.magnitude()])
    gravity = pt.UniformGravity(0.7, lever)
    world_is_turned(about_vertical, state, (gravity,), (gravity,))


@LAWS
@given(MOMENTS, ROTATIONS, states())
def test_axes_of_the_body_are_a_matter_of_description(moments, turn, state):
    lever, body = np.array([0.3, -0.2, 0.5]), pt.Body(moments)
    assume(np.min(moments) > 0.1)
    common = (pt.GravityGradient(ELLIPSE), pt.forces.LinearDamping(0.05))
    motion = pt.propagate(pt.System(body, pt.UniformGravity(0.7, lever), *common), state, TIMES)
    other = turned_body(body, turn)
    other_state = other.state(
        state.attitude * turn.inv(), angular_momentum_body=turn.apply(state.angular_momentum_body)
    )
    described = pt.propagate(pt.System(other, pt.UniformGravity(0.7, turn.apply(lever)), *common), other_state, TIMES)
    assert same_attitudes(motion.attitude * turn.inv(), described.attitude, 1e-10)
    assert np.max(np.abs(motion.omega_space - described.omega_space)) < 4e-12
    assert np.max(np.abs(motion.energy - described.energy)) < 4e-12


# ---------------------------------------------------------------------- a user's own forces


class Spring(pt.Potential):
    """A spring that pulls an axis of the body across the first space axis."""

    stiffness: float
    axis_body: pt.mechanics.Vector

    def energy(self, instant):
        return 0.5 * self.stiffness * dot(self.axis_body, instant.attitude.to_body((1, 0, 0))) ** 2


class SpringTorque(pt.Torque):
    """The same, its torque by hand."""

    stiffness: float
    axis_body: pt.mechanics.Vector

    def torque(self, instant):
        s1 = instant.attitude.to_body((1, 0, 0))
        return self.stiffness * dot(self.axis_body, s1) * cross(s1, self.axis_body)


class Motor(pt.Torque):
    """A torque along a body axis that swings with time."""

    strength: float
    frequency: float
    axis_body: pt.mechanics.Vector

    def torque(self, instant):
        return self.strength * pt.functions.cos(self.frequency * instant.time) * self.axis_body


@LAWS
@given(bodies(), states(), st.floats(0.1, 2), vectors(1.0))
def test_potential_of_a_user_keeps_what_it_must(body, state, stiffness, axis):
    motion = pt.propagate(pt.System(body, Spring(stiffness, axis)), state, TIMES)
    assert {"energy", "angular_momentum_space_1"} <= names(motion.system)
    T, U = kinetic_energy(motion), 0.5 * stiffness * motion.attitude.apply(axis)[:, 0] ** 2
    assert variation(T + U, np.abs(T) + np.abs(U)) < EXACT
    assert variation(space_momentum(motion)[:, 0], motion.angular_momentum_body) < EXACT


@LAWS
@given(MOMENTS, states(), st.floats(0.1, 2), vectors(1.0))
def test_potential_of_a_user_turns_as_its_torque_written_by_hand(moments, state, stiffness, axis):
    assume(np.min(moments) > 0.1)
    derived, by_hand = (
        pt.propagate(pt.System(pt.Body(moments), kind(stiffness, axis)), state, TIMES)
        for kind in (Spring, SpringTorque)
    )
    close(derived, by_hand.quaternion, by_hand.conjugate_momenta, 1e-11)


def test_torque_of_a_user_is_trusted_with_no_energy():
    system = pt.System(BODY, SpringTorque(0.8, (0.3, -0.2, 0.5)))
    assert names(system) == {"angular_momentum_space_1"}


def test_motor_of_a_user_spins_the_body_up_by_its_closed_form():
    strength, frequency = 0.4, 1.7
    start = BODY.state((1, 0, 0, 0), angular_momentum_body=(0, 0, 0.2))
    motion = pt.propagate(pt.System(BODY, Motor(strength, frequency, (0, 0, 1))), start, TIMES)
    swing = strength / frequency
    assert np.max(np.abs(motion.angular_momentum_body[:, 2] - 0.2 - swing * np.sin(frequency * TIMES))) < 1e-13
    angle = (0.2 * TIMES + swing / frequency * (1 - np.cos(frequency * TIMES))) / 0.7
    assert same_attitudes(Rotation.from_rotvec(angle[:, None] * [0, 0, 1]), motion.attitude, 1e-13)
    assert names(motion.system) == set()
