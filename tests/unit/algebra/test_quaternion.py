"""Quaternion algebra on arrays and on the scalars of formulas."""

import heyoka as hy
import mpmath
import numpy as np
import pytest
import sympy
from scipy.spatial.transform import Rotation

from poinsot import functions
from poinsot.algebra import quaternion as quat
from poinsot.functions import Vector
from poinsot.taylor.graph import Graph, tangents

ONE, IX, JY, KZ = np.eye(4)
P, Q = np.array([0.3, -1.2, 0.7, 2.0]), np.array([-0.4, 0.9, 1.1, -0.6])


@pytest.mark.parametrize(
    ("p", "q", "expected"),
    [
        *((IX, JY, KZ), (JY, KZ, IX), (KZ, IX, JY)),
        *((JY, IX, -KZ), (KZ, JY, -IX), (IX, KZ, -JY)),
        *((IX, IX, -ONE), (JY, JY, -ONE), (KZ, KZ, -ONE)),
    ],
)
def test_hamilton_product_of_the_units(p, q, expected):
    assert quat.product(p, q).tolist() == expected.tolist()


def test_one_is_neutral():
    assert quat.product(ONE, Q).tolist() == quat.product(Q, ONE).tolist() == Q.tolist()


def test_product_is_the_product_of_complex_matrices():
    def matrix(q):
        a, b, c, d = q
        return np.array([[a + 1j * b, c + 1j * d], [-c + 1j * d, a - 1j * b]])

    assert np.allclose(matrix(quat.product(P, Q)), matrix(P) @ matrix(Q), rtol=0, atol=2e-15)


def test_product_broadcasts_leading_axes(rng):
    p, q = rng.normal(size=(5, 1, 4)), rng.normal(size=(3, 4))
    products = quat.product(p, q)
    assert products.shape == (5, 3, 4)
    assert np.array_equal(products[4, 1], quat.product(p[4, 0], q[1]))


def test_product_accepts_lists():
    assert quat.product([0, 1, 0, 0], [0, 0, 1, 0]).tolist() == [0, 0, 0, 1]


def test_conjugate_turns_the_vector_part():
    assert quat.conjugate(P).tolist() == [0.3, 1.2, -0.7, -2.0]


def test_dot_is_the_real_part_of_p_times_the_conjugate_of_q():
    assert quat.dot(P, Q) == pytest.approx(quat.product(P, quat.conjugate(Q))[0], rel=1e-15, abs=0)
    assert quat.dot(P, Q) == pytest.approx(float(P @ Q), rel=1e-15, abs=0)


def test_norm_is_euclidean():
    assert quat.norm([1.0, 1.0, 1.0, 1.0]) == 2.0
    assert quat.norm(np.ones((6, 4))).shape == (6,)


def test_pure_and_imaginary_are_inverse():
    assert quat.pure([1.0, 2.0, 3.0]).tolist() == [0, 1, 2, 3]
    assert quat.imaginary(quat.pure(np.ones((2, 3)))).tolist() == [[1, 1, 1], [1, 1, 1]]


def test_component_product():
    assert quat.component_product([1.0, 2.0, 3.0], [4.0, 5.0, 6.0]).tolist() == [4, 10, 18]


def test_rotate_is_active_and_right_handed():
    quarter_about_3 = [np.sqrt(0.5), 0, 0, np.sqrt(0.5)]
    assert np.allclose(quat.rotate(quarter_about_3, [1, 0, 0]), [0, 1, 0], rtol=0, atol=1e-15)
    assert np.allclose(quat.rotate(quarter_about_3, [0, 1, 0]), [-1, 0, 0], rtol=0, atol=1e-15)


def test_rotate_back_with_the_conjugate():
    q = P / np.linalg.norm(P)
    x = np.array([0.3, -0.5, 2.0])
    assert np.allclose(quat.rotate(quat.conjugate(q), quat.rotate(q, x)), x, rtol=0, atol=2e-15)


def test_rotate_scales_by_the_squared_norm():
    assert np.allclose(quat.rotate(3 * ONE, [1.0, 2.0, 3.0]), [9, 18, 27], rtol=1e-15, atol=0)


def test_rotate_broadcasts_states_and_vectors(rng):
    q, x = rng.normal(size=(7, 4)), rng.normal(size=3)
    assert np.allclose(quat.rotate(q, x)[5], quat.rotate(q[5], x), rtol=1e-15, atol=0)


# ---------------------------------------------------------------------- other scalars


def test_product_of_heyoka_expressions():
    p, q = (functions.Vector(hy.expression(f"{name}{i}") for i in range(4)) for name in "pq")
    compiled = hy.cfunc(list(quat.product(p, q)), vars=[*p, *q])
    assert np.allclose(compiled(np.concatenate([P, Q])), quat.product(P, Q), rtol=1e-15, atol=0)


def test_rotate_with_heyoka_expressions():
    q = functions.Vector(hy.expression(f"q{i}") for i in range(4))
    compiled = hy.cfunc(list(quat.rotate(q, functions.Vector((1.0, 2.0, 3.0)))), vars=[*q])
    assert np.allclose(compiled(P), quat.rotate(P, [1.0, 2.0, 3.0]), rtol=1e-14, atol=0)


def test_norm_is_multiplicative_in_symbols():
    p, q = (functions.Vector(sympy.symbols(f"{name}0:4", real=True)) for name in "pq")
    product = quat.product(p, q)
    assert sympy.expand(quat.dot(product, product) - quat.dot(p, p) * quat.dot(q, q)) == 0


def test_object_arrays_of_symbols_stay_arrays():
    p = np.array(sympy.symbols("p0:4", real=True))
    product = quat.product(p, quat.conjugate(p))
    assert isinstance(product, np.ndarray)
    assert sympy.expand(product[0]) == sympy.expand(quat.dot(p, p))
    assert [sympy.expand(x) for x in product[1:]] == [0, 0, 0]


def test_product_of_mpmath_numbers_keeps_their_digits():
    with mpmath.workdps(40):
        third = mpmath.mpf(1) / 3
        product = quat.product(np.array([third, third, 0, 0]), np.array([0, 0, third, 0]))
        assert product[2] == third * third
        assert product[3] == third * third


def test_a_vector_in_gives_a_vector_out():
    q = functions.Vector(Q)
    for value in (quat.product(P, q), quat.conjugate(q), quat.pure(functions.Vector((1, 2, 3))), quat.imaginary(q)):
        assert isinstance(value, functions.Vector)


@pytest.mark.parametrize("size", [0.0, 1e-12, 9.99e-4, 1.001e-3, 0.7, np.pi - 1e-9, np.pi])
def test_exponential_and_rotation_vector_agree_with_scipy(size):
    vectors = size * np.array([(0.6, 0.0, -0.8), (-1.0, 0.0, 0.0), (2 / 3, 2 / 3, 1 / 3)])
    expected = Rotation.from_rotvec(vectors).as_quat(scalar_first=True)
    turns = quat.exponential(vectors)
    assert np.allclose(turns, expected, rtol=0, atol=4e-16)
    assert np.allclose(quat.rotation_vector(turns), vectors, rtol=1e-15, atol=1e-15 * size)
    assert size > 3 or np.array_equal(quat.rotation_vector(-turns), quat.rotation_vector(turns))


def test_the_rotation_vector_is_that_of_the_shorter_turn():
    assert quat.rotation_vector([np.cos(2.0), 0.0, np.sin(2.0), 0.0]) == pytest.approx(
        [0, 4 - 2 * np.pi, 0], rel=1e-15, abs=0
    )


@pytest.mark.parametrize("vector", [(0.0, 0.0, 0.0), (2e-4, -3e-4, 1e-4), (0.5, -0.2, 0.9)])
def test_derivatives_of_the_exponential_agree_with_digits(vector):
    graph = Graph()
    nodes = Vector(map(graph.variable, vector))
    turn = quat.exponential(nodes)
    with mpmath.workdps(40):
        for i, node in enumerate(nodes):
            found = graph.evaluated(tangents([*turn, *quat.rotation_vector(turn)], {node: 1.0}))

            def moved(h, i=i):
                v = [mpmath.mpf(x) + (h if j == i else 0) for j, x in enumerate(vector)]
                a = mpmath.sqrt(sum(x * x for x in v)) + mpmath.mpf(10) ** -30
                return [mpmath.cos(a / 2), *(x * mpmath.sin(a / 2) / a for x in v)]

            h = mpmath.mpf(10) ** -12
            expected = [float((b - a) / (2 * h)) for a, b in zip(moved(-h), moved(h), strict=True)]
            assert np.allclose(found[:4], expected, rtol=0, atol=1e-15)
            assert np.allclose(found[4:], np.eye(3)[i], rtol=0, atol=2e-15)
