"""Every full run's targets in one file that is stored with the source, so that a regression is seen.

`history.csv` has a row for each target of each run of `make bench`: date, commit, processor, target, value, bound and
whether it is the most or the least that the value may be. A target has become worse only if it
has on the same processor.
"""

import csv
import re
import subprocess
from pathlib import Path

from benchmarks import targets

PATH = Path(__file__).with_name("history.csv")
FIELDS = ("date", "commit", "processor", "target", "value", "bound", "limit")
MEASURED = r" \([^()]* processes\)| at an error of .*|, \d+ members over .*|,( medians? of)? \d+ starts"
WORSE = 1.15
"""A value so much worse than the last one is reported: medians of one machine differ by 10 percent from day to day."""


def rows_of(results, commit):
    """Return the rows of one run; targets that were not measured have none."""
    machine = results["machine"]
    start = {"date": machine["date"], "commit": commit, "processor": machine["processor"]}
    return [
        start
        | {"target": stable(target.what), "value": f"{target.reached:.4g}", "bound": f"{target.bound:g}"}
        | {"limit": "most" if target.most else "least"}
        for target in targets.all_of(results)
        if target.reached is not None
    ]


def stable(what):
    """Return the name of a target without what one run has measured."""
    return re.sub(MEASURED, "", what)


def read(path=PATH):
    """Return all rows."""
    with path.open(newline="") as file:
        return list(csv.DictReader(file))


def elsewhere(processor):
    """Return the last rows of each other processor: by its name, a dictionary by target."""
    found = {}
    for row in read():
        if row["processor"] != processor:
            found.setdefault(row["processor"], {})[row["target"]] = row
    return found


def append(results, path=PATH):
    """Append the rows of a run, and return a sentence for each target that has become worse."""
    before = read(path) if path.exists() else []
    rows = rows_of(results, _commit())
    with path.open("a", newline="") as file:
        writer = csv.DictWriter(file, FIELDS, lineterminator="\n")
        if not before:
            writer.writeheader()
        writer.writerows(rows)
    return regressions(before, rows)


def regressions(before, rows):
    """Return a sentence for each target that is worse than in the last run on the same processor."""
    last = {(row["processor"], row["target"]): row for row in before}
    pairs = [(row, last.get((row["processor"], row["target"]))) for row in rows]
    return [
        f"{now['target']}: {now['value']}, but {then['value']} on {then['date']} at {then['commit']}."
        for now, then in pairs
        if then and _worsening(float(now["value"]), float(then["value"]), now["limit"]) > WORSE
    ]


def _worsening(now, then, limit):
    top, bottom = (now, then) if limit == "most" else (then, now)
    return top / bottom if bottom else float(top > 0) * 2 * WORSE


def _commit():
    """Return the commit, and whether the package differs from it: figures of the report do by then."""
    root = PATH.parents[1]
    done = subprocess.run(["git", "describe", "--always"], capture_output=True, text=True, check=False, cwd=root)
    changed = subprocess.run(["git", "diff", "--quiet", "HEAD", "--", "src"], check=False, cwd=root).returncode == 1
    return f"{done.stdout.strip()}-dirty" if changed else done.stdout.strip() or "unknown"
