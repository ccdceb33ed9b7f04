"""The report: tables and plots from one run's figures, and nothing else."""

import textwrap

from benchmarks import plots, targets
from benchmarks.targets import (
    BY_HAND,
    OREKIT_ERRORS,
    OREKIT_SECONDS,
    POINSOT,
    at_equal_error,
    rate_of,
    seconds_per_epoch,
)

HEAD = """# Benchmarks

Written by `make bench`: every figure on this page is from one run, on one machine.

{machine}
Single bodies and overheads run on one core, pinned. The tools take turns, round after round, and the median of the
rounds counts; compare times within a table. What compiles once (heyoka's and poinsot's kernels, numba, JAX) is compiled
before the clock runs, and each peer is written as its own user would write it, in `benchmarks/peers/`. The time of
poinsot is that of the whole call of `propagate`; the time of heyoka by hand is that of `propagate_until` with an
integrator that is there already.

The error is the angle between the attitude at the end and that of poinsot in {wide} precision, which integrates in
other variables than the default run; a result with a larger error than {right:.0e} rad
({right_many:.0e} rad in ensembles) is not counted.

{references}"""


def table(headings, rows):
    """Return a Markdown table."""
    lines = [headings, ["---"] * len(headings), *rows]
    return "\n".join(f"| {' | '.join(map(str, line))} |" for line in lines) + "\n"


def prose(*sentences):
    """Return a paragraph, wrapped."""
    return textwrap.fill(" ".join(sentences), 118, break_long_words=False, break_on_hyphens=False) + "\n"


def milliseconds(outcome):
    """Return a time as a cell."""
    return f"{1e3 * outcome['seconds']:.3g} ms" if "seconds" in outcome else outcome["trouble"]


def factor(value):
    """Return a ratio as a cell."""
    return "-" if value is None else f"{value:.2f}" if value < 100 else f"{value:.0f}"


def write(results, folder):
    """Write report and pictures, and return where."""
    pictures = {
        key: plots.work_precision(
            key, results["work_precision"]["problems"][key], results["work_precision"]["titles"], folder / "images"
        )
        for key in ("P2", "P3")
    }
    parts = (
        _head(results),
        _targets(results),
        _one_body(results, pictures),
        _script(results),
        _claim(results),
        _closed_form(results),
        _ensemble(results),
        _rate(results["throughput"]["rate"], results["machine"]["first_cache"]),
        _overheads(results),
        _fields(results["gravity_fields"]),
        _chaos(results["chaos_maps"]),
        _sweeps(results["work_precision"]),
    )
    path = folder / "benchmarks.md"
    path.write_text("\n".join(parts))
    return path


def not_measured(results):
    """Return a sentence for every peer that is missing."""
    measured = results["work_precision"]
    return [f"{measured['titles'][name]} was not measured: {why}." for name, why in measured["missing"].items()]


def _head(results):
    from benchmarks.ensembles import RIGHT
    from benchmarks.measure import Contender
    from benchmarks.problems import WIDE

    machine = results["machine"]
    versions = ", ".join(f"{name} {version}" for name, version in machine["versions"].items())
    facts = [
        f"{machine['processor']}, {machine['cores']} cores; {machine['system']}; {machine['date']}.",
        versions + ".",
    ]
    if results["short"]:
        facts.append("**A short run: few repeats, few settings. For a quick look only.**")
    missing = not_measured(results)
    about = prose(*facts) + ("\n" + prose(*missing) if missing else "")
    references = [
        f"{key}: two formulations in wide precision differ by {p['between_references']:.1e} rad at the end, and by "
        f"{p['away_from_paper_cases']:.1e} rad from the 42-digit numbers of `tests/oracles/paper_cases.json` at "
        f"t = {p['paper_cases_until']:.6g}."
        for key, p in results["work_precision"]["problems"].items()
    ]
    return HEAD.format(machine=about, wide=WIDE, right=Contender.limit, right_many=RIGHT, references=prose(*references))


def _targets(results):
    rows = targets.all_of(results)
    met, unknown = (sum(row.verdict == verdict for row in rows) for verdict in ("met", "not measured"))
    rest = f", {unknown} not measured" if unknown else ""
    return f"## Targets: {met} of {len(rows)} met{rest}\n\n" + table(
        ("what", "target", "reached", ""), [row.row for row in rows]
    )


def _one_body(results, pictures):
    measured, parts = results["work_precision"], ["## One body, work and precision\n"]
    for key, problem in measured["problems"].items():
        parts.append(f"### {key}: {problem['title']}\n")
        if key in pictures:
            parts.append(f"![Error against time of every tool on {key}](images/{pictures[key]}.png)\n")
        parts.append(_most_accurate(problem, measured["titles"]))
    parts.append(
        prose(
            "Each tool at its most accurate setting. The last column is the time over that of poinsot at the smallest",
            "error that both reach, interpolated between the settings of the sweep in logarithms; below 1,",
            "poinsot is slower.",
            "A looser setting than poinsot's loosest counts as that one.",
        )
    )
    return "\n".join(parts)


def _most_accurate(problem, titles):
    best = {name: min(_counted(curve), key=lambda p: p["error"]) for name, curve in problem["curves"].items()}
    rows = []
    for name, point in best.items():
        equal, _ = at_equal_error(problem, name)
        rows.append(
            (
                titles[name],
                _setting(point["level"]),
                milliseconds(point),
                f"{point['error']:.1e}" if "seconds" in point else "-",
                *(_ratio(point, best.get(other, {})) for other in (BY_HAND, POINSOT)),
                factor(equal),
            )
        )
    return table(("tool", "setting", "time", "error [rad]", "/ by hand", "/ poinsot", "/ poinsot, equal error"), rows)


def _counted(curve):
    return [point for point in curve if "seconds" in point] or [{**curve[-1], "error": 0.0}]


def _ratio(one, other):
    return factor(one["seconds"] / other["seconds"]) if "seconds" in one and "seconds" in other else "-"


def _setting(level):
    return "rounding unit" if level == "None" else level


def _script(results):
    rows = []
    for key, names in results["against_the_script"].items():
        for name in (POINSOT, BY_HAND):
            found = names[name]
            rows.append(
                (
                    key,
                    results["work_precision"]["titles"][name],
                    milliseconds(found),
                    f"{found['error']:.1e}",
                    f"{found['largest_error']:.1e}",
                )
            )
    longer = results["long_runs"]
    growth = ", ".join(f"{value:.1e} in {periods}" for periods, value in longer["growth"].items())
    before = prose(
        "heyoka in (q, omega) with the equations typed out and the numbers as literals, both at machine tolerance, on",
        f"{results['against_the_script']['P2']['starts']} starts within about 1e-3 rad of the printed pair:",
        "one error at the end is a draw from rounding, the median over starts is not. Times are medians over",
        f"{results['against_the_script']['P2']['processes']} processes: the time of a compiled kernel differs more",
        "between processes than between repeats. The other ratios on this page are from one process each.",
    )
    after = prose(
        f"The satellite is chaotic: a change of {longer['change']:.0e} rad in the attitude grows by",
        f"the factor {growth}",
        "periods. Over 50 periods the error tells nothing about the tool, and the times alone are: poinsot",
        f"{milliseconds(longer['times'][POINSOT])}, by hand {milliseconds(longer['times'][BY_HAND])}.",
    )
    long = results["drifts"]
    drift = ", ".join(f"{value:.1e} ({name.replace('_', ' ')})" for name, value in long["drift"].items())
    after += "\n" + prose(
        f"The energy of a heavier top (weight 2, I = 0.9, 1.7, 1.3) drifts to t = {long['end']:g} by {drift}:",
        f"relative, root mean squares over {long['starts']} starts. All of them keep it off the unit sphere too.",
    )
    rows = table(("problem", "tool", "time", "median error [rad]", "largest"), rows)
    return "\n".join(("## Beside the script written by hand\n", before, rows, after))


def _claim(results):
    rows = [
        (key, name, outcome.get("steps", "-"), milliseconds(outcome), f"{outcome.get('error', float('nan')):.1e}")
        for key, outcomes in results["formulations"].items()
        for name, outcome in outcomes.items()
    ]
    near = [
        (f"{row['closest']:.0e}", *_cells(row["euler_angles"]), *_cells(row["lie_poisson"]))
        for row in results["singular_angle"]
    ]
    passing = prose(
        "The top of P2 with another start, from t = -5 to 5, which passes the singular angle of the Euler angles at a",
        "distance (its smallest nutation angle, at t = 0):",
    )
    return "\n".join(
        (
            "## What the paper's claim is worth\n",
            "The three formulations side by side, at machine tolerance:\n",
            table(("problem", "formulation", "steps", "time", "error [rad]"), rows),
            passing,
            table(("closest [rad]", "steps, Euler angles", "error [rad]", "steps, default", "error [rad]"), near),
        )
    )


def _cells(run):
    if "stopped" in run:
        return f"stops at t = {run['stopped']:.2g}", "-"
    return run["steps"], f"{run['error']:.1e}"


def _closed_form(results):
    measured = results["closed_form"]
    return "\n".join(
        (
            "## Torque-free motion in closed form\n",
            prose(
                "`free_motion` on the body and start of P1, beside `propagate`, whole calls of both. Orekit's",
                "`TorqueFree` is not run here: its figures are quoted, measured apart, the time inside Java, one call",
                "after another.",
            ),
            _million(measured["million"]),
            _one_time(measured["single"]),
            _many_free(measured["bodies"]),
            _stored(results["closed_form_accuracy"]),
        )
    )


def _million(million):
    titles = {"free_motion": "`free_motion`", "propagate": "`propagate`, dense, then read"}
    rows = []
    for name, title in titles.items():
        epoch = seconds_per_epoch(million, name)
        cells = (f"{1e9 * epoch:.0f} ns", f"{1 / epoch:.2e}", f"{million[name]['error']:.1e}") if epoch else ("-",) * 3
        rows.append((title, milliseconds(million[name]), *cells))
    low, high = OREKIT_SECONDS
    rows.append(
        ("Orekit, quoted", "-", f"{1e9 * low:.0f} to {1e9 * high:.0f} ns", f"{1 / high:.1e} to {1 / low:.1e}", "-")
    )
    before = prose(
        f"{million['epochs']} epochs up to t = {million['until']:g}. The error is the largest of {million['checked']}",
        f"epochs, at which two references in wide precision differ by up to {million['references']:.1e} rad.",
    )
    return "\n".join((before, table(("tool", "time", "an epoch", "epochs/s", "error [rad]"), rows)))


def _one_time(single):
    rows = [
        (
            f"{row['t']:g}",
            *(microseconds(row[name]) for name in ("free_motion", "propagate")),
            _ratio(row["propagate"], row["free_motion"]),
            microseconds(row["read"]),
        )
        for row in single["rows"]
    ]
    equal = single["equal"]
    where = (
        f"up to t = {single['rows'][-1]['t']:g} integration is the faster one"
        if equal is None
        else f"from about t = {equal:.3g} on, a phase omega t of {equal * single['rate']:.3g} rad, integration is "
        "the slower one"
    )
    low, high = (1e6 * seconds for seconds in OREKIT_SECONDS)
    after = prose(
        f"Of one time alone, {where}. The ratio is `propagate` over `free_motion`; the last column is what a closed",
        "form that is there takes to read one more time, `motion(t)`, most of it the cost of Python; a call of Orekit,",
        f"quoted, takes {low:g} to {high:g} us.",
    )
    headings = ("t", "`free_motion`", "`propagate`", "ratio", "one more time")
    return "\n".join(("One time in one call:\n", table(headings, rows), after))


def microseconds(outcome):
    """Return a time as a cell."""
    return f"{1e6 * outcome['seconds']:.3g} us" if "seconds" in outcome else outcome["trouble"]


def _many_free(bodies):
    took = f"take {bodies['seconds']:.2f} s" if "seconds" in bodies else f"have no time ({bodies['trouble']})"
    error = f"{bodies['error']:.1e} rad" if "error" in bodies else "not counted"
    return prose(
        f"{bodies['bodies']} random triaxial bodies at t = {bodies['until']:g}, in one call on one core, {took};",
        f"{bodies['near']} of them are so near the separatrix that the complementary nome is used, the nearest at",
        f"|delta| = {bodies['closest']:.1e}, with delta = (G^2 - 2 T I2)/G^2. The largest error of {bodies['judged']},",
        f"half of them those nearest the separatrix, is {error}; two references in wide precision differ by up to",
        f"{bodies['references']:.1e} rad on these.",
    )


def _stored(stored):
    if "trouble" in stored:
        return prose(f"The stored references were not compared: {stored['trouble']}.")
    rows = [
        (
            f"{row['t']:g}",
            f"{row['free_motion']:.1e}",
            *("-" if error is None else f"{error:.1e}" for error in (OREKIT_ERRORS.get(row["t"]), row["propagate"])),
            f"{row['input_rounding']:.1e}",
        )
        for row in stored["paper"]
    ]
    before = prose(
        "Attitude errors in radians on the paper's case, against the references of `tests/oracles/free_cases.json`,",
        "which have 30 digits. Each is one draw from rounding. The last column is what half a unit in the last place",
        "of every component of Q makes of the attitude: nobody knows their start better than that.",
    )
    headings = ("t", "`free_motion`", "Orekit, quoted", "`propagate`", "rounding of the start")
    return "\n".join((before, table(headings, rows), _groups(stored)))


def _groups(stored):
    groups = (
        ("random", "random cases, error over eps (1 + phase), phase = omega t at the start"),
        ("separatrix", "cases within 1e-3 of the separatrix, error over the rounding of the start"),
    )
    rows = [
        (what, found["cases"], f"{found['median']:.2g}", f"{found['largest']:.2g}", f"{found['error']:.1e}")
        for group, what in groups
        if (found := stored[group])
    ]
    return table(("stored references", "number", "median", "largest", "largest error [rad]"), rows) if rows else ""


def _ensemble(results):
    found = results["throughput"]
    rows = [_tool(found["tools"], name) for name in found["tools"]]
    scalar = 1 / found["tools"]["poinsot, one by one"]["kernel_seconds"]
    worst = [
        (f"{row['spread']:.0e}", *(f"{row[key]:.1e}" for key in ("poinsot", "by_hand", "references")))
        for row in found["worst"]
    ]
    what = prose(
        "P3 over 10 periods; the members are the printed pair with random changes of about",
        f"{found['worst'][0]['spread']:.0e} rad in the attitude. The error is the largest of the first",
        f"{found['sample']} members, each against a scalar run of its own in wide precision. The tolerance is the",
        "rounding unit where none is given.",
    )
    cores = prose(
        f"The scalar kernel of poinsot alone, without the call around it, makes {scalar:.0f}",
        "members/s. Processor seconds",
        "in a second tell how many cores a tool got and used; less than two of two cores is its own waiting or",
        "other work on the machine.",
    )
    every = prose(
        "Every member was compared with the equations written by hand in double precision, and the",
        f"{found['worst'][0]['judged']} members in which the two differ most were judged in wide precision. Members",
        "further from the printed pair can be more chaotic; the last column is how far two",
        "references in wide precision",
        "differ that start from the same doubles, in which |q| = 1 and q.Q = 0 hold to rounding only.",
    )
    headings = ("tool", "members", "members/s", "largest error [rad]", "processor s/s", "poinsot on two cores / it")
    errors = ("spread [rad]", "largest error, poinsot", "by hand", "between references")
    return "\n".join(("## Many bodies\n", what, table(headings, rows), cores, every, table(errors, worst)))


def _tool(tools, name):
    tool, rate = tools[name], rate_of(tools, name)
    if rate is None:
        return name, tool["members"], "-", tool["trouble"], "-", "-"
    best = rate_of(tools, "poinsot, two cores")
    faster = factor(best / rate) if best else "-"
    return name, tool["members"], f"{rate:.0f}", f"{tool['error']:.1e}", f"{tool['busy']:.2f}", faster


def _rate(rate, first_cache):
    if "trouble" in rate:
        return f"## Floating-point rate\n\nNot measured: {rate['trouble']}.\n"
    ceiling = rate["flops"] / (2 * rate["instructions"])
    kernel, whole = rate["kernel"] / rate["peak"], rate["ensemble"] / rate["peak"]
    rates = table(
        ("what", "Gflop/s", "of the peak"),
        [
            ("peak: independent multiply-adds in registers", f"{rate['peak'] / 1e9:.1f}", "1"),
            ("one batch stepping, nothing else", f"{rate['kernel'] / 1e9:.1f}", f"{kernel:.0%}"),
            ("the whole ensemble", f"{rate['ensemble'] / 1e9:.1f}", f"{whole:.0%}"),
        ],
    )
    count = prose(
        f"A step of order {rate['order']} takes {rate['flops']} operations in each of {rate['lanes']} lanes",
        f"({rate['entries']} entries in the decomposition), a member {rate['steps']:.0f} steps on",
        "average. The peak is a",
        "loop of 16 independent chains of multiply-adds on the widest vectors, compiled by LLVM, two operations each.",
        f"The count: {rate['rule']}",
    )
    rest = prose(
        "Where the rest goes. The operations do not all pair up into multiply-adds: they need at least",
        f"{rate['instructions']} instructions, so that {ceiling:.0%} of the peak is the most that this mix allows even",
        f"without a single wait; {rate['divisions']} of them are divisions, which take many times longer than a",
        f"multiply-add. The table of Taylor coefficients has {rate['table_bytes'] / 1024:.0f} KiB and",
        "the first cache of",
        f"this machine {first_cache}: the products of series read their operands mostly from beyond",
        "it if the table is the",
        f"larger one. Stepping reaches {kernel / ceiling:.0%} of that ceiling. Of the lanes",
        f"{rate['busy_lanes']:.1%} are",
        "busy, as the lanes of a batch wait for the slowest; that, reading the members in and out,",
        "and turning the results",
        f"into q and Q leave {whole / kernel:.0%} of the stepping rate.",
    )
    return "\n".join(("## Floating-point rate of the ensemble kernel, one core\n", rates, count, rest))


def _overheads(results):
    second, imports, dense = (results[name] for name in ("second_propagate", "imports", "dense_output"))
    rows = [
        (
            key,
            f"{1e6 * v['seconds']:.0f} us",
            f"{1e6 * v['build']:.0f} us",
            f"{1e3 * v['first']:.1f} ms",
            f"{v['error']:.1e}",
        )
        for key, v in second.items()
    ]
    reading = [(key, f"{v['nanoseconds']:.0f} ns", f"{v['error']:.1e}") for key, v in dense.items()]
    return (
        "## Overheads\n\n`propagate` beyond the integration itself, for new moments of inertia at every call:\n\n"
        + table(("problem", "call", "building Body and System", "first call", "error [rad]"), rows)
        + f"\n`import heyoka` takes {imports['heyoka']:.3f} s, `import poinsot` with what a propagation needs "
        f"{imports['poinsot']:.3f} s, `import poinsot` alone, before a name is used, {imports['names']:.3f} s.\n\n"
        "A dense motion at a million times, for each:\n\n"
        + table(("problem", "a time", "largest error of 100 of them [rad]"), reading)
    )


def _fields(found):
    gradient = next(iter(found.values()))
    rows = [
        (
            name,
            microseconds(one),
            _ratio(one, gradient),
            one["steps"],
            f"{one['first']:.2f} s",
            f"{one['error']:.1e}",
        )
        for name, one in found.items()
    ]
    what = prose(
        "One body on an ellipse, with more and more of its gravity. The first call compiles, with the engine's cache",
        "on the disk turned off; systems of many operations are compiled in the engine's compact mode.",
    )
    headings = ("force", "a step", "/ `GravityGradient`", "steps", "first call", "error [rad]")
    return "\n".join(("## Gravity fields\n", what, table(headings, rows)))


def _chaos(found):
    rows = [
        (
            name,
            one["members"],
            f"{one['seconds']:.1f} s",
            f"{one['busy']:.2f}",
            f"{one['steps']:.0f}",
            microseconds({"seconds": one["seconds"] / one["members"] / one["steps"]}),
            f"{one['chaotic']:.0%}",
            f"{one['error']:.1e}",
        )
        for name, one in found["maps"].items()
    ]
    what = prose(
        f"MEGNO of a moon with (B - A)/C = 0.26 on an orbit of eccentricity 0.1 over {found['orbits']} orbits, on",
        f"{found['cores']} cores at a tolerance of {found['tolerance']:.0e}, over a grid of angles and rates at the",
        "periapsis; in space with the axis of rotation 0.1 rad off the normal of the orbit. Chaotic is a mean MEGNO",
        "above 4. The error is the largest of the mean MEGNO of 64 members after 20 orbits, against samples ten times",
        "as dense.",
    )
    headings = ("map", "members", "time", "processor s/s", "steps of a member", "a step", "chaotic", "error of MEGNO")
    return "\n".join(("## Maps of chaos\n", what, table(headings, rows)))


def _sweeps(measured):
    rows = [
        (
            key,
            measured["titles"][name],
            _setting(point["level"]),
            milliseconds(point),
            f"{point['error']:.1e}" if "seconds" in point else "-",
            point.get("repeats", "-"),
        )
        for key, problem in measured["problems"].items()
        for name, curve in problem["curves"].items()
        for point in curve
    ]
    settings = prose(
        "Settings are tolerances; of MuJoCo the number of steps (a tenth of it on P3), of Basilisk",
        "the tolerance and the",
        "number of steps of its task.",
    )
    headings = ("problem", "tool", "setting", "time", "error [rad]", "repeats")
    return "\n".join(("## The sweeps\n", settings, table(headings, rows)))
