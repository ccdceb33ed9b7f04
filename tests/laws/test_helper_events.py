"""Each event of the package means what its name says: its passages are those of the quantity itself, none more or less.

The quantity is computed by numpy from dense samples of attitude and rates, without a formula of the package.
"""

import numpy as np
import pytest

import poinsot as pt
from kinds.events import BODY, EVENTS
from poinsot.events import standard_events as crossings

SPAN = 25.3


def test_every_event_of_the_package_is_here():
    assert {name.partition(",")[0] for name in EVENTS} == set(crossings.__all__)


def starts(count):
    rng = np.random.default_rng(4)
    q = rng.normal(size=(count, 4))
    return BODY.state(q / np.linalg.norm(q, axis=1)[:, None], omega_body=rng.normal(size=(count, 3)))


@pytest.mark.parametrize("sign", [1, -1], ids=["forwards", "backwards"])
@pytest.mark.parametrize("weight", [0.0, 0.8], ids=["free", "heavy"])
@pytest.mark.parametrize("name", EVENTS)
def test_passages_are_those_of_the_quantity(name, weight, sign):
    event, quantity = EVENTS[name]
    system = pt.System(BODY, pt.UniformGravity(weight, (0.1, 0.2, 0.9)))
    times = sign * np.linspace(0, SPAN, 20_001)
    together = pt.propagate(system, starts(3), times, events=[event])
    for k in range(3):
        matrices = pt.State(together.quaternion[k], together.conjugate_momenta[k], times).attitude.as_matrix()
        values = quantity(matrices, together.omega_body[k], times)
        crossed = (np.sign(values[1:]) != np.sign(values[:-1])) & (np.abs(values[1:] - values[:-1]) < 1)
        found = together.events[0].member(k)
        assert len(found) == np.sum(crossed)
        late = np.searchsorted(sign * times, sign * found.times)
        assert np.all(crossed[late - 1])
        assert np.array_equal(found.directions, sign * np.sign(values[1:] - values[:-1])[crossed])
        start = starts(3)
        one = pt.State(start.quaternion[k], start.conjugate_momenta[k], 0.0)
        alone = pt.propagate(system, one, [sign * SPAN], events=[event]).events[0]
        assert np.allclose(
            np.sort(sign * alone.times), np.sort(sign * found.times), rtol=0, atol=1e-10
        )  # rounding over the slowest passage
