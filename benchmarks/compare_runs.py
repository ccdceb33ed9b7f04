"""Comparison of the results of two versions of the code, bit for bit, on a fixed set of runs.

    python -m benchmarks.compare_runs keep out/runs.npz       before the change
    python -m benchmarks.compare_runs compare out/runs.npz    after it: lists each result that differs, and by how much

The file belongs to one machine: processors differ in the last bits.
"""

import itertools
import sys
from pathlib import Path

import numpy as np

import poinsot as pt
from poinsot import functions as f

BODY = pt.Body((1.3, 1.0, 0.7))
OBLIQUE = pt.Body.from_inertia([(1.2, 0.2, -0.1), (0.2, 1.0, 0.15), (-0.1, 0.15, 0.9)])
Q = np.array([0.8, 0.36, -0.48, 0.0])
RATES = (0.3, -0.5, 0.9)
TIMES = np.linspace(-4, 20, 25)
FEW = np.linspace(0, 12, 13)
CIRCLE = pt.KeplerOrbit(1.0, semimajor_axis=1.0, eccentricity=0.0, inclination=0.4, node=0.2)
ELLIPSE = pt.KeplerOrbit(
    1.1,
    semimajor_axis=1.3,
    eccentricity=0.3,
    inclination=0.7,
    node=-0.4,
    argument_of_periapsis=1.9,
    true_anomaly=0.3,
    epoch=0.2,
)
FLYBY = pt.orbits.EscapeOrbit(
    1.0, periapsis_distance=0.8, eccentricity=1.5, inclination=0.3, node=0.2, argument_of_periapsis=0.1, epoch=4.0
)
DRIFTING = pt.orbits.PrecessingOrbit(ELLIPSE, node_rate=0.01, periapsis_rate=-0.02)
RESTING = pt.orbits.FixedPosition(0.9, position=(0.8, -0.5, 0.7))
TURNING = pt.orbits.RotatingPosition(0.9, position=(0.8, -0.5, 0.7), rate=0.3)
HALO = pt.orbits.ThreeBodyPath(
    0.9878, 0.0122, separation=1.0, position=(0.8233, 0.0, 0.0223), velocity=(0.0, 0.1343, 0.0)
)
TABLE = pt.orbits.Ephemeris.from_function(
    1.1, position=lambda t: np.stack(ELLIPSE.position_at(t), axis=-1), start=-5.0, stop=25.0
)
FIELD = pt.GravityField(
    3,
    1.1,
    0.3,
    [(0, 0, 0, 0), (0, 0, 0, 0), (-0.3, 0.05, 0.1, 0), (0.2, 0.1, -0.05, 0.08)],
    [(0, 0, 0, 0), (0, 0, 0, 0), (0, -0.1, 0.15, 0), (0, 0.3, 0.04, -0.06)],
)


class Burn(pt.Torque):
    """A torque switched on by time, rate and attitude."""

    size: float

    def torque(self, instant):
        on_time = f.where(f.less(instant.time, 3.3), self.size, -self.size)
        on_rate = f.where(f.less(instant.omega_body[2], 0.7), 0.1, 0.05)
        return on_time, 0.02 * instant.omega_body[0], on_rate * instant.attitude.to_body((0, 0, 1))[0]


class Edge(pt.Torque):
    """A torque that is defined on one side of a time only."""

    instant: float
    side: float

    def torque(self, instant):
        return 0.1 * f.sqrt(self.side * (instant.time - self.instant)) * f.Vector((0.0, 0.3, 0.2))


class Kick(pt.Event):
    """A change of attitude momentum at zeros of a rate."""

    def value(self, instant):
        return instant.omega_body[0]

    def act(self, body, state):
        g = 1.01 * np.array(state.angular_momentum_body)
        return body.state(state.quaternion, angular_momentum_body=g, time=state.time)


class Bound(pt.Event):
    """A rate that reaches a bound."""

    bound: float

    def value(self, instant):
        return instant.omega_body[2] - self.bound


def alone(force):
    """Return the forces of a run, one or several."""
    return force if isinstance(force, tuple) else (force,)


def single(force=(), body=BODY, times=TIMES, **options):
    """Return the rows of one motion."""
    system = pt.System(body, *alone(force))
    motion = pt.propagate(system, body.state(Q, omega_body=RATES), times, **options)
    out = {"q": motion.quaternion, "Q": motion.conjugate_momenta, "energy": motion.energy, "omega": motion.omega_body}
    out["steps"] = np.array(motion.run.steps)
    if options.get("dense"):
        at = motion(np.linspace(times[0], times[-1], 57))
        out |= {"dense q": at.quaternion, "dense Q": at.conjugate_momenta}
    for i, event in enumerate(motion.events):
        out |= {f"event {i} t": event.times, f"event {i} q": event.states.quaternion}
        out |= {f"event {i} Q": event.states.conjugate_momenta}
    return out


def several(force=(), members=11, body=BODY, times=FEW, threads=1, **options):
    """Return the rows of an ensemble whose members start at different rates and times."""
    shares = np.linspace(0, 1, members)
    state = body.state(
        np.broadcast_to(Q, (members, 4)),
        omega_body=np.outer(1 + 0.3 * shares, RATES),
        time=0.5 * np.round(4 * shares),
    )
    motion = pt.propagate(pt.System(body, *alone(force)), state, times, threads=threads, **options)
    out = {"q": motion.quaternion, "Q": motion.conjugate_momenta, "steps": np.array(motion.run.steps)}
    if motion.failures:
        out["failures"] = np.array(str(motion.failures))
    for i, event in enumerate(motion.events):
        out |= {f"event {i} t": event.times, f"event {i} q": event.states.quaternion}
    return out


def stopped(force, **options):
    """Return what is left of a motion that stops before its end, and why it did."""
    try:
        pt.propagate(pt.System(BODY, *alone(force)), BODY.state(Q, omega_body=RATES), **options)
    except pt.PropagationError as error:
        motion = error.trajectory
        out = {"why": np.array(str(error)), "time": np.array(error.time), "t": motion.times, "q": motion.quaternion}
        return out | {f"event {i} t": event.times for i, event in enumerate(motion.events)}
    raise RuntimeError("it did not stop")


def variations(*forces, order=1):
    """Return the state transition of one motion."""
    system, state = pt.System(BODY, *forces), BODY.state(Q, omega_body=RATES)
    found = pt.analysis.state_transition(system, state, FEW, order=order)
    return {name: np.asarray(value) for name, value in vars(found).items() if isinstance(value, np.ndarray)}


def spectra(force):
    """Return the growth of tangent vectors along a motion."""
    system, state = pt.System(BODY, force), BODY.state(Q, omega_body=RATES)
    chaos, spectrum = (
        pt.analysis.chaos_indicators(system, state, TIMES[5:]),
        pt.analysis.lyapunov_spectrum(system, state, TIMES[5:]),
    )
    parts = {"chaos": vars(chaos), "spectrum": vars(spectrum)}
    return {
        f"{part} {name}": np.asarray(value)
        for part, values in parts.items()
        for name, value in values.items()
        if isinstance(value, np.ndarray | float)
    }


def planar(**options):
    """Return a motion about one axis."""
    state = BODY.state((np.cos(0.2), 0, 0, np.sin(0.2)), omega_body=(0, 0, 1.4))
    motion = pt.propagate(
        pt.System(BODY, pt.GravityGradient(pt.KeplerOrbit(1.0, semimajor_axis=1.0, eccentricity=0.1))),
        state,
        FEW,
        formulation="planar",
        **options,
    )
    return {"q": motion.quaternion, "Q": motion.conjugate_momenta}


def free():
    """Return a motion in closed form."""
    motion = pt.free_motion(BODY, BODY.state(Q, omega_body=RATES), TIMES)
    return {"q": motion.quaternion, "Q": motion.conjugate_momenta}


def events():
    """Return one of each kind: recorded, acting, and one that ends the motion."""
    return (pt.events.RateCrossing((1, 0, 0), rate=0.2), Kick(), Bound(1.5, terminal=True))


FORCES = {
    "no force": (),
    "weight": pt.UniformGravity(0.7, (0.3, -0.2, 0.5)),
    "damping": pt.forces.LinearDamping(0.05),
    "switched": Burn(0.1),
    "circle": pt.GravityGradient(CIRCLE),
    "ellipse": pt.GravityGradient(ELLIPSE),
    "flyby": pt.GravityGradient(FLYBY),
    "precessing": pt.GravityGradient(DRIFTING),
    "resting": pt.GravityGradient(RESTING),
    "turning": pt.GravityGradient(TURNING),
    "table": pt.GravityGradient(TABLE),
    "oblate": (pt.GravityGradient(ELLIPSE), pt.forces.Oblateness(ELLIPSE, 0.3, 0.2, (0.4, -0.3, 0.8))),
    "mascons": pt.forces.MasconGravity(ELLIPSE, (0.6, 0.7), [(0.05, -0.03, 0.02), (-0.03, 0.04, -0.05)]),
    "two orbits": (pt.GravityGradient(ELLIPSE), pt.GravityGradient(RESTING)),
    "orbit and damping": (pt.GravityGradient(ELLIPSE), pt.forces.LinearDamping(0.02)),
    "orbit and weight": (pt.GravityGradient(ELLIPSE), pt.UniformGravity(0.7, (0.3, -0.2, 0.5))),
    "three bodies": (pt.GravityGradient(HALO.from_primary), pt.GravityGradient(HALO.from_secondary)),
}


def cases():
    """Yield the name of each run, and what it returns."""
    for name, force in FORCES.items():
        yield f"{name}, lie_poisson", lambda force=force: single(force)
        yield f"{name}, canonical", lambda force=force: single(force, formulation="canonical")
        yield f"{name}, oblique", lambda force=force: single(force, OBLIQUE)
        yield f"{name}, dense", lambda force=force: single(force, dense=True)
        yield f"{name}, ensemble", lambda force=force: several(force)
        yield f"{name}, events", lambda force=force: single(force, events=events())
    for name in ("no force", "weight", "ellipse", "table", "switched"):
        yield f"{name}, Euler angles", lambda name=name: single(FORCES[name], formulation="euler_angles", times=FEW)
        yield f"{name}, quadruple", lambda name=name: single(FORCES[name], precision="quadruple", times=FEW)
        yield f"{name}, loose", lambda name=name: single(FORCES[name], tolerance=1e-8)
        yield f"{name}, down", lambda name=name: single(FORCES[name], times=TIMES[::-1])
        yield f"{name}, ensemble with events", lambda name=name: several(FORCES[name], events=events())
        yield f"{name}, canonical ensemble", lambda name=name: several(FORCES[name], formulation="canonical")
    for name in ("no force", "weight", "damping", "circle", "ellipse", "orbit and weight", "three bodies"):
        yield f"{name}, state transition", lambda name=name: variations(*alone(FORCES[name]))
    for name in ("weight", "ellipse"):
        yield f"{name}, second order", lambda name=name: variations(FORCES[name], order=2)
        yield f"{name}, spectra", lambda name=name: spectra(FORCES[name])
    yield from edges()
    yield (
        "ellipse, field",
        lambda: single(
            pt.forces.HarmonicGravity(pt.KeplerOrbit(1.1, semimajor_axis=1.3, eccentricity=0.0, inclination=0.2), FIELD)
        ),
    )
    yield "ellipsoid", lambda: single(pt.forces.EllipsoidGravity(RESTING, 1.1, (0.9, 0.6, 0.4)))
    yield "planar", planar
    yield "free motion", free


def edges():
    """Yield runs that stop on the way, and ensembles of each count of members over one thread and two."""
    for name, options in {
        "forwards": {"times": FEW},
        "both ways": {"times": TIMES},
        "down": {"times": TIMES[::-1]},
        "dense": {"times": FEW, "dense": True},
        "quadruple": {"times": FEW, "precision": "quadruple"},
        "events": {"times": TIMES, "events": events()[:2]},
    }.items():
        yield f"edge, {name}", lambda options=options: stopped(Edge(4.55, -1.0), **options)
    yield "two edges", lambda: stopped((Edge(4.55, -1.0), Edge(-2.41, 1.0)), times=TIMES)
    for members, threads in itertools.product((1, 7, 8, 9, 17), (1, 2)):
        options, name = {"members": members, "threads": threads}, f"{members} members, {threads} threads"
        instants, sides = np.full(members, -40.0), np.ones(members)
        instants[[0, -1]], sides[[0, -1]] = (9.55, 6.43), -1.0
        yield name, lambda options=options: several(FORCES["ellipse"], **options)
        yield f"{name}, both ways", lambda options=options: several(FORCES["table"], times=TIMES, **options)
        yield f"{name}, down", lambda options=options: several(FORCES["switched"], times=TIMES[::-1], **options)
        yield f"{name}, events", lambda options=options: several(FORCES["weight"], events=events(), **options)
        yield f"{name}, edges", lambda a=instants, b=sides, o=options: several(Edge(a, b), events=events()[:1], **o)


def results():
    """Return the results of all runs by name; of one that fails, its error sentence."""
    out = {}
    for force in (
        pt.GravityGradient,
        pt.forces.HarmonicGravity,
        pt.forces.MasconGravity,
        pt.forces.EllipsoidGravity,
        pt.forces.Oblateness,
    ):
        force.check = lambda *_: None
    for name, run in cases():
        try:
            found = run()
        except Exception as error:
            found = {"error": np.array(f"{type(error).__name__}: {error}")}
        out |= {f"{name}: {part}": np.asarray(value) for part, value in found.items()}
    return out


def difference(a, b):
    """Return how two results differ, in words; nothing where they are the same bit for bit."""
    if a.shape != b.shape or a.dtype.kind != b.dtype.kind:
        return f"{a.shape} {a} became {b.shape} {b}"[:300]
    if a.dtype.kind == "U":
        return "" if a == b else f"{a} became {b}"
    if a.tobytes() == b.tobytes():
        return ""
    return f"differs by {np.nanmax(np.abs(a - b)):.2g}"


def main(command, path):
    """Keep the results in a file, or compare them with the file's."""
    found = results()
    if command == "keep":
        Path(path).parent.mkdir(parents=True, exist_ok=True)
        np.savez(path, **found)
        print(f"{len(found)} results, {sum(name.endswith(': error') for name in found)} of them errors: {path}")
        return 0
    with np.load(path) as before:
        missing = sorted(set(before.files) ^ set(found))
        lines = {name: difference(before[name], found[name]) for name in before.files if name in found}
    changed = {name: line for name, line in lines.items() if line}
    for name, line in changed.items():
        print(f"{name} {line}")
    for name in missing:
        print(f"{name} is in one of the two only")
    print(f"{len(lines) - len(changed)} of {len(lines)} results are the same bit for bit")
    return 1 if changed or missing else 0


if __name__ == "__main__":
    sys.exit(main(*sys.argv[1:]))
