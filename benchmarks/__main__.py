"""Measure everything and write the report: `python -m benchmarks [--short] [--only SECTION ...]`."""

import argparse
import contextlib
import datetime as dt
import importlib
import io
import json
import os
import platform
import shutil
import signal
import subprocess
import sys
import tarfile
import tempfile
from pathlib import Path

import poinsot
from benchmarks import overheads, peers, single, variational
from benchmarks.measure import ALLOWED, pin

ROOT = Path(__file__).parents[1]
KEPT = ROOT / "out" / "benchmark-sections"
SECTIONS = {
    "work_precision": "single",
    "against_the_script": "single",
    "errors_of_the_script": "single",
    "drifts": "single",
    "long_run": "single",
    "formulations": "single",
    "singular_angle": "single",
    "closed_form": "free",
    "closed_form_accuracy": "free",
    "second_propagate": "overheads",
    "first_motion": "start",
    "dense_output": "overheads",
    "gravity_fields": "fields",
    "first_calls": "first_calls",
    "quadruple": "precisions",
    "euler_angles": "precisions",
    "satellites": "ensembles",
    "tops": "ensembles",
    "on_a_device": "ensembles",
    "state_transition": "variational",
    "chaos_maps": "variational",
    "two_bodies": "pairs",
    "cubesat": "spacecraft",
    "brightness": "brightness",
    "shadows": "shadows",
    "in_stores": "stores",
    "on_workers": "workers",
}
"""Module of the function of each section. A process loads one module, so that older versions can load it too."""
IN_SEVERAL = {
    "against_the_script": (single.over_processes, 7, ("now",)),
    "second_propagate": (overheads.over_processes, 7, ("now",)),
    "state_transition": (variational.transitions_of_versions, 3, ("before", "now")),
    "chaos_maps": (variational.maps_of_versions, 1, ("before", "now")),
}
"""Function that combines the results of several processes, the number of processes, and the versions."""

ONLY = f"print the figures of these sections and write nothing: {', '.join(SECTIONS)}"
ON_ALL_CORES = (
    "satellites",
    "tops",
    "on_a_device",
    "chaos_maps",
    "two_bodies",
    "in_stores",
    "on_workers",
)  # thread pools count their cores when they are loaded
PACKAGES = (
    *("poinsot", "heyoka", "numpy", "scipy", "numbalsoda", "numba"),
    *("diffrax", "jax", "mujoco", "bsk", "matplotlib"),
)


def main():
    """Run one section, or all of them, each in a process of its own, and write tables and plots."""
    given = _arguments()
    if given.section:
        _section(given)
        return
    try:
        with _older_source() as older:
            results = {name: _stored(name, given, older) for name in given.only or SECTIONS}
    except KeyboardInterrupt:
        sys.exit("stopped; no report was written. The option --resume goes on from the last whole section.")
    if not given.only:
        shutil.rmtree(KEPT, ignore_errors=True)
    _write({"machine": machine(), "short": given.short, **results}, bool(given.only))


def _section(given):
    signal.signal(signal.SIGINT, signal.SIG_DFL)  # the process that started this one says that it was stopped
    pin(len(ALLOWED) if given.section in ON_ALL_CORES else 1)
    more = {"process": given.process} if given.section in IN_SEVERAL else {}
    if given.source and given.source not in Path(poinsot.__file__).parents:
        sys.exit(f"{given.source} must be where poinsot is imported from, got {poinsot.__file__}.")
    measured = getattr(importlib.import_module(f"benchmarks.{SECTIONS[given.section]}"), given.section)
    given.into.write_text(json.dumps(measured(given.short, **more)))


@contextlib.contextmanager
def _older_source():
    """Give the folder of the package as it was at `variational.BEFORE`; None without the repository."""
    archive = subprocess.run(["git", "archive", variational.BEFORE, "src"], capture_output=True, cwd=ROOT, check=False)
    with tempfile.TemporaryDirectory() as folder:
        if archive.returncode:
            yield None
            return
        with tarfile.open(fileobj=io.BytesIO(archive.stdout)) as files:
            files.extractall(folder, filter="data")
        yield Path(folder).resolve() / "src"


def _stored(name, given, older):
    """Measure a section, or take it from a run that did not come to its end; keep it until this one does."""
    stored = KEPT / f"{name}-{'short' if given.short else 'long'}.json"
    if not (given.resume and stored.is_file()):
        found = json.dumps(_measured(name, given.short, older))
        KEPT.mkdir(parents=True, exist_ok=True)
        stored.write_text(found)
    return json.loads(stored.read_text())


def _measured(name, short, older):
    print(f"== {name.replace('_', ' ')}", flush=True)
    if name not in IN_SEVERAL:
        return _in_a_process(name, short)
    merged, processes, versions = IN_SEVERAL[name]
    sources = {version: older if version == "before" else None for version in versions if version == "now" or older}
    found = {version: [] for version in sources}
    for k in range(1 if short else processes):
        for version, source in sources.items():
            found[version].append(_in_a_process(name, short, k, source))
    return merged(found)


def _write(results, partly):
    """Write the report, its figures and the history; what was there before goes only once all is complete.

    Of some sections alone print the report instead, and keep no history.
    """
    from benchmarks import history, report

    out = ROOT / "out"
    if partly:
        print(report.text(results))
        return
    data, folder = (out / "bench-short",) * 2 if results["short"] else (out, ROOT / "docs")
    data.mkdir(parents=True, exist_ok=True)
    (data / "benchmarks.json").write_text(json.dumps(results, indent=1))
    with tempfile.TemporaryDirectory(dir=out) as staged:
        written = report.write(results, Path(staged))
        for path in Path(staged).rglob("*.*"):
            place = folder / path.relative_to(staged)
            place.parent.mkdir(parents=True, exist_ok=True)
            shutil.move(path, place)
    if not results["short"]:
        (ROOT / "benchmarks" / "targets.md").write_text(report.targets_page(results))
        print(*history.append(results), sep="\n")
    missing = report.not_measured(results)
    if missing:
        print(*missing, "`make bench-peers` tries to install what is missing.", sep="\n")
    print((folder / written.name).relative_to(ROOT))


def _arguments():
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument("--short", action="store_true", help="a quick look, written into out/bench-short")
    parser.add_argument("--only", nargs="+", choices=SECTIONS, metavar="SECTION", help=ONLY)
    parser.add_argument("--resume", action="store_true", help="go on where a run stopped")
    parser.add_argument("--section", choices=SECTIONS, help=argparse.SUPPRESS)
    parser.add_argument("--process", type=int, default=0, help=argparse.SUPPRESS)
    parser.add_argument("--into", type=Path, help=argparse.SUPPRESS)
    parser.add_argument("--source", type=Path, help=argparse.SUPPRESS)
    return parser.parse_args()


def _in_a_process(name, short, index=0, source=None):
    """Run a section, with the package from the folder `source` if one is given."""
    with tempfile.TemporaryDirectory() as folder:
        into = Path(folder) / "section.json"
        command = [sys.executable, "-m", "benchmarks", "--section", name, "--process", str(index), "--into", str(into)]
        command += ["--short"] * short + ["--source", str(source)] * bool(source)
        paths = {"PYTHONPATH": str(source)} if source else {}
        done = subprocess.run(command, cwd=ROOT, check=False, env=os.environ | paths)
        if done.returncode:
            sys.exit(f"the section {name} failed; no report was written. Mend it, then go on with the option --resume.")
        return json.loads(into.read_text())


def machine():
    """Return what the figures depend on."""
    cache = Path("/sys/devices/system/cpu/cpu0/cache/index0/size")
    return {
        "processor": _processor(),
        "cores": len(ALLOWED) or os.cpu_count(),
        "first_cache": cache.read_text().strip() if cache.exists() else "unknown",
        "system": f"{platform.system()} {platform.machine()}, Python {platform.python_version()}",
        "date": dt.datetime.now(dt.UTC).strftime("%Y-%m-%d"),
        "versions": peers.versions(PACKAGES),
    }


def _processor():
    info = Path("/proc/cpuinfo")
    if not info.exists():
        return platform.processor()
    lines = info.read_text().splitlines()
    name = next((line.split(":")[1].strip() for line in lines if line.startswith("model name")), platform.machine())
    return name + (", AVX-512" if any("avx512f" in line for line in lines) else "")


main()
