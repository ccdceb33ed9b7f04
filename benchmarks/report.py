"""The report: tables and plots from one run's figures, and nothing else."""

import textwrap

from benchmarks import flops, history, peers, plots, targets
from benchmarks.ensembles import BATCHES, ONE_BY_ONE, ONE_CORE, RIGHT
from benchmarks.measure import Contender
from benchmarks.pairs import FOURTH
from benchmarks.problems import WIDE
from benchmarks.single import DRIFTING
from benchmarks.spacecraft import TITLES as OF_FACETS
from benchmarks.start import THEN
from benchmarks.targets import (
    BY_HAND,
    OREKIT_ERRORS,
    OREKIT_SECONDS,
    POINSOT,
    at_equal_error,
    rate_of,
    seconds_per_epoch,
    times_faster,
)
from benchmarks.variational import BEFORE

PICTURES = ("P2", "P3")
ONE_RUN = ("All figures on this page come from one run of `make bench` on one machine.",)
ABOUT = (
    "Runs of single bodies and overheads use one pinned core and measure processor time. The tools alternate, and the",
    "tables give medians; compare times within one table only. Compilation is excluded (kernels of heyoka and poinsot,",
    "numba, JAX). The script of each tool is written as a user of the tool would write it",
    "(`benchmarks/peers/`). The time",
    "of poinsot is the time of the whole call of `propagate`; the time of heyoka by hand is the time of",
    "`propagate_until`",
    "with an existing integrator. The script by hand exists in several versions",
    "(`benchmarks/peers/heyoka_by_hand.py`), and the fastest version on this machine counts.",
)
ERRORS = (
    f"The error is the angle between the final attitude and the final attitude of poinsot in {WIDE} precision, which",
    f"integrates other variables than the default run. A result with an error above {Contender.limit:.0e} rad",
    f"({RIGHT:.0e} rad in ensembles) is excluded.",
)


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
    problems = results["work_precision"]["problems"]
    for key in PICTURES:
        plots.work_precision(key, problems[key], peers.TITLES, folder / "images")
    path = folder / "benchmarks.md"
    path.write_text(text(results))
    return path


def text(results):
    """Return the report, of the sections that were measured."""
    parts = (
        (_one_body, "work_precision"),
        (_script, "against_the_script"),
        (_errors, "errors_of_the_script"),
        (_drifts, "drifts"),
        (_long_run, "long_run"),
        (_formulations, "formulations"),
        (_singular_angle, "singular_angle"),
        (_closed_form, "closed_form"),
        (_stored, "closed_form_accuracy"),
        (_satellites, "satellites"),
        (_tops, "tops"),
        (_on_a_device, "on_a_device"),
        (_second_call, "second_propagate"),
        (_first_motion, "first_motion"),
        (_dense_output, "dense_output"),
        (_fields, "gravity_fields"),
        (_first_calls, "first_calls"),
        (_quadruple, "quadruple"),
        (_euler_angles, "euler_angles"),
        (_state_transition, "state_transition"),
        (_chaos, "chaos_maps"),
        (_two_bodies, "two_bodies"),
        (_shadows, "shadows"),
        (_cubesat, "cubesat"),
        (_brightness, "brightness"),
        (_in_stores, "in_stores"),
        (_on_workers, "on_workers"),
        (_sweeps, "work_precision"),
    )
    written = [part(results[section]) for part, section in parts if section in results]
    return "\n".join(("# Benchmarks\n", *written[:1], _method(results), *written[1:], SEE_ALSO))


SEE_ALSO = (
    "See also: [coming from another tool](coming_from.md), [validation](validation.md), [ensembles](ensembles.md),\n"
    "[free rotation](free_rotation.md).\n"
)


def not_measured(results):
    """Return a sentence for every peer that is missing."""
    missing = results.get("work_precision", {}).get("missing", {})
    return [f"{peers.TITLES[name]} was not measured: {why}." for name, why in missing.items()]


def _method(results):
    machine = results["machine"]
    versions = ", ".join(f"{name} {version}" for name, version in machine["versions"].items())
    facts = [
        f"{machine['processor']}, {machine['cores']} cores; {machine['system']}; {machine['date']}.",
        versions + ".",
    ]
    if results["short"]:
        facts.append("**A short run: few repeats, few settings. For a quick look only.**")
    missing = not_measured(results)
    parts = (ONE_RUN, facts, *([missing] if missing else ()), ABOUT, ERRORS)
    return "\n".join(("## Method\n", *(prose(*part) for part in parts)))


def targets_page(results):
    """Return the page of the targets."""
    rows = targets.all_of(results)
    met, unknown = (sum(row.verdict == verdict for row in rows) for verdict in ("met", "not measured"))
    rest = f", {unknown} not measured" if unknown else ""
    others = history.elsewhere(results["machine"]["processor"])
    dates = {name: max(row["date"] for row in last.values()) for name, last in others.items()}
    return "\n".join(
        (
            f"# Targets of performance: {met} of {len(rows)} met{rest}\n",
            prose(
                "The last columns are the last runs on other processors (`benchmarks/history.csv`). Bold values miss",
                "the",
                "target.",
            ),
            table(
                ("what", "target", "reached", "", *(f"on {name}, {date}" for name, date in dates.items())),
                [
                    (*row.row, *(_elsewhere(row, last.get(history.stable(row.what))) for last in others.values()))
                    for row in rows
                ],
            ),
        )
    )


def _elsewhere(target, last):
    """Return the cell of another processor, in bold where the target is missed."""
    if last is None:
        return "-"
    value = float(last["value"])
    return target.cell(value) if target.allows(value) else f"**{target.cell(value)}**"


def _one_body(measured):
    problems = measured["problems"]
    pictures = [
        f"![Error against time of every tool on {key}](images/benchmark-{key.lower()}.png)\n"
        for key in PICTURES
        if key in problems
    ]
    faster = [f"{factor(at_equal_error(one, BY_HAND)[0])} ({key})" for key, one in problems.items()]
    parts = [
        *pictures,
        prose(
            f"At equal error poinsot is faster than heyoka with equations written by hand by the factors"
            f" {', '.join(faster)}.",
            "The tables list each tool at its most accurate setting.",
        ),
    ]
    for key, problem in problems.items():
        parts += [f"## {key}: {problem['title']}\n", _most_accurate(problem)]
    parts.append(
        prose(
            "The last column is the ratio to the time of poinsot at the smallest error that both tools reach,",
            "interpolated",
            "between the settings of the sweep in logarithms; below 1, poinsot is slower. A setting looser than",
            "poinsot's",
            "loosest setting counts as poinsot's loosest.",
        )
    )
    references = [
        f"{key}: two formulations in wide precision differ by {p['between_references']:.1e} rad at the end, and by "
        f"{p['away_from_paper_cases']:.1e} rad from the 42-digit numbers of `tests/oracles/paper_cases.json` at "
        f"t = {p['paper_cases_until']:.6g}."
        for key, p in measured["problems"].items()
    ]
    return "\n".join((*parts, prose(*references)))


def _most_accurate(problem):
    best = {name: min(_counted(curve), key=lambda p: p["error"]) for name, curve in problem["curves"].items()}
    rows = []
    for name, point in best.items():
        equal, _ = at_equal_error(problem, name)
        rows.append(
            (
                peers.TITLES[name],
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
    return "default" if level == "None" else level


def _script(found):
    rows = [
        (key, _title(name), f"{1e3 * seconds:.3g} ms", factor(seconds / one["seconds"][POINSOT]))
        for key, one in found.items()
        for name, seconds in one["seconds"].items()
    ]
    before = prose(
        "heyoka with the equations typed out and the numbers as literals, by the variables that they are written in,",
        f"both at their default tolerance. Times are medians over {found['P2']['processes']} processes, each with a",
        "start of its own within about 1e-3 rad of the printed pair: the time of a compiled kernel differs more",
        "between processes than between repeats. The other ratios on this page are from one process each.",
    )
    return "\n".join(
        ("## Beside the script written by hand\n", before, table(("problem", "tool", "time", "/ poinsot"), rows))
    )


def _title(name):
    return peers.TITLES.get(name, f"by hand, {name}")


def _errors(found):
    rows = [
        (key, _title(name), f"{one['median']:.1e}", f"{one['largest']:.1e}")
        for key, problem in found["problems"].items()
        for name, one in problem["errors"].items()
    ]
    growth = ", ".join(f"{value:.1e} in {periods}" for periods, value in found["growth"].items())
    before = prose(
        f"Errors on {found['starts']} starts within about 1e-3 rad of the printed pair: one error at the end is a draw",
        "from rounding, and P3 is chaotic. The target is the median over starts of the ratio of the error of poinsot",
        "to the median error of the writings of the script at the same start.",
        *(f"poinsot, {key}: {problem['computed_by']}." for key, problem in found["problems"].items()),
    )
    after = prose(
        f"In P3 a change of {found['change']:.0e} rad in the attitude grows by the factor {growth} periods.",
    )
    return "\n".join((before, table(("problem", "tool", "median error [rad]", "largest"), rows), after))


def _drifts(found):
    rows = [
        (key, name.replace("_", " ") if name in DRIFTING else _title(name), f"{value:.1e}")
        for key, values in found["drift"].items()
        for name, value in values.items()
    ]
    before = prose(
        f"The energy of P2 and of a heavier top (weight 2, I = 0.9, 1.7, 1.3) drifts to t = {found['end']:g},",
        f"relative, root mean squares over {found['starts']} starts. A rotation matrix that takes |q| = 1 for granted",
        "loses energy as |q| drifts; one that is homogeneous in q does not. The target is the larger one of poinsot",
        "over the smallest one of the script.",
    )
    return "\n".join((before, table(("problem", "formulation of poinsot, or script", "drift"), rows)))


def _long_run(found):
    rows = [
        (peers.TITLES[name], milliseconds(tool), _share(found, tool), _share(found, tool, "instructions"))
        for name, tool in found["tools"].items()
    ]
    apart = max(tool.get("error", 0) for tool in found["tools"].values())
    before = prose(
        f"A regular motion: the satellite of P3 that spins five times in a revolution, over {found['revolutions']:g}",
        f"revolutions. The results differ by {apart:.1e} rad at the end. poinsot: {found['computed_by']}.",
    )
    return "\n".join((before, table(("tool", "time", *SHARES), rows), _work(found)))


SHARES = ("of the peak, flops", "of the peak, instructions")


def _share(found, tool, counted="flops", members=1):
    """Return the share of a core's peak that the work of the script makes in the time of a tool on one core."""
    if found["peak"] is None or "seconds" not in tool:
        return "-"
    done = found["work"][f"{counted}_per_time"] * found["work"]["end"] * members / tool["seconds"]
    return f"{done / (found['peak'] / (1 if counted == 'flops' else 2)):.0%}"


def _work(found):
    if found["peak"] is None:
        return prose("The peak was not measured: no llvmlite here, which compiles the loop.")
    work = found["work"]
    return prose(
        f"The peak of a core, {found['peak'] / 1e9:.1f} Gflop/s, is a loop of {flops.ACCUMULATORS} independent chains",
        "of multiply-adds on the widest vectors, two operations each. Every tool is credited with the operations of",
        f"the fastest script at the same tolerance ({work['writing']}): {work['flops']} in a step of order",
        f"{work['order']}, which are at least {work['instructions']} instructions, as not all of them pair up.",
    )


def _formulations(found):
    rows = [
        (key, name, outcome.get("steps", "-"), milliseconds(outcome), f"{outcome.get('error', float('nan')):.1e}")
        for key, outcomes in found.items()
        for name, outcome in outcomes.items()
    ]
    return "\n".join(
        (
            "## What the paper's claim is worth\n",
            "The three formulations side by side, at the default tolerance:\n",
            table(("problem", "formulation", "steps", "time", "error [rad]"), rows),
        )
    )


def _singular_angle(found):
    near = [(f"{row['closest']:.0e}", *_cells(row["euler_angles"]), *_cells(row["lie_poisson"])) for row in found]
    passing = prose(
        "The top of P2 with another start, from t = -5 to 5, which passes the singular angle of the Euler angles at a",
        "distance (its smallest nutation angle, at t = 0):",
    )
    headings = ("closest [rad]", "steps, Euler angles", "error [rad]", "steps, default", "error [rad]")
    return "\n".join((passing, table(headings, near)))


def _cells(run):
    if "stopped" in run:
        return f"stops at t = {run['stopped']:.2g}", "-"
    return run["steps"], f"{run['error']:.1e}"


def _closed_form(measured):
    return "\n".join(
        (
            "## Torque-free motion in closed form\n",
            prose(
                "`free_motion` on the body and start of P1, compared with `propagate`, whole calls of both. Orekit's",
                "`TorqueFree` is not run here: its figures are quoted, measured apart, the time inside Java, one call",
                "after another.",
            ),
            _million(measured["million"]),
            _one_time(measured["single"]),
            _many_free(measured["bodies"]),
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


def _satellites(found):
    worst = [
        (f"{row['spread']:.0e}", *(f"{row[key]:.1e}" for key in ("poinsot", "by_hand", "references")))
        for row in found["worst"]
    ]
    every = prose(
        "Every member was compared with the equations written by hand in double precision, and the",
        f"{found['worst'][0]['judged']} members in which the two differ most were judged in wide precision. Members",
        "further from the printed pair can be more chaotic; the last column is how far two references in wide",
        "precision differ that start from the same doubles, in which |q| = 1 and q.Q = 0 hold to rounding only.",
    )
    errors = ("spread [rad]", "largest error, poinsot", "by hand", "between references")
    what = "P4: the satellite of P3 over 10 periods;"
    return "\n".join(("## Many bodies\n", _ensemble(found, what), every, table(errors, worst)))


def _tops(found):
    return _ensemble(found, "P5: the top of P2 to t = 100;")


def _ensemble(found, what):
    rows = [_tool(found, name) for name in found["tools"]]
    before = prose(
        f"{what} the members are the printed pair with random changes of about {found['spread']:.0e} rad in the",
        f"attitude. The error is the largest of the first {found['sample']} members, each against a run of its own in",
        f"wide precision. The tolerance is {found['tolerance']:.3g} where none is given. On one core the time is that",
        "of the processor. Processor seconds in a second tell how many cores a tool got and used.",
        f"The batches are in {found['writing']}. poinsot: {found['computed_by']}.",
    )
    headings = ("tool", "members", "members/s", "largest error [rad]", "processor s/s", "/ batches by hand", *SHARES)
    return "\n".join((before, table(headings, rows), _work(found)))


def _tool(found, name):
    tool, by_hand = found["tools"][name], rate_of(found["tools"], BATCHES)
    rate = rate_of(found["tools"], name)
    if rate is None:
        return name, tool["members"], "-", tool["trouble"], *["-"] * 4
    shares = (
        [_share(found, tool, counted, tool["members"]) for counted in ("flops", "instructions")]
        if name in (ONE_CORE, BATCHES, ONE_BY_ONE)
        else ["-"] * 2
    )
    faster = factor(rate / by_hand) if by_hand else "-"
    return name, tool["members"], f"{rate:.0f}", f"{tool['error']:.1e}", f"{tool['busy']:.2f}", faster, *shares


def _on_a_device(found):
    if "trouble" in found:
        return prose(f"P4 on a GPU was not measured: {found['trouble']}.")
    rows = [
        (name, tool["members"], f"{rate:.0f}", f"{tool['error']:.1e}")
        for name, tool in found["tools"].items()
        if (rate := rate_of(found["tools"], name))
    ]
    what = prose(f"P4 on {found['device']}, next to {found['cores']} cores of that machine.")
    return "\n".join((what, table(("tool", "members", "members/s", "largest error [rad]"), rows)))


def _second_call(found):
    rows = [
        (
            key,
            f"{1e6 * v['seconds']:.0f} us",
            f"{1e6 * v['build']:.0f} us",
            f"{1e3 * v['first']:.1f} ms",
            f"{v['error']:.1e}",
        )
        for key, v in found.items()
    ]
    return (
        "## Overheads\n\n`propagate` beyond the integration itself, for new moments of inertia at every call, medians "
        "of 7 processes:\n\n"
        + table(("problem", "call", "building Body and System", "first call", "error [rad]"), rows)
    )


def _first_motion(found):
    then, now = found.get("then"), found["now"]
    earlier = f", {then['seconds']:.3f} s and {then['memory']:.0f} MB at commit {THEN}" if then else ""
    return prose(
        "A process that imports poinsot and has the first motion of P2, with the kernel on the disk, needs",
        f"{now['seconds']:.3f} s of processor time beyond `import numpy`, and {now['memory']:.0f} MB of memory at",
        f"most{earlier}. `import poinsot` alone, before a name is used, takes {found['names']['seconds']:.3f} s.",
    )


def _dense_output(found):
    rows = [(key, f"{v['nanoseconds']:.0f} ns", f"{v['error']:.1e}") for key, v in found.items()]
    headings = ("problem", "a time", "largest error of 100 of them [rad]")
    return "A dense motion at a million times, for each:\n\n" + table(headings, rows)


def _in_stores(found):
    million, chunks, saving = found["million"], found["chunks"], found["saving"]
    rows = [("integrating it", saving["propagate"]), ("its dataset", saving["dataset"])]
    rows += [(f"saving it as `{suffix}`, dataset included", saving[suffix]) for suffix in (".nc", ".zarr")]
    return "\n".join(
        (
            "## Ensembles in a store\n",
            prose(
                f"{million['members']} free rotations at {million['times']} times, {million['stored'] / 1e9:.2f} GB,",
                f"in chunks of {million['chunk']} members: {million['seconds']:.0f} s, of which the processor works",
                f"{million['used']:.0f} s; at most {million['peak'] / 1e6:.0f} MB resident. A member in the middle is",
                f"{million['error']:.1e} from the closed form.",
            ),
            prose(
                f"{chunks['members']} satellites of P3 at {chunks['times']} times on one core take",
                f"{chunks['memory']:.2f} s in memory and {chunks['store']:.2f} s in chunks of {chunks['chunk']} to a",
                f"store, written and synchronised: {100 * chunks['over']:.1f} % more (median of pairs). The members",
                ("are the same, bit for bit." if chunks["same"] else "**differ**."),
            ),
            f"A heavy top at {saving['times']} times, processor times:\n",
            table(("what", "seconds"), [(what, f"{seconds:.2f}") for what, seconds in rows]),
        )
    )


def _on_workers(found):
    same = "The members are the same, bit for bit." if found["same"] else "The members **differ**."
    return "\n".join(
        (
            "## Workers of dask and threads\n",
            prose(
                f"{found['members']} satellites of P3 at {found['times']} times to a store, in chunks of",
                f"{found['chunk']}, each way in turn,",
                f"without the start of workers and without compilation, medians. {same}",
            ),
            table(("on", "members per second"), [(way, f"{rate:.0f}") for way, rate in found["rate"].items()]),
        )
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
        "One body on an ellipse, with more and more of its gravity. The first call compiles, with the caches",
        "on disk turned off; systems of many operations are compiled in the engine's compact mode.",
    )
    headings = ("force", "a step", "/ `GravityGradient`", "steps", "first call", "error [rad]")
    return "\n".join(("## Gravity fields\n", what, table(headings, rows)))


def _first_calls(found):
    rows = [
        (
            name,
            one["operations"],
            *(f"{one[way]:.2f} s" for way in ("compiled", "compiled, preparation")),
            *(f"{one[way]:.2f} s" for way in ("from disk", "from disk, preparation")),
        )
        for name, one in found.items()
    ]
    what = prose(
        "Processor time of the first call of a process, with an empty cache of machine code and with the code on disk.",
        "The preparation of a kernel is its tracing, lowering and writing, and its compilation or its loading.",
    )
    headings = ("system", "operations", "compiled", "its preparation", "from disk", "its preparation")
    return "\n".join(("## First calls\n", what, table(headings, rows)))


def _quadruple(found):
    rows = [
        (
            name,
            milliseconds(one["poinsot"]),
            milliseconds(one["heyoka"]),
            f"{one['ratio']:.1f}",
            *(f"{one[of]:.1e}" for of in ("attitude", "momentum")),
        )
        for name, one in found.items()
    ]
    what = prose(
        "Motions in quadruple precision, without the first call: double-double arithmetic of poinsot next to",
        "the type real128 of heyoka with the equations typed out, each at its default tolerance. The last columns are",
        "the largest difference of a component of the quaternion, and of the angular momentum over its size.",
    )
    headings = ("problem", "poinsot", "heyoka by hand", "heyoka over poinsot", "attitude", "momentum")
    return "\n".join(("## Quadruple precision\n", what, table(headings, rows)))


def _euler_angles(found):
    rows = [(key, *(milliseconds(one[name]) for name in ("lie_poisson", "euler_angles"))) for key, one in found.items()]
    what = prose("A tenth of each problem in Euler angles and in the default variables, alternating, 101 output times.")
    return "\n".join(("## Euler angles\n", what, table(("problem", "default", "Euler angles"), rows)))


def _state_transition(found):
    rows = [
        (
            key,
            *(milliseconds(one[who]) if who in one else "-" for who in ("now", "before", "by_hand")),
            factor(times_faster(one)),
        )
        for key, one in found.items()
    ]
    what = prose(
        "The state-transition matrix and the motion, whole calls: P2 to t = 100 and P3 over 10 periods. Before is",
        f"this package at commit {BEFORE}, in the same run; by hand is heyoka's `var_ode_sys` on the equations of the",
        "script in compact mode, which solves 7 x 7 equations.",
    )
    headings = ("problem", "time", "before", "heyoka by hand", "times faster than before")
    return "\n".join(("## Variational equations\n", what, table(headings, rows)))


def _shadows(found):
    kinds = ("centroids", "exact", "derivatives", "illuminated")
    rows = [(name, one["faces"], *(f"{one[kind]:.3g} s" for kind in kinds)) for name, one in found["meshes"].items()]
    what = prose(
        f"Parts of faces that the Sun illuminates and the observer sees, for {found['epochs']} pairs of directions,",
        "on one core: by the centroids of the faces, by exact areas, and the derivatives of a sum of the areas by all",
        "directions; exact illuminated areas alone. The exact areas of one of two bodies, each with the faces of the",
        f"first line and always before or behind the other, take {found['pair']:.3g} s.",
    )
    headings = ("mesh", "faces", "centroids", "exact", "derivatives", "illuminated")
    return "\n".join(("## Shadows of meshes\n", what, table(headings, rows)))


def _chaos(found):
    rows = [
        (
            name,
            one["members"],
            f"{one['seconds']:.1f} s",
            f"{one['before']:.1f} s" if one["before"] else "-",
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
        f"as dense. Before is the time of this package at commit {BEFORE}, in the same run.",
        *(f"poinsot, {name}: {one['computed_by']}." for name, one in found["maps"].items()),
    )
    headings = ("map", "members", "time", "before", "processor s/s", "steps of a member", "a step", "chaotic")
    return "\n".join(("### Maps of chaos\n", what, table((*headings, "error of MEGNO"), rows)))


def _two_bodies(found):
    first, energy = found["first"], found["energy"]
    rows = [
        (
            name,
            milliseconds(one),
            f"{one['error']:.1e}" if name != FOURTH and "error" in one else "-",
            f"{energy[name]:.1e}" if name in energy else "-",
            f"{first[name]:.1f} s" if name in first else "-",
        )
        for name, one in found["tools"].items()
    ]
    rows += [
        (f"GUBAS, {name}, as measured there", seconds, error, "-", "-")
        for name, seconds, error in (
            ("second degree, RK7(8), tolerance 1e-15", "42.2 s", "6.2e-09"),
            ("second degree, LGVI, steps of 30 s (its default)", "11.7 s", "2.5e-03"),
            ("degree 4, RK7(8), 10 days", "309 s", "-"),
        )
    ]
    groups = "; ".join(
        f"{what} of {one['members']} members at {one['members'] / one['seconds']:.0f} a second (processor seconds in a "
        f"second: {one['busy']:.2f})"
        for what, one in (("an ensemble", found["members"]), ("a map of chaos", found["map"]))
    )
    what = prose(
        f"Didymos and Dimorphos over {found['days']} days after the impact of DART (docs/dart.md), whole calls with a",
        "kernel that is there already, on one core. Errors are those of the position at the end, relative, against",
        f"{WIDE} precision; the first call is without the integration. GUBAS (github.com/meyeralexj/gubas), the",
        "program of the DART team, was measured apart from this benchmark, in processor seconds of one core, compiled",
        "with -O3.",
        f"On {found['members']['cores']} cores, second degree: {groups}.",
        f"poinsot: {found['computed_by']}.",
    )
    headings = ("tool", "time", "error of the position", "drift of the energy", "first call")
    return "\n".join(("## Two bodies\n", what, table(headings, rows)))


def _cubesat(found):
    orbit, facets = found["orbit"], found["facets"]
    what = prose(
        "The CubeSat of examples/cubesat.py over one orbit: gravity gradient, drag, radiation pressure with the",
        "Earth's shadow, a magnetic moment in the IGRF to degree 8, and four wheels that hold it to the axes of the",
        f"orbit. The time is that of the whole call with {found['outputs']} output times and a kernel that is there",
        f"already, on one core; the error is against {WIDE} precision, in other variables. {_of_orbit(orbit)}",
    )
    comparison = prose(
        "Eight facets that turn past their edges, over hours, compared with Basilisk and its modules of facets, which",
        "takes the orbit along; RKF78 has a tolerance of 1e-13 and stops at each step, RK4 is Basilisk's default. The",
        "error is the attitude's at the end, against the reference of tests/oracles/surfaces.json, a Taylor series",
        "whose error is estimated as 2e-13 and which another method confirms to 3e-11. poinsot stops at each edge;",
        "Basilisk's steps cross them, so that its error falls with the step, and not evenly.",
        *(f"Basilisk was not measured: {why}." for why in facets["missing"].values()),
    )
    tools = facets["tools"]
    rows = [
        (tool, *(cell for name in OF_FACETS for cell in _time_and_error(tools[name][tool])))
        for tool in next(iter(tools.values()))
    ]
    headings = ("tool", *(cell for title in OF_FACETS.values() for cell in (f"{title}, time", "error, rad")))
    return "\n".join(("## Spacecraft\n", what, "### Facets past their edges\n", comparison, table(headings, rows)))


def _brightness(found):
    cells, curve = found["cells"], found["light_curve"]
    what = prose(
        f"The law of Lommel and Seeliger on meshes of an ellipsoid in directions by chance, {cells:.0e} facets at all",
        "epochs in a call, on one core. The derivatives are by the directions to the Sun and to the observer. The",
        "script is plain NumPy in blocks of epochs without allocations, at its fastest length of a block. The largest",
        f"difference is {max(one['difference'] for one in found['meshes'].values()):.0e} of the largest value. A light",
        f"curve of {curve['times']} epochs and 1280 faces takes {1e3 * curve['value']:.1f} ms, and",
        f"{1e3 * curve['derivatives']:.1f} ms with the derivatives by directions, albedo and stretch.",
    )
    kinds = ("value", "script, value", "gradient", "script, gradient")
    rows = [
        (f"{faces} faces", *(f"{cells / one[kind]:.2g}" for kind in kinds)) for faces, one in found["meshes"].items()
    ]
    headings = ("facets at all epochs per second", *("value", "script", "with derivatives", "script"))
    laws = [
        (f"`{name}`", *(f"{cells / one[kind]:.2g}" for kind in ("value", "gradient")))
        for name, one in found["laws"].items()
    ]
    of_laws = table(("law, 1280 faces", "value", "with derivatives"), laws)
    return "\n".join(("## Brightness\n", what, table(headings, rows), of_laws))


def _time_and_error(outcome):
    return milliseconds(outcome), f"{outcome['error']:.1e}" if "error" in outcome else "-"


def _of_orbit(orbit):
    """Say what an orbit took, or why it was not measured."""
    if "seconds" not in orbit:
        return f"It was not measured: {orbit['trouble']}"
    return (
        f"It took {milliseconds(orbit)} ({orbit['steps']} steps) with an error of {orbit['error']:.1e} rad; the first"
        f" call took {orbit['first']:.1f} s more. poinsot: {orbit['computed_by']}."
    )


def _sweeps(measured):
    rows = [
        (
            key,
            peers.TITLES[name],
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
