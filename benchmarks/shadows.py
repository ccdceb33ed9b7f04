"""Times of shadows on meshes of 1000 faces at 1000 epochs, for independent directions to the Sun and the observer."""

import time

import numpy as np

import poinsot as pt
from benchmarks.measure import pin
from poinsot.shapes.surface import Surface
from poinsot.shapes.views import Neighbour
from poinsot.shapes.visibility import clear_faces, clear_parts

EPOCHS = 1000
ROUND, LONG = 20, 25
"""Numbers of faces around the tube of the torus, and along it, of which each has two triangles."""


def shadows(short):
    """Return processor seconds of areas by centroids, exact areas, and their derivatives by both directions."""
    pin(1)
    rng = np.random.default_rng(1)
    directions = rng.normal(size=(2, EPOCHS // 10 if short else EPOCHS, 3))
    s, e = directions / np.linalg.norm(directions, axis=-1, keepdims=True)
    meshes = {"asteroid with hollows": asteroid(), "torus": torus()}
    return {
        "epochs": len(s),
        "meshes": {name: _on_mesh(mesh, s, e) for name, mesh in meshes.items()},
        "pair": _of_pair(meshes["asteroid with hollows"], s, e),
    }


def asteroid():
    """Return an ellipsoid of 1000 faces with two hollows and a hump."""
    ball = pt.shapes.Ellipsoid((1.0, 1.0, 1.0), density=1.0).mesh(1000)
    units = ball.vertices / np.linalg.norm(ball.vertices, axis=1, keepdims=True)
    centers, sizes = np.array([(0.6, 0.0, 0.8), (-0.8, 0.6, 0.0), (0.0, -0.8, 0.6)]), np.array([-0.65, -0.45, 0.5])
    radii = np.exp(np.exp(-6 * (1 - units @ centers.T)) @ sizes)
    return pt.shapes.Mesh(radii[:, None] * units * (1.3, 1.0, 0.8), ball.faces, density=1.0)


def torus():
    """Return a torus of 1000 faces."""
    along, across = np.divmod(np.arange(LONG * ROUND), ROUND)
    t, p = 2 * np.pi * along / LONG, 2 * np.pi * across / ROUND
    far = 1 + 0.4 * np.cos(p)
    here, right = along * ROUND + across, along * ROUND + (across + 1) % ROUND
    ahead, both = ((x + ROUND) % (LONG * ROUND) for x in (here, right))
    faces = np.concatenate([np.stack([here, ahead, both], axis=-1), np.stack([here, both, right], axis=-1)])
    return pt.shapes.Mesh(np.stack([far * np.cos(t), far * np.sin(t), 0.4 * np.sin(p)], axis=-1), faces, density=1.0)


def _on_mesh(mesh, s, e):
    surface, weights = Surface(mesh), np.ones((len(s), len(mesh.faces)))
    parts = clear_parts(surface, [s, e])
    runs = {
        "centroids": lambda: clear_faces(surface, [s, e]),
        "exact": lambda: clear_parts(surface, [s, e]),
        "derivatives": lambda: parts.slopes(weights),
        "illuminated": lambda: clear_parts(surface, [s]),
    }
    return {"faces": len(mesh.faces), **{name: _seconds(run) for name, run in runs.items()}}


def _of_pair(mesh, s, e):
    """Return the seconds of exact areas of one of two bodies in mutual events at all epochs."""
    surface = Surface(mesh)
    neighbour = Neighbour(surface, 3 * s + 0.5 * e, np.broadcast_to(np.eye(3), (len(s), 3, 3)))
    return _seconds(lambda: clear_parts(surface, [s, e], neighbour))


def _seconds(run):
    began = time.process_time()
    run()
    return time.process_time() - began
