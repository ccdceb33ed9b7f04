"""How fast the page of the 3D view draws a free motion of many stored times, in Chromium without a GPU.

`python benchmarks/page_frames.py` prints, for each number of times: the size of the page, how long it takes to write
and to open, frames per second while it plays at 1280 x 800, and the processor time of a frame in the busiest threads.
"""

from __future__ import annotations

import argparse
import os
import shutil
import tempfile
import time
from collections.abc import Iterator
from pathlib import Path
from typing import Any

import numpy as np
from playwright.sync_api import Page, sync_playwright

import poinsot as pt

FLAGS = ["--no-sandbox", "--use-angle=swiftshader", "--enable-unsafe-swiftshader"]
SECONDS = 4.0
TURN = np.radians(4.0)
"""Rotation angle of the body from one stored time to the next."""
FRAMES = """seconds => new Promise(done => {
    let count = 0;
    const start = performance.now();
    (function frame() {
        const passed = (performance.now() - start) / 1000;
        if (passed > seconds) return done(count / passed);
        count += 1;
        requestAnimationFrame(frame);
    })();
})"""


def page_of(count: int, folder: Path) -> tuple[Path, float]:
    """Return the page of a free motion, and the seconds to write it."""
    body = pt.Body((2.0, 2.5, 3.5))
    start = body.state((0.1, 0.7, -0.5, 0.5), angular_momentum_body=(0.5, -0.7, 1.1))
    motion = pt.free_motion(body, start, TURN / np.linalg.norm(body.omega((0.5, -0.7, 1.1))) * np.arange(count))
    motion.phase  # noqa: B018 - computed before the clock starts
    before = time.perf_counter()
    path = pt.view(motion, folder / f"{count}.html")
    return path, time.perf_counter() - before


def threads(root: int) -> Iterator[tuple[str, int]]:
    """Yield the threads of a process and of its children: name and processor time in clock ticks."""
    for stat in Path("/proc").glob("[0-9]*/task/[0-9]*/stat"):
        try:
            text = stat.read_text()
        except OSError:
            continue
        name, _, rest = text.partition("(")[2].rpartition(")")
        values = rest.split()
        if descends(int(stat.parts[2]), root):
            yield f"{stat.parts[2]}/{stat.parts[4]} {name}", int(values[11]) + int(values[12])


def descends(process: int, root: int) -> bool:
    """Return True if a process is the root process or one of its descendants."""
    while process not in (0, root):
        try:
            process = int(Path(f"/proc/{process}/stat").read_text().rpartition(")")[2].split()[1])
        except OSError:
            return False
    return process == root


def measured(page: Page, root: int) -> tuple[float, list[tuple[float, str]]]:
    """Return frames per second, and the milliseconds of each thread for a frame."""
    before = dict(threads(root))
    rate: float = page.evaluate(FRAMES, SECONDS)
    after = dict(threads(root))
    used = [(10 * (after[key] - before.get(key, 0)) / (rate * SECONDS), key.split(" ", 1)[1]) for key in after]
    return rate, sorted(used, reverse=True)


def main() -> None:
    """Print the table."""
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("counts", nargs="*", type=float, default=[1e4, 1e5, 1e6])
    with sync_playwright() as session, tempfile.TemporaryDirectory() as folder:
        browser: Any = session.chromium.launch(executable_path=shutil.which("chromium"), args=FLAGS)
        for count in map(int, parser.parse_args().counts):
            path, written = page_of(count, Path(folder))
            page = browser.new_page(viewport={"width": 1280, "height": 800})
            before = time.perf_counter()
            page.goto(path.as_uri())
            page.evaluate("new Promise(done => requestAnimationFrame(() => requestAnimationFrame(done)))")
            opened = time.perf_counter() - before
            page.keyboard.press("Space")
            page.wait_for_timeout(3000)  # until it has found how fine the picture can be
            rate, used = measured(page, os.getpid())
            size, part, all_used = (
                path.stat().st_size / 1e6,
                page.evaluate("poinsot.sharpness"),
                sum(ms for ms, _ in used),
            )
            print(f"{count:8d} times: {size:.1f} MB, written in {written:.1f} s, opened in {opened:.1f} s; ", end="")
            print(f"{rate:.0f} frames/s at {part:.2f} of the dots, {all_used:.0f} ms a frame: ", end="")
            print(*(f"{name} {ms:.1f}" for ms, name in used[:3]), sep=", ")
            page.close()
        browser.close()


if __name__ == "__main__":
    main()
