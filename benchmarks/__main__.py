"""Measure everything and write the report: `python -m benchmarks [--short]`."""

import argparse
import datetime as dt
import json
import os
import platform
import shutil
import signal
import subprocess
import sys
import tempfile
from pathlib import Path

from benchmarks import chaos, ensembles, fields, free, overheads, peers, single
from benchmarks.measure import ALLOWED, pin

ROOT = Path(__file__).parents[1]
SECTIONS = {
    "work_precision": single.work_precision,
    "against_the_script": single.against_the_script,
    "long_runs": single.long_runs,
    "drifts": single.drifts,
    "formulations": single.formulations,
    "singular_angle": single.singular_angle,
    "closed_form": free.closed_form,
    "closed_form_accuracy": free.closed_form_accuracy,
    "second_propagate": overheads.second_propagate,
    "imports": overheads.imports,
    "dense_output": overheads.dense_output,
    "gravity_fields": fields.gravity_fields,
    "throughput": ensembles.throughput,
    "chaos_maps": chaos.chaos_maps,
}
IN_SEVERAL = {"against_the_script": single.over_processes}
ON_ALL_CORES = ("throughput", "chaos_maps")  # thread pools count their cores when they are loaded
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
        results = _all_sections(given.short)
    except KeyboardInterrupt:
        sys.exit("stopped; nothing was written.")
    _write(results)


def _section(given):
    signal.signal(signal.SIGINT, signal.SIG_DFL)  # the process that started this one says that it was stopped
    pin(len(ALLOWED) if given.section in ON_ALL_CORES else 1)
    more = {"process": given.process} if given.section in IN_SEVERAL else {}
    given.into.write_text(json.dumps(SECTIONS[given.section](given.short, **more)))


def _all_sections(short):
    results = {"machine": machine(), "short": short}
    for name in SECTIONS:
        print(f"== {name.replace('_', ' ')}", flush=True)
        if name in IN_SEVERAL:
            results[name] = IN_SEVERAL[name]([_in_a_process(name, short, k) for k in range(1 if short else 7)])
        else:
            results[name] = _in_a_process(name, short)
    return results


def _write(results):
    """Write the report, its figures and the history; what was there before goes only once all is complete."""
    from benchmarks import history, report

    out = ROOT / "out"
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
        print(*history.append(results), sep="\n")
    missing = report.not_measured(results)
    if missing:
        print(*missing, "`make bench-peers` tries to install what is missing.", sep="\n")
    print((folder / written.name).relative_to(ROOT))


def _arguments():
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument("--short", action="store_true", help="a quick look, written into out/bench-short")
    parser.add_argument("--section", choices=SECTIONS, help=argparse.SUPPRESS)
    parser.add_argument("--process", type=int, default=0, help=argparse.SUPPRESS)
    parser.add_argument("--into", type=Path, help=argparse.SUPPRESS)
    return parser.parse_args()


def _in_a_process(name, short, index=0):
    with tempfile.TemporaryDirectory() as folder:
        into = Path(folder) / "section.json"
        command = [sys.executable, "-m", "benchmarks", "--section", name, "--process", str(index), "--into", str(into)]
        done = subprocess.run([*command, *["--short"] * short], cwd=ROOT, check=False)
        if done.returncode:
            sys.exit(f"the section {name} failed; nothing was written.")
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
