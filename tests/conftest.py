"""Fixtures shared by all tests."""

import gc
import os
import signal

import numpy as np
import pytest

import poinsot as pt
from poinsot.integration import equations
from poinsot.systems.collection import results_of

pytest_plugins = ["default_share", "stored_code", "margins"]

# Workers inherit it: matrices here are small, and BLAS threads with a worker on each core only wait for each other.
os.environ.setdefault("OMP_NUM_THREADS", "1")

gc.set_threshold(200_000, 20, 20)  # the graphs of a kernel are many objects and no cycles

signal.signal(signal.SIGINT, signal.default_int_handler)  # a shell's background jobs ignore it, and tests send it


@pytest.fixture
def rng():
    return np.random.default_rng(20061027)


@pytest.fixture
def forget_kernels(monkeypatch):
    """Makes a function that forgets all equations, and what is known of structures."""

    def forget():
        monkeypatch.setattr(equations, "known", equations.Cache())
        results_of.cache_clear()

    return forget


@pytest.fixture(scope="session")
def body():
    return pt.Body((1.25, 1.0, 0.75))


@pytest.fixture(scope="session")
def top(body):
    return pt.System(body, pt.UniformGravity(0.5, (1.0, 0.2, -0.3)))


@pytest.fixture(scope="session")
def start(body):
    return body.state((0.1, 0.7, -0.5, 0.5), omega_body=(0.4, -0.3, 0.6))


@pytest.fixture(scope="session")
def orbit():
    return pt.KeplerOrbit(
        2.0,
        semimajor_axis=1.5,
        eccentricity=0.3,
        inclination=0.4,
        node=1.1,
        argument_of_periapsis=-0.7,
        true_anomaly=2.0,
        epoch=0.25,
    )


@pytest.fixture(scope="session")
def satellite(orbit):
    return pt.System(pt.Body((1.0, 1.3, 1.6)), pt.GravityGradient(orbit))


@pytest.fixture
def reads(tmp_path):
    """Makes a function that reads a text out of a file of the name that a reader expects."""

    def reader_of(function, name):
        def read(text, *arguments, **options):
            path = tmp_path / name
            path.write_bytes(text if isinstance(text, bytes) else text.encode())
            return function(path, *arguments, **options)

        return read

    return reader_of


@pytest.fixture(autouse=True, scope="module")
def _frozen():
    """Keep what earlier modules have left out of later collections: a whole one would take a second of a timed test."""
    gc.collect()
    gc.freeze()
