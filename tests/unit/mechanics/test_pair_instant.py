"""Two bodies at one instant."""

import numpy as np
import pytest

import poinsot as pt

UPRIGHT = pt.Attitude.from_quaternion((1, 0, 0, 0))
BALL = pt.Body.from_ellipsoid(2.0, (1, 1, 1))
GIVEN = {
    "pair": pt.TwoBodies(BALL, BALL, 1.0),
    "attitudes": (UPRIGHT, UPRIGHT),
    "separation": (3, 0, 4),
    "environment": pt.mechanics.Environment(0.0),
}
ORDER = "The order is PairInstant(pair, attitudes, separation, environment)."


@pytest.mark.parametrize(
    ("name", "words"),
    [
        ("pair", f"a TwoBodies, got ndarray. {ORDER}"),
        ("attitudes", f"a list, each an Attitude, got ndarray. {ORDER}"),
        ("environment", f"an Environment, got ndarray. {ORDER}"),
    ],
)
def test_arguments_of_another_kind_raise_an_error(name, words):
    with pytest.raises(TypeError) as caught:
        pt.mechanics.PairInstant(**GIVEN | {name: np.ones(3)})
    assert str(caught.value) == f"{name} must be {words}"


def test_the_distance_is_the_length_of_the_separation():
    assert pt.mechanics.PairInstant(**GIVEN).distance == 5.0
