"""What was to be reached, and whether it was."""

import itertools
import math
from dataclasses import dataclass

POINSOT, BY_HAND = "poinsot_taylor", "heyoka_by_hand"
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
        if self.reached <= self.bound if self.most else self.reached >= self.bound:
            return "met"
        factor = self.reached / self.bound if self.most else self.bound / self.reached
        return f"**missed** by a factor {factor:.2f}"

    @property
    def row(self):
        """Return the cells of a table."""
        reached = "-" if self.reached is None else f"{self.reached:.3g}{self.unit}"
        return self.what, f"{'at most' if self.most else 'at least'} {self.bound:g}{self.unit}", reached, self.verdict


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


def against_the_script(results):
    """Return the targets beside the hand-written script."""
    out = []
    for key, bound in (("P2", 1.1), ("P3", 0.75)):
        found = results["against_the_script"][key]
        low, high = found["ratios"]
        between = f"{low:.2f} to {high:.2f} in {found['processes']} processes"
        out.append(Target(f"{key}, time over that of the script ({between})", found["ratio"], bound, True))
        ratio = found[POINSOT]["error"] / found[BY_HAND]["error"]
        out.append(
            Target(f"{key}, error over that of the script, medians of {found['starts']} starts", ratio, 1.0, True)
        )
    long = results["drifts"]
    by_hand, *own = long["drift"].values()
    what = (
        f"top to t = {long['end']:g}, energy drift over that of the script, {long['starts']} starts, larger formulation"
    )
    return [*out, Target(what, max(own) / by_hand, 3.0, True)]


def against_peers(results):
    """Return the targets at equal error."""
    out, measured = [], results["work_precision"]
    for key, peer, bound in AT_EQUAL_ERROR:
        ratio, error = at_equal_error(measured["problems"][key], peer)
        title = measured["titles"][peer]
        at = "" if error is None else f" at an error of {error:.1e}"
        out.append(Target(f"{key}, times faster than {title}{at}", ratio, bound, False))
    return out


def rate_of(tools, name):
    """Return members per second; None where there is no time."""
    tool = tools.get(name, {})
    return tool["members"] / tool["seconds"] if "seconds" in tool else None


def of_ensembles(results):
    """Return the targets of the ensemble."""
    tools = results["throughput"]["tools"]
    one, two = rate_of(tools, "poinsot, one core"), rate_of(tools, "poinsot, two cores")
    kernel, limit = 1 / tools["poinsot, one by one"]["kernel_seconds"], results["throughput"]["limit"]
    rows = (
        ("Ensemble on one core, times the scalar kernel", one, kernel, 6.0),
        ("Ensemble on two cores, times one core", two, one, 1.8),
        (
            "Ensemble, times heyoka's ensemble function, two cores",
            two,
            rate_of(tools, "heyoka's ensemble function by hand, two cores"),
            1.5,
        ),
        (
            f"Ensemble, times numbalsoda, two cores, each at its fastest with errors below {limit:.0e} rad",
            _fastest(tools, "poinsot, two", limit),
            _fastest(tools, "numbalsoda", limit),
            25.0,
        ),
    )
    out = [Target(what, a / b if a and b else None, bound, False) for what, a, b, bound in rows]
    worst = results["throughput"]["worst"][0]["poinsot"]
    return [*out, Target("Ensemble, largest error of a member", worst, limit, True, " rad")]


def _fastest(tools, beginning, limit):
    rates = [
        rate_of(tools, name) for name in tools if name.startswith(beginning) and tools[name].get("error", 1.0) <= limit
    ]
    return max(rates, default=None)


def of_closed_form(results):
    """Return the targets of the torque-free motion in closed form."""
    measured, stored = results["closed_form"], results["closed_form_accuracy"]
    epoch, bodies = seconds_per_epoch(measured["million"], "free_motion"), measured["bodies"]
    errors = {row["t"]: row["free_motion"] for row in stored.get("paper", [])}
    random, separatrix = (stored.get(group) or {} for group in ("random", "separatrix"))
    beside = "below Orekit's, quoted"
    return [
        Target("Closed form, epochs per second of one body", epoch and 1 / epoch, 1e6, False),
        Target(f"Closed form, an epoch of one body ({beside})", epoch and 1e9 * epoch, 1600, True, " ns"),
        Target(f"Closed form, {bodies['bodies']} bodies at one time each", bodies.get("seconds"), 1.0, True, " s"),
        *(
            Target(f"Closed form, error at t = {t:g} ({beside})", errors.get(t), bound, True, " rad")
            for t, bound in OREKIT_ERRORS.items()
        ),
        Target("Closed form, random cases, median error / eps (1 + phase)", random.get("median"), 4, True),
        Target("Closed form, random cases, largest error / eps (1 + phase)", random.get("largest"), 50, True),
        Target("Closed form, near the separatrix, error / input rounding", separatrix.get("largest"), 10, True),
    ]


def seconds_per_epoch(million, name):
    """Return the time of an epoch, of a million of them in one call; None where there is no time."""
    return million[name]["seconds"] / million["epochs"] if "seconds" in million[name] else None


def of_overheads(results):
    """Return the targets of what is not integration."""
    second, imports, dense = (results[name] for name in ("second_propagate", "imports", "dense_output"))
    extra = imports["poinsot"] - imports["heyoka"]
    return [
        *(
            Target(f"{k}, second propagate, new numbers", 1e6 * v["seconds"], 300, True, " us")
            for k, v in second.items()
        ),
        Target("import poinsot over import heyoka", extra, 0.2, True, " s"),
        *(
            Target(f"{k}, dense output of a million times", v["nanoseconds"], 150, True, " ns")
            for k, v in dense.items()
        ),
    ]


def of_chaos(results):
    """Return the targets of maps of chaos."""
    measured = results["chaos_maps"]
    return [
        Target(
            f"MEGNO map, {what}, {found['members']} members over {measured['orbits']} orbits",
            seconds,
            bound,
            True,
            " s",
        )
        for what, bound in (("planar", 30), ("three-dimensional", 90))
        for found in [measured["maps"][what]]
        for seconds in [found["seconds"] * 40_000 / found["members"]]
    ]


def all_of(results):
    """Return every target."""
    return [
        *against_the_script(results),
        *against_peers(results),
        *of_ensembles(results),
        *of_closed_form(results),
        *of_overheads(results),
        *of_chaos(results),
    ]
