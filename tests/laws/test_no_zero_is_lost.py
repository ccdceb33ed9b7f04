"""Every sign change of an event and of a condition is found, wherever it lies and however close the next one is.

The zeros of a product of (time - a) are the numbers a themselves: round ones lie on the points at which a step is
halved, close ones drown in the rounding of a Taylor polynomial.
"""

import numpy as np
import pytest

import poinsot as pt
from poinsot import functions as fn

BODY = pt.Body((1.0, 1.2, 1.5))
EPS = np.finfo(float).eps


class Product(pt.Event):
    a: float
    b: float
    c: float

    def value(self, instant):
        return (instant.time - self.a) * (instant.time - self.b) * (instant.time - self.c)


class Kick(Product):
    def act(self, body, state):
        changed = state.angular_momentum_body + np.array([0, 0, 1.5e-3])
        return body.state(state.quaternion, angular_momentum_body=changed, time=state.time)


class Window(pt.Torque):
    """A torque about the third axis between two times, written as one product; `size` is what it adds to the rate."""

    a: float
    b: float
    size: float

    def torque(self, instant):
        inside = fn.less((instant.time - self.a) * (instant.time - self.b), 0.0)
        return fn.Vector((0.0, 0.0, 1.5)) * (fn.where(inside, self.size, 0.0))


def triples(rng, count, span):
    """A third random, a third round, a third with two zeros 1e-6 to 1e-3 apart; none at the ends."""
    random = rng.uniform(0.001, 0.999, (count, 3))
    whole = np.array([rng.choice(np.arange(1, 40), 3, replace=False) for _ in range(count)]) / 40
    close = rng.uniform(0.001, 0.999, (count, 3))
    close[:, 1] = close[:, 0] * (1 + 10 ** rng.uniform(-6, -3, count))
    close[:, 2] = np.where(rng.random(count) < 0.5, 2.0, close[:, 2])  # outside: a pair
    kind = rng.integers(3, size=count)
    return span * np.choose(kind[:, None], [random, whole, close])


def check(motion, zeros, span, sign, pace):
    found, lost = motion.events[0], 0
    for k, row in enumerate(zeros):
        expected = np.sort(row[row <= span])
        times = np.sort(sign * (found.member(k).times if len(zeros) > 1 else found.times))
        lost += times.size != expected.size or np.max(np.abs(times - expected)) > 32 * EPS * max(span, pace)
    return lost


def lost_events(rng, count, span, sign, kind, rate):
    zeros = triples(rng, count, span)
    start = BODY.state((1, 0, 0, 0), omega_body=(0, 0, rate))
    motion = pt.propagate(pt.System(BODY), start, [sign * span], events=[kind(*(sign * zeros.T))])
    lost = check(motion, zeros, span, sign, 2 / rate if rate else 0.0)
    if kind is Kick:
        inside = np.sum(zeros <= span, axis=1)
        lost += int(np.sum(np.abs(motion.omega_body[:, 0, 2] - rate - sign * 1e-3 * inside) > 1e-12))
    return lost


def lost_windows(rng, count, span, sign, rate):
    a, b, _ = triples(rng, count, span).T
    b = np.where(a == b, b + 0.1 * span, b)
    start = BODY.state((1, 0, 0, 0), omega_body=(0, 0, rate))
    windows = Window(sign * a, sign * b, 1e-3 / np.abs(b - a))
    motion = pt.propagate(pt.System(BODY, windows), start, [sign * span])
    width = np.abs(b - a) / span
    inside = np.abs(np.clip(b, 0, span) - np.clip(a, 0, span)) / span / width
    # A step is 0.0437 of the span at most: the zero of its polynomial is off by rounding over slope, 0.002 EPS / width.
    slack = 1e-12 + 1e-3 * (0.03 * EPS / width**2 + 16 * EPS / width)
    return int(np.sum(~(np.abs(motion.omega_body[:, 0, 2] - rate - sign * 1e-3 * inside) < slack)))


@pytest.mark.parametrize("sign", [1, -1], ids=["forwards", "backwards"])
@pytest.mark.parametrize(("span", "rate"), [(10.0, 1e-3), (3600.0, 0.0), (40.0, 0.7)])
def test_zeros_of_products_of_times(span, rate, sign):
    rng = np.random.default_rng(1)
    assert lost_events(rng, 300, span, sign, Product, rate) == 0
    assert lost_windows(rng, 100, span, sign, rate) == 0


def test_a_switch_behind_which_steps_are_much_shorter():
    a, b = 0.015639073403142866, 0.015651426406430982
    start = BODY.state((1, 0, 0, 0), omega_body=(0, 0, 1e-3))
    motion = pt.propagate(pt.System(BODY, Window(a, b, 1e-3 / (b - a))), start, [10.0])
    assert abs(motion.omega_body[0, 2] - 2e-3) < 1e-12 + 1e-3 * 3 * EPS / (b - a) ** 2  # as below


def test_actions_at_zeros_of_products_of_times():
    assert lost_events(np.random.default_rng(2), 40, 10.0, 1, Kick, 1e-3) == 0


@pytest.mark.parametrize("sign", [1, -1], ids=["forwards", "backwards"])
def test_a_zero_at_the_start_hides_none_in_the_first_step(sign):
    zeros = np.array([(0.0, b, 1e3) for b in (3e-4, 0.003, 0.05, 0.3)])
    start = BODY.state((1, 0, 0, 0), omega_body=(0, 0, 1.0))
    motion = pt.propagate(pt.System(BODY), start, [30.0 * sign], events=[Product(*(sign * zeros.T))])
    assert check(motion, zeros[:, 1:], 30.0, sign, 1.0) == 0


def test_quadruple_precision_and_dense_output_find_round_and_close_pairs():
    start = BODY.state((1, 0, 0, 0), omega_body=(0, 0, 1e-3))
    for a, b in ((5.0, 6.0), (1.0, 1.25), (5.1, 5.1 + 1e-5)):
        for ways in ({"precision": "quadruple"}, {"dense": True}):
            found = pt.propagate(pt.System(BODY), start, [10.0], events=[Product(a, b, 20.0)], **ways).events[0]
            assert np.allclose(found.times, [a, b], rtol=0, atol=32 * EPS * 2e3)  # in 2e3 the body turns once
            burn = pt.propagate(pt.System(BODY, Window(a, b, 1e-3 / (b - a))), start, [10.0], **ways)
            assert (
                abs(burn.omega_body[0, 2] - 2e-3) < 1e-12 + 1e-3 * 3 * EPS / (b - a) ** 2
            )  # as above, in a span of 10


@pytest.mark.slow
@pytest.mark.parametrize("seed", range(17))
def test_none_of_a_hundred_thousand_is_lost(seed):
    rng = np.random.default_rng(100 + seed)
    for span, rate in ((10.0, 1e-3), (3600.0, 0.0), (40.0, 0.7)):
        for sign in (1, -1):
            assert lost_events(rng, 800, span, sign, Product, rate) == 0
            assert lost_windows(rng, 200, span, sign, rate) == 0


@pytest.mark.parametrize("seed", range(4))
@pytest.mark.parametrize("sign", [1, -1], ids=["forwards", "backwards"])
def test_andoyers_angle_is_passed_where_the_variables_say(seed, sign):
    """Against g of dense samples of the motion: none is missed, none is at angle + pi, also where g runs backwards."""
    rng = np.random.default_rng(seed)
    body = pt.Body(np.sort(rng.uniform(1, 1.7, 3))[::-1])
    system = pt.System(body, pt.UniformGravity(2.0 * (seed > 0), rng.normal(size=3)))
    q = rng.normal(size=(3, 4))
    start = body.state(q / np.linalg.norm(q, axis=1)[:, None], omega_body=0.3 * rng.normal(size=(3, 3)))
    times = sign * np.linspace(0, 20, 4001)
    motion = pt.propagate(system, start, times, events=[pt.events.AndoyerCrossing(angle=0.8)])
    for k in range(3):
        found = motion.events[0].member(k)
        one = pt.State(motion.quaternion[k], motion.conjugate_momenta[k], times)
        off = np.angle(np.exp(1j * (pt.Andoyer.from_state(one).g - 0.8)))
        passed = (off[1:] * off[:-1] < 0) & (np.abs(off[1:] - off[:-1]) < 1)
        assert len(found) == passed.sum()
        assert np.max(np.abs(pt.Andoyer.from_state(found.states).g - 0.8), initial=0) < 1e-13
        assert np.array_equal(found.directions, sign * np.sign(off[1:] - off[:-1])[passed])


def test_a_start_on_the_section_is_a_point_of_it():
    start = pt.Andoyer(l=0.3, g=0.8, h=0.2, L=0.5, G=1.0, H=0.3).state()
    aside = pt.Andoyer(l=0.4, g=0.7, h=0.2, L=0.5, G=1.0, H=0.3).state()
    pair = pt.State(*(np.stack([getattr(s, n) for s in (start, aside)]) for n in ("quaternion", "conjugate_momenta")))
    for sign in (1, -1):
        alone = pt.analysis.andoyer_section(pt.System(BODY), start, 20.0 * sign, angle=0.8)
        assert (alone.x[0, 0], alone.y[0, 0]) == pytest.approx((0.3, 0.5), abs=1e-15)
        assert alone.x.shape[1] == 1 + len(alone.motion.events[0]) > 1
        both = pt.analysis.andoyer_section(pt.System(BODY), pair, 20.0 * sign, angle=0.8)
        plain = pt.analysis.andoyer_section(pt.System(BODY), aside, 20.0 * sign, angle=0.8)
        assert np.allclose(both.x[0][np.isfinite(both.x[0])], alone.x[0], rtol=0, atol=1e-13)
        assert np.allclose(both.x[1][np.isfinite(both.x[1])], plain.x[0], rtol=0, atol=1e-13)


class Switched(pt.Torque):
    """A torque on one side of a plane through the body."""

    def torque(self, instant):
        x, y, _ = instant.attitude.to_body((0.6, 0.0, 0.8))
        return fn.where(fn.less(x, 0.3 * y + 0.1), 0.2, -0.1) * fn.Vector((0.3, -1.0, 0.5))


@pytest.mark.parametrize("rate", [0.0, 1e-100, 1e-30, 1e-18, 1e-15])
@pytest.mark.parametrize("sign", [1, -1], ids=["forwards", "backwards"])
def test_a_body_almost_at_rest_loses_neither_burns_nor_kicks(rate, sign):
    """The time in which it turns is no measure of when two events are one."""
    start = BODY.state((1, 0, 0, 0), omega_body=(0, 0, rate))
    burn = Window(*np.sort(sign * np.array([10.0, 20.0])), size=0.1)
    motion = pt.propagate(pt.System(BODY, burn), start, [sign * 30.0], events=[Kick(2.0 * sign, 3.0 * sign, 40.0)])
    assert motion.omega_body[0, 2] == pytest.approx(sign * 1.0 + 2e-3, rel=1e-13, abs=0)
