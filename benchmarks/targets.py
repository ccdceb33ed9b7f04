"""Targets of the benchmarks, and the comparison of results with them."""

import itertools
import math
from dataclasses import dataclass

from benchmarks import peers
from benchmarks.ensembles import BATCHES, ONE_CORE, TWO_CORES
from benchmarks.pairs import FOURTH, SECOND
from benchmarks.single import DRIFTING
from benchmarks.start import THEN
from benchmarks.variational import BEFORE

POINSOT, BY_HAND = "poinsot_taylor", "heyoka_by_hand"
FASTER = f", times faster than at {BEFORE}"
AT_EQUAL_ERROR = (
    ("P2", "numbalsoda_dop853", 1.2),
    ("P3", "numbalsoda_dop853", 4.0),
    ("P2", "scipy_dop853", 300.0),
    ("P3", "scipy_dop853", 300.0),
    ("P3", "basilisk_rkf78", 100.0),
    ("P2", "mujoco_rk4", 100.0),
    ("P3", "mujoco_rk4", 100.0),
)
OREKIT_SECONDS = (1.6e-6, 2.2e-6)
"""A call of Orekit's TorqueFree inside Java, from and to; measured apart from this benchmark."""

OREKIT_ERRORS = {1e3: 7.2e-14, 2e4: 2.2e-12, 5e4: 3.4e-12}
"""Its attitude errors on the paper's torque-free case at these times, rad; likewise."""


@dataclass
class Target:
    """A number that must be at most or at least a bound."""

    what: str
    reached: float | None
    bound: float
    most: bool
    unit: str = ""

    @property
    def verdict(self):
        """Say whether it is met, or by how much it is missed."""
        if self.reached is None:
            return "not measured"
        if self.allows(self.reached):
            return "met"
        factor = self.reached / self.bound if self.most else self.bound / self.reached
        return f"**missed** by a factor {factor:.2f}"

    def allows(self, value):
        """Return True if a value meets the target."""
        return value <= self.bound if self.most else value >= self.bound

    def cell(self, value):
        """Return a value, or a dash, for a table."""
        return "-" if value is None else f"{value:.3g}{self.unit}"

    @property
    def row(self):
        """Return the cells of a table."""
        bound = f"{'at most' if self.most else 'at least'} {self.bound:g}{self.unit}"
        return self.what, bound, self.cell(self.reached), self.verdict


def time_at(curve, error):
    """Return the time that a tool needs for an error, between its settings in logarithms; None out of its reach."""
    points = sorted((p["error"], p["seconds"]) for p in curve if "seconds" in p)
    front = []
    for found, seconds in reversed(points):  # from loose to tight, keep what nothing tighter beats
        while front and front[-1][1] >= seconds:
            front.pop()
        front.append((found, seconds))
    if not front or error < front[-1][0]:
        return None
    if error >= front[0][0]:
        return front[0][1]
    for (loose, fast), (tight, slow) in itertools.pairwise(front):
        if tight <= error < loose:
            part = math.log(loose / error) / math.log(loose / tight)
            return math.exp(math.log(fast) + part * math.log(slow / fast))
    return None


def at_equal_error(problem, peer):
    """Return how many times longer a peer takes than poinsot, at the smallest error that both reach, and that error."""
    curves = problem["curves"]
    best = [min((p["error"] for p in curves.get(name, []) if "seconds" in p), default=None) for name in (POINSOT, peer)]
    if None in best:
        return None, None
    error = max(best)
    return time_at(curves[peer], error) / time_at(curves[POINSOT], error), error


def against_the_script(found):
    """Return the targets of the times compared with the script."""
    out = []
    for key, bound in (("P2", 0.55), ("P3", 0.35)):
        low, high = found[key]["ratios"]
        between = f"{low:.2f} to {high:.2f} in {found[key]['processes']} processes"
        what = f"{key}, whole call, time over that of the fastest script ({between})"
        out.append(Target(what, found[key]["ratio"], bound, True))
    return out


def of_errors(found):
    """Return the targets of the errors compared with the script."""
    what = f"error over that of the script, start by start, median of {found['starts']} starts"
    return [Target(f"{key}, {what}", one["ratio"], 1.0, True) for key, one in found["problems"].items()]


def _over_the_best(drifts):
    """Return the largest of our own over the smallest of the script."""
    own = [drifts[name] for name in DRIFTING]
    return max(own) / min(value for name, value in drifts.items() if name not in DRIFTING)


def of_drifts(found):
    """Return the targets of the energy drift, of the formulation that drifts most, compared with the best script."""
    return [
        Target(
            f"{key} to t = {found['end']:g}, energy drift over that of the best script, {found['starts']} starts",
            _over_the_best(sizes),
            3.0,
            True,
        )
        for key, sizes in found["drift"].items()
    ]


def of_long_run(found):
    """Return the target of a long regular motion."""
    times = [found["tools"][name].get("seconds") for name in (BY_HAND, POINSOT)]
    what = f"P3, a regular motion over {found['revolutions']:g} revolutions, times faster than the fastest script"
    return [Target(what, times[0] / times[1] if all(times) else None, 2.5, False)]


def against_peers(measured):
    """Return the targets at equal error."""
    out = []
    for key, peer, bound in AT_EQUAL_ERROR:
        ratio, error = at_equal_error(measured["problems"][key], peer)
        title = peers.TITLES[peer]
        at = "" if error is None else f" at an error of {error:.1e}"
        out.append(Target(f"{key}, times faster than {title}{at}", ratio, bound, False))
    return out


def rate_of(tools, name):
    """Return members per second; None where there is no time."""
    tool = tools.get(name, {})
    return tool["members"] / tool["seconds"] if "seconds" in tool else None


def of_satellites(found):
    """Return the targets of the ensemble of satellites, P4; two threads and one are compared by the clock."""
    tools, limit = found["tools"], found["limit"]
    one, two = rate_of(tools, ONE_CORE), rate_of(tools, TWO_CORES)
    by_the_clock = one and one * tools[ONE_CORE]["busy"]
    rows = (
        ("Ensemble P4, one thread, times a batch of 8 by hand at equal tolerance", one, rate_of(tools, BATCHES), 1.8),
        ("Ensemble P4, two threads, times one", two, by_the_clock, 1.85),
        (
            f"Ensemble P4, two threads, times numbalsoda, each at its fastest with errors below {limit:.0e} rad",
            _fastest(tools, TWO_CORES, limit),
            _fastest(tools, "numbalsoda", limit),
            40.0,
        ),
    )
    out = [Target(what, a / b if a and b else None, bound, False) for what, a, b, bound in rows]
    return [*out, Target("Ensemble P4, largest error of a member", found["worst"][0]["poinsot"], limit, True, " rad")]


def of_tops(found):
    """Return the target of the ensemble of heavy tops, P5."""
    one, by_hand = (rate_of(found["tools"], name) for name in (ONE_CORE, BATCHES))
    what = "Ensemble P5, one thread, times a batch of 8 by hand at equal tolerance"
    return [Target(what, one / by_hand if one and by_hand else None, 2.0, False)]


def of_a_device(found):
    """Return the target of a GPU."""
    device, cores = (rate_of(found.get("tools", {}), name) for name in ("one GPU", "all cores"))
    return [Target("Ensemble P4 on a GPU, times all cores", device / cores if device and cores else None, 20.0, False)]


def _fastest(tools, beginning, limit):
    rates = [
        rate_of(tools, name) for name in tools if name.startswith(beginning) and tools[name].get("error", 1.0) <= limit
    ]
    return max(rates, default=None)


def of_closed_form(measured, stored):
    """Return the targets of the torque-free motion in closed form."""
    epoch, bodies = seconds_per_epoch(measured["million"], "free_motion"), measured["bodies"]
    errors = {row["t"]: row["free_motion"] for row in stored.get("paper", [])}
    random, separatrix = (stored.get(group) or {} for group in ("random", "separatrix"))
    source = "below Orekit's, quoted"
    return [
        Target("Closed form, epochs per second of one body", epoch and 1 / epoch, 1e6, False),
        Target(f"Closed form, an epoch of one body ({source})", epoch and 1e9 * epoch, 1600, True, " ns"),
        Target(f"Closed form, {bodies['bodies']} bodies at one time each", bodies.get("seconds"), 1.0, True, " s"),
        *(
            Target(f"Closed form, error at t = {t:g} ({source})", errors.get(t), bound, True, " rad")
            for t, bound in OREKIT_ERRORS.items()
        ),
        Target("Closed form, random cases, median error / eps (1 + phase)", random.get("median"), 4, True),
        Target("Closed form, random cases, largest error / eps (1 + phase)", random.get("largest"), 50, True),
        Target("Closed form, near the separatrix, error / input rounding", separatrix.get("largest"), 10, True),
    ]


def seconds_per_epoch(million, name):
    """Return the time of an epoch, of a million of them in one call; None where there is no time."""
    return million[name]["seconds"] / million["epochs"] if "seconds" in million[name] else None


def of_second_calls(found):
    """Return the targets of the cost of a call without the kernel."""
    what = "second propagate, new numbers (median of 7 processes)"
    return [
        Target(f"{key}, {what}", 1e6 * found[key]["seconds"], bound, True, " us")
        for key, bound in (("P2", 100), ("P3", 150))
    ]


def of_quadruple(found):
    """Return the targets of quadruple precision."""
    what = "quadruple precision"
    speed = [
        Target(f"{name}, {what}, times faster than real128", one["ratio"], 30, False) for name, one in found.items()
    ]
    bounds = [1e-31 if name.endswith("t = 20") else 5e-30 for name in found]
    errors = [
        Target(f"{name}, {what}, largest error of the quaternion", one["attitude"], bound, True)
        for (name, one), bound in zip(found.items(), bounds, strict=True)
    ]
    return [*speed, *errors]


def of_first_calls(found):
    """Return the targets of first calls."""
    large, small = found.get("gravity of degree 8, second variations"), found["P2"]
    targets = [Target("P2, kernel from disk", small["from disk, preparation"], 0.1, True, " s")]
    if large:
        what = "Gravity of degree 8 with second variations, processor time of the first call"
        targets.append(Target(what, large["compiled"], 25, True, " s"))
        targets.append(Target(f"{what}, from disk", large["from disk"], 8, True, " s"))
    return targets


def of_first_motion(found):
    """Return the targets of the first motion of a process."""
    now, then = found["now"], found.get("then")
    ratio = now["seconds"] / then["seconds"] if then else None
    return [
        Target(f"first motion of a process, processor time over that at {THEN}", ratio, 0.35, True),
        Target("first motion of a process, peak memory", now["memory"], 130.0, True, " MB"),
    ]


def of_dense_output(found):
    """Return the targets of dense output."""
    return [
        Target(f"{key}, dense output of a million times", one["nanoseconds"], 100, True, " ns")
        for key, one in found.items()
    ]


def of_state_transition(found):
    """Return the targets of variational equations of one motion."""
    return [Target(f"{key}, state transition{FASTER}", times_faster(one), 2.0, False) for key, one in found.items()]


def times_faster(versions):
    """Return how many times longer the older version takes; None where it did not run."""
    return versions["before"]["seconds"] / versions["now"]["seconds"] if "before" in versions else None


def of_chaos(found):
    """Return the targets of maps of chaos."""
    return [
        Target(
            f"MEGNO map, {name}{FASTER}, {one['members']} members over {found['orbits']} revolutions",
            one["before"] and one["before"] / one["seconds"],
            2.0,
            False,
        )
        for name, one in found["maps"].items()
    ]


def of_two_bodies(found):
    """Return the targets of binary asteroids."""
    days, tools, members = found["days"], found["tools"], found["members"]
    motion = f"Didymos, {days} days in a second call"
    return [
        *(
            Target(
                f"{motion}, {name}",
                1e3 * tools[tool]["seconds"] if "seconds" in tools[tool] else None,
                bound,
                True,
                " ms",
            )
            for name, tool, bound in (("second degree", SECOND, 30), ("degree 4", FOURTH, 100))
        ),
        Target(
            f"Didymos, {days} days, members per second on 2 cores", members["members"] / members["seconds"], 150, False
        ),
        Target("Didymos, first call at degree 4 beyond the integration", found["first"][FOURTH], 5, True, " s"),
    ]


def of_cubesat(found):
    """Return the target of a CubeSat under every torque."""
    seconds = found["orbit"].get("seconds")
    what = "CubeSat with every torque, one orbit in a second call"
    return [Target(what, seconds and 1e3 * seconds, 60, True, " ms")]


def of_brightness(found):
    """Return the targets of the brightness of meshes."""
    meshes, curve = found["meshes"], found["light_curve"]
    slowest = {
        kind: max(one[kind] / one[f"script, {kind}"] for one in meshes.values()) for kind in ("value", "gradient")
    }
    rate = found["cells"] / found["laws"]["Hapke"]["gradient"]
    return [
        Target("Brightness of a mesh, time over that of a NumPy script", slowest["value"], 1.0, True),
        Target("Brightness with derivatives, time over that of a NumPy script", slowest["gradient"], 1.0, True),
        Target("Brightness with derivatives by Hapke's law, facets at all epochs per second", rate, 1e7, False),
        Target(
            "Light curve with derivatives, time over that without", curve["derivatives"] / curve["value"], 4.0, True
        ),
    ]


def of_shadows(found):
    """Return the targets of shadows on meshes, per 1000 epochs."""
    scale = 1000 / found["epochs"]
    return [
        Target(
            f"Clear faces by {kind}, {name} of {one['faces']} faces, 1000 epochs", scale * one[key], bound, True, " s"
        )
        for name, one in found["meshes"].items()
        for kind, key, bound in (("centroids", "centroids", 1), ("exact areas", "exact", 10))
    ]


def of_stores(found):
    """Return the targets of ensembles in a store."""
    million, chunks = found["million"], found["chunks"]
    what = f"{million['members']} members by {million['times']} times to a store"
    return [
        Target(f"{what}, resident", million["peak"] / 1e6, 2000, True, " MB"),
        Target(
            "Ensemble in chunks to a store, processor time beyond that in memory", 100 * chunks["over"], 5, True, " %"
        ),
    ]


GROUPS = (
    (against_the_script, "against_the_script"),
    (of_errors, "errors_of_the_script"),
    (of_drifts, "drifts"),
    (of_long_run, "long_run"),
    (against_peers, "work_precision"),
    (of_satellites, "satellites"),
    (of_tops, "tops"),
    (of_a_device, "on_a_device"),
    (of_closed_form, "closed_form", "closed_form_accuracy"),
    (of_shadows, "shadows"),
    (of_second_calls, "second_propagate"),
    (of_first_motion, "first_motion"),
    (of_first_calls, "first_calls"),
    (of_quadruple, "quadruple"),
    (of_dense_output, "dense_output"),
    (of_state_transition, "state_transition"),
    (of_chaos, "chaos_maps"),
    (of_two_bodies, "two_bodies"),
    (of_cubesat, "cubesat"),
    (of_brightness, "brightness"),
    (of_stores, "in_stores"),
)
"""Functions that make the targets of each section."""


def all_of(results):
    """Return every target whose sections were measured."""
    return [
        target
        for group, *sections in GROUPS
        if all(name in results for name in sections)
        for target in group(*(results[name] for name in sections))
    ]
