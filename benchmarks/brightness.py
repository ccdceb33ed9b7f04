"""Brightness of meshes: times next to a script in plain NumPy, and the cost of derivatives."""

import time

import numpy as np

import poinsot as pt
from benchmarks.measure import pin
from poinsot.observables import Hapke, LightCurve, LommelSeeliger
from poinsot.shapes.brightness import brightness_of
from poinsot.taylor.graph import Graph, tangents

SEMIAXES = (3.0, 2.0, 1.5)
ALBEDO = 0.2
CELLS = 2_000_000
"""Number of facets at all epochs of a call."""

ROWS_OF_SCRIPT = (4, 16, 64)
"""Numbers of epochs of a block of the script, of which the fastest counts."""

LAWS = {
    "LommelSeeliger": LommelSeeliger(ALBEDO),
    "Hapke": Hapke(0.33, 1.2, 0.04, -0.3),
    "Hapke, rough": Hapke(0.33, 1.2, 0.04, -0.3, 0.35),
}


def brightness(short):
    """Return processor seconds of sums over facets, of the script and of a light curve."""
    pin(1)
    cells = CELLS // 10 if short else CELLS
    sizes = (320,) if short else (320, 1280, 20480)
    return {
        "cells": cells,
        "meshes": {faces: _on_mesh(faces, cells) for faces in sizes},
        "laws": {name: _of_law(law, cells) for name, law in LAWS.items()},
        "light_curve": _light_curve(200 if short else 2000),
    }


def _on_mesh(faces, cells):
    """Return the seconds of this package and of the script, in turns, and the largest difference of their results."""
    mesh, sun, observer = _case(faces, cells)
    areas, normals = mesh.face_areas, mesh.face_normals
    both = _evaluations(mesh, LAWS["LommelSeeliger"], sun, observer)
    runs = {"value": both[0], "gradient": both[1]}
    for rows in ROWS_OF_SCRIPT:
        script = Script(areas, normals, rows)
        runs |= {f"script, value, {rows}": lambda script=script: script.values(sun, observer, False)}
        runs |= {f"script, gradient, {rows}": lambda script=script: script.values(sun, observer, True)}
    seconds = _fastest(runs)
    found = {name: seconds[name] for name in ("value", "gradient")}
    for kind in ("value", "gradient"):
        found[f"script, {kind}"] = min(seconds[f"script, {kind}, {rows}"] for rows in ROWS_OF_SCRIPT)
    ours, theirs = both[1](), Script(areas, normals, ROWS_OF_SCRIPT[0]).values(sun, observer, True)
    tangential = theirs[1:4] - np.sum(theirs[1:4] * sun, axis=0) * sun  # the directions stay of unit length
    expected = np.stack([theirs[0], *tangential])
    found["difference"] = float(np.max(np.abs(np.stack(ours[:4]) - expected)) / np.abs(expected).max())
    return found


def _of_law(law, cells):
    mesh, sun, observer = _case(1280, cells)
    value, gradient = _evaluations(mesh, law, sun, observer)
    return _fastest({"value": value, "gradient": gradient})


def _light_curve(times):
    """Return the seconds of a light curve of a tumbling body, and of the curve with its derivatives."""
    mesh = pt.shapes.Ellipsoid(SEMIAXES, density=1.0).mesh(1280)
    body = pt.Body.from_shape(mesh)
    sun, observer = (pt.orbits.FixedPosition(1.0, position=x) for x in ((-3.0, 0.4, 0.9), (-1.0, 2.0, 0.1)))
    curve = LightCurve(mesh, LAWS["LommelSeeliger"], sun, observer, kind="relative", light_time=False)
    system = pt.System(body)
    start = body.state((1, 0, 0, 0), omega_body=(0.3, 0.2, 1.0))
    motion = pt.propagate(system, start, np.linspace(0.0, 50.0, times))
    graph = Graph()
    names = [graph.symbol(name) for name in ("sx", "sy", "sz", "ex", "ey", "ez", "albedo", "a", "b", "c")]
    law = LAWS["LommelSeeliger"].with_numbers(names[6:7])
    output = brightness_of(mesh, law, names[:3], names[3:6], names[7:])
    slopes = [tangents([output], {x: 1.0})[0] for x in names]
    directions = [motion.attitude.inv().apply(np.array(x)).T for x in ((3.0, -0.4, -0.9), (1.0, -2.0, -0.1))]
    values = dict(zip(names, [*directions[0], *directions[1], ALBEDO, 1.0, 1.0, 1.0], strict=True))
    return {"times": times} | _fastest({
        "value": lambda: graph.evaluated([output], values),
        "derivatives": lambda: graph.evaluated([output, *slopes], values),
        "observe": lambda: pt.observe(motion, curve),
    })  # fmt: skip


def _case(faces, cells):
    """Return a mesh, and unit vectors (3, epochs) to the Sun and to the observer."""
    mesh = pt.shapes.Ellipsoid(SEMIAXES, density=1.0).mesh(faces)
    directions = np.random.default_rng(1).normal(size=(2, 3, cells // len(mesh.faces)))
    return mesh, *(directions / np.linalg.norm(directions, axis=1, keepdims=True))


def _evaluations(mesh, law, sun, observer):
    """Return functions that compute the brightness, and the brightness with its derivatives by both directions."""
    graph = Graph()
    symbols = [graph.symbol(f"x{k}") for k in range(6)]
    output = brightness_of(mesh, law, symbols[:3], symbols[3:])
    slopes = [tangents([output], {x: 1.0})[0] for x in symbols]
    values = dict(zip(symbols, [*sun, *observer], strict=True))
    return lambda: graph.evaluated([output], values), lambda: graph.evaluated([output, *slopes], values)


class Script:
    """The law of Lommel and Seeliger and its gradient in plain NumPy, in blocks of epochs and without allocations."""

    def __init__(self, areas, normals, rows):
        self.areas, self.columns = areas, np.ascontiguousarray(normals.T)
        self.weighted, self.rows = areas[:, None] * normals, rows
        self.space = np.empty((5, rows, len(areas)))

    def values(self, sun, observer, gradient):
        """Return the brightness and, if asked, its derivatives by the components of both unit vectors."""
        found = np.empty((7 if gradient else 1, sun.shape[1]))
        for start in range(0, sun.shape[1], self.rows):
            part = slice(start, min(start + self.rows, sun.shape[1]))
            mu0, mu, total, light, lit = self.space[:, : part.stop - start]
            np.matmul(sun[:, part].T, self.columns, out=mu0)
            np.matmul(observer[:, part].T, self.columns, out=mu)
            np.maximum(mu0, 0, out=mu0)
            np.maximum(mu, 0, out=mu)
            np.add(mu0, mu, out=total)
            np.maximum(total, 1e-300, out=total)
            np.reciprocal(total, out=total)
            np.multiply(mu0, total, out=lit)
            np.multiply(lit, mu, out=light)
            found[0, part] = light @ self.areas
            if gradient:
                np.multiply(mu, total, out=mu)
                clear = light > 0
                for share, rows in ((mu, slice(1, 4)), (lit, slice(4, 7))):
                    np.multiply(share, share, out=share)
                    np.multiply(share, clear, out=share)
                    found[rows, part] = (share @ self.weighted).T
        return 0.25 * ALBEDO * found


def _fastest(runs):
    """Return the smallest processor time of each function, in turns."""
    best = dict.fromkeys(runs, np.inf)
    for _ in range(7):
        for name, run in runs.items():
            began = time.process_time()
            run()
            best[name] = min(best[name], time.process_time() - began)
    return {name: float(seconds) for name, seconds in best.items()}
