"""Motions on an ARM processor, which QEMU emulates, are those of this one.

Kernels give the same bits, as no multiplication is contracted with an addition by chance. Parameters are rounded once
from a longer format, which differs between both, and functions of the C library may differ in the last bit.
"""

import json
import platform
import subprocess
import sys

import numpy as np
import pytest
from tools import aarch64

MOTIONS = """
import json, os
import numpy as np
import poinsot as pt
from poinsot.integration import equations

equations.LANES = 2
orbit = pt.KeplerOrbit(398600.4418, semimajor_axis=7000.0, eccentricity=0.1)
body = pt.Body((1.25, 1.0, 0.75))
one = body.state((0, 0.6, 0, 0.8), omega_body=(0.3, 0.1, 2.0))
slow = body.state((0, 0.6, 0, 0.8), omega_body=np.array([[0.0, 1e-3, 2e-3], [1e-3, 0.0, 1e-3], [0.0, 2e-3, 0.0]]))
weight = pt.UniformGravity(weight=0.5, center_of_mass=(1, 0, 0))
runs = {
    "free": (pt.System(body), one, [0.0, 50.0], {}),
    "top": (pt.System(body, weight), one, [0.0, 50.0], {}),
    "quadruple": (pt.System(body, weight), one, [0.0, 5.0], {"precision": "quadruple"}),
    "satellites": (pt.System(body, pt.GravityGradient(orbit)), slow, [0.0, 9000.0], {}),
    "event": (pt.System(body, pt.GravityGradient(orbit)), one, [0.0, 9.0], {"events": [pt.events.SpinFlip((0, 0, 1))]}),
}
found = {}
for name, (system, start, times, options) in runs.items():
    motion = pt.propagate(system, start, times, **options)
    found[name] = np.concatenate([motion.quaternion.ravel(), motion.omega_body.ravel()]).tolist()
print(json.dumps([os.uname().machine, found]))
"""


@pytest.mark.slow
@pytest.mark.skipif(aarch64.emulated() is None, reason="needs QEMU and the folder that `python -m tools.aarch64` makes")
@pytest.mark.skipif(platform.system() != "Linux", reason="QEMU runs programs of Linux")
def test_motions_on_arm_are_those_on_this_processor():
    command, environment = aarch64.emulated()
    here, there = (
        json.loads(subprocess.run([*python, "-c", MOTIONS], env=env, capture_output=True, check=True, text=True).stdout)
        for python, env in (([sys.executable], None), (command, environment))
    )
    assert there[0] == "aarch64"
    for name, numbers in here[1].items():
        bound = 0 if name in ("free", "top", "quadruple") else 1e-13
        np.testing.assert_allclose(there[1][name], numbers, rtol=0, atol=bound * np.max(np.abs(numbers)), err_msg=name)
