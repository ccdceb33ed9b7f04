"""CUDA C from LLVM's representation: what the kernels of the suite need not show."""

import ctypes

import numpy as np
import pytest

import cuda_on_cpu
from poinsot.cuda.source import translated
from poinsot.taylor.llvm_ir import DOUBLE, INTEGER, Module

pytestmark = cuda_on_cpu.needs_compiler


def called(body, *arguments):
    """Return what a function of doubles or integers returns, in CUDA C."""
    module, integer = Module(), isinstance(arguments[0], int)
    kind, own, c = (INTEGER, "long long", ctypes.c_longlong) if integer else (DOUBLE, "double", ctypes.c_double)
    module.function("f", kind, [kind] * len(arguments), body)
    given = ", ".join(f"{own} x{i}" for i in range(len(arguments)))
    names = ", ".join(f"x{i}" for i in range(len(arguments)))
    entry = f'extern "C" {own} entry({given}) {{ return f({names}); }}'
    function = cuda_on_cpu.built(translated(str(module)), entry).entry
    function.restype = c
    return function(*map(c, arguments))


def test_what_a_loop_carries_changes_at_once():
    def swapped_three_times(a, b):
        lines = a.function
        count = lines.constant(INTEGER, 0)
        _, first, second = lines.repeat(
            [count, a, b], lambda n, *_: n.is_("lt", 3), lambda n, one, other: [n + 1, other, one]
        )
        return first + second * 100.0

    assert called(swapped_three_times, 1.0, 2.0) == 102.0


def test_a_block_may_be_cut():
    def twice(a):
        doubled = a * 2.0
        a.function.cut(a.is_("eq", a))
        return doubled + 1.0

    assert called(twice, 3.0) == 7.0


def test_bits_shift_without_a_sign():
    assert called(lambda x: x >> 60, -1) == 15
    assert called(lambda x: x << 62, 3) == -(2**62)
    assert called(lambda x: (~x & 12) | 1, 5) == 9


@pytest.mark.parametrize("relation", ["lt", "le", "gt", "ge", "eq"])
def test_nan_is_in_no_relation_to_anything(relation):
    def holds(a, b):
        return a.is_(relation, b).choose(a.like(1.0), 0.0)

    assert [called(holds, *pair) for pair in [(np.nan, 1.0), (2.0, 2.0), (1.0, 2.0)]] == [
        0.0,
        relation in ("le", "ge", "eq"),
        relation in ("lt", "le"),
    ]


@pytest.mark.parametrize("number", [np.inf, -np.inf, 5e-324, -0.0, 0.1, 1.7976931348623157e308])
def test_every_number_is_preserved(number):
    assert called(lambda x: (x * 0.0).is_("eq", 0.0).choose(x.like(number), 7.0), 1.0).hex() == float(number).hex()


def test_numbers_are_converted():
    assert called(lambda x: x.to_double().as_bits(), 3) == 0x4008000000000000
    assert called(lambda x: (0.5 * x).to_integer().to_double(), -7.0) == -3.0
    assert called(lambda x: x.is_("gt", 2).to_integer() + 1, 3) == 2


def test_what_has_no_translation_is_refused():
    with pytest.raises(KeyError, match="frem"):
        translated("define void @f(double %a0) {\nentry:\n%v1 = frem double %a0, %a0\nret void\n}")
    with pytest.raises(ValueError, match="one"):
        translated("define void @f(double %a0) {\nentry:\n%v1 = fcmp one double %a0, %a0\nret void\n}")
