"""LLVM's intermediate representation as text: values with operators, memory with indices, branches and loops.

Every operation is one instruction, in the order of the program; no multiplication is contracted with an addition
unless it says so (`fma`). So the same formulas give the same bits in vectors of any length.
"""

from __future__ import annotations

import functools
import importlib
import itertools
import math
import platform
import struct
from collections.abc import Callable, Iterable, Iterator, Sequence
from contextlib import contextmanager
from fractions import Fraction
from types import ModuleType
from typing import TypeAlias

import numpy as np
from typing_extensions import override

from poinsot.double_double import exact_sum, sum_of_ordered

__all__ = [
    "ATTRIBUTES",
    "BOOL",
    "DOUBLE",
    "INTEGER",
    "POINTER",
    "SELDOM",
    "Array",
    "FunctionText",
    "Module",
    "Structure",
    "Value",
    "Wide",
    "WideValue",
    "exact_product",
    "host_features",
    "llvm",
    "offset_of",
    "vector",
]

DOUBLE, INTEGER, BOOL, POINTER = "double", "i64", "i1", "ptr"

Number: TypeAlias = float | Fraction
"""A constant."""

Argument: TypeAlias = "Value | Number"
"""The second operand of an operator."""

ATTRIBUTES = 'alignstack(64) "prefer-vector-width"="512"'
"""Attributes of all functions. Without them LLVM spills vectors to any multiple of 16 bytes of the stack: where they
happen to cross cache lines, a step takes up to 1.2 times as long."""

SELDOM = f"noinline optnone {ATTRIBUTES}"
"""Attributes of functions that run at most once a task: they are compiled without optimization, in a third of the
time."""


NEVER = "never"
"""The label of the block that no run reaches."""


def vector(kind: str, lanes: int) -> str:
    """Return the type of a vector of some lanes; one lane is a scalar."""
    return kind if lanes == 1 else f"<{lanes} x {kind}>"


class Wide(str):
    """The type of double-double numbers: the text is the type of their two parts."""

    __slots__ = ()


def _lanes(kind: str) -> int:
    return int(kind[1:].split(" ")[0]) if kind.startswith("<") else 1


def _kind(kind: str) -> str:
    return kind[:-1].split(" ")[-1] if kind.startswith("<") else kind


def _number(kind: str, number: float) -> str:
    """Return a constant of a type."""
    is_double = _kind(kind) == DOUBLE
    text = f"0x{struct.unpack('<Q', struct.pack('<d', number))[0]:016X}" if is_double else str(int(number))
    return text if _lanes(kind) == 1 else "<" + ", ".join([f"{_kind(kind)} {text}"] * _lanes(kind)) + ">"


def _operators(name: str) -> tuple[Callable[[Value, Argument], Value], Callable[[Value, Number], Value]]:
    """Return the methods of an operator: with the value on its left and on its right."""

    def written(value: Value, *operands: Argument) -> Value:
        return value._new("f" * (DOUBLE in value.type) + name, *map(value.like, operands))

    return (lambda value, other: written(value, value, other)), (lambda value, other: written(value, other, value))


class Value:
    """A number, a vector of numbers or an address; operators on it write instructions."""

    __slots__ = ("function", "name", "type")

    def __init__(self, function: FunctionText, kind: str, name: str) -> None:
        self.function, self.type, self.name = function, kind, name

    @property
    def lanes(self) -> int:
        """Numbers in a vector."""
        return _lanes(self.type)

    @property
    def parts(self) -> tuple[Value, ...]:
        """The values of LLVM that represent the number."""
        return (self,)

    @property
    def high(self) -> Value:
        """The number in double precision."""
        return self

    def of_parts(self, parts: Iterator[Value]) -> Value:
        """Return a number of this kind from the next ones of some values of LLVM."""
        return next(parts)

    def each(self, operation: Callable[..., Value], *others: Value) -> Value:
        """Return the number with the parts that an operation returns for the parts of this and other numbers."""
        return self.of_parts(map(operation, self.parts, *(other.parts for other in others)))

    def like(self, other: Argument) -> Value:
        """Return a value, or a number as a constant of this one's type."""
        return other if isinstance(other, Value) else self.function.constant(self.type, other)

    def _new(self, operation: str, *operands: Value, kind: str = "") -> Value:
        names = ", ".join(operand.name for operand in operands)
        return self.function.new(kind or self.type, f"{operation} {self.type} {names}")

    __add__, __radd__ = _operators("add")
    __sub__, __rsub__ = _operators("sub")
    __mul__, __rmul__ = _operators("mul")
    __truediv__, __rtruediv__ = _operators("div")
    __and__, _ = _operators("and")
    __or__, _ = _operators("or")
    __xor__, _ = _operators("xor")
    __lshift__, _ = _operators("shl")
    __rshift__, _ = _operators("lshr")

    def __neg__(self) -> Value:
        return self._new("fneg", self)

    def __invert__(self) -> Value:
        return self ^ self.like(-1 if _kind(self.type) == INTEGER else 1)

    def is_(self, relation: str, other: Argument) -> Value:
        """Compare: lt, le, gt, ge, eq, ne; every comparison with NaN is false."""
        other = self.like(other)
        if DOUBLE in self.type:
            test = f"fcmp o{relation}"
        else:
            test = f"icmp {relation if relation in ('eq', 'ne') else 's' + relation}"
        return self._new(test, self, other, kind=vector(BOOL, self.lanes))

    def choose(self, yes: Value, no: Argument) -> Value:
        """Return one of two values where this mask is set, the other elsewhere."""
        no = yes.like(no)

        def selected(a: Value, b: Value) -> Value:
            return self.function.new(a.type, f"select {self.type} {self.name}, {a.type} {a.name}, {b.type} {b.name}")

        return no.like(yes).each(selected, no)

    def larger(self, other: Argument) -> Value:
        """Return the larger one of two; of NaN and a number, the number, if that is the other one."""
        other = self.like(other)
        return self.is_("gt", other).choose(self, other)

    def smaller(self, other: Argument) -> Value:
        """Return the smaller one of two, likewise."""
        other = self.like(other)
        return self.is_("lt", other).choose(self, other)

    def intrinsic(self, name: str, *others: Argument) -> Value:
        """Call an elementwise intrinsic of LLVM."""
        lanes = self.lanes
        name = f"llvm.{name}.{'v' + str(lanes) if lanes > 1 else ''}{'f64' if DOUBLE in self.type else 'i64'}"
        return self.function.call(self.type, name, self, *map(self.like, others))

    def fma(self, factor: Argument, addend: Argument) -> Value:
        """Return self * factor + addend with one rounding."""
        return self.intrinsic("fma", factor, addend)

    def product_added(self, factor: Value, total: Value) -> Value:
        """Return total + self * factor as a term of a long sum, which `normalized` ends."""
        return self.fma(factor, total)

    def normalized(self) -> Value:
        """Return the sum of terms that `product_added` has added."""
        return self

    def sqrt(self) -> Value:
        """Return the square root."""
        return self.intrinsic("sqrt")

    def rint(self) -> Value:
        """Return the nearest integer."""
        return self.intrinsic("rint")

    def times_power_of_two(self, power: Argument) -> Value:
        """Return the product with a power of two, which is exact."""
        return self * power

    def __abs__(self) -> Value:
        return self.intrinsic("fabs")

    def as_bits(self) -> Value:
        """Return the bits of doubles as integers."""
        return self._cast("bitcast", INTEGER)

    def as_double(self) -> Value:
        """Return integers as the bits of doubles."""
        return self._cast("bitcast", DOUBLE)

    def to_integer(self) -> Value:
        """Convert doubles to integers, or masks to 0 and 1."""
        return self._cast("zext" if _kind(self.type) == BOOL else "fptosi", INTEGER)

    def to_double(self) -> Value:
        """Convert integers to doubles."""
        return self._cast("sitofp", DOUBLE)

    def _cast(self, operation: str, kind: str) -> Value:
        kind = vector(kind, self.lanes)
        return self.function.new(kind, f"{operation} {self.type} {self.name} to {kind}")

    def part(self, part: int) -> Value:
        """Return one of two values."""
        kind = self.type[1:-1].split(", ")[part]
        return self.function.new(kind, f"extractvalue {self.type} {self.name}, {part}")

    def lane(self, lane: int) -> Value:
        """Return one of the numbers of a vector."""

        def extracted(part: Value) -> Value:
            return self.function.new(_kind(part.type), f"extractelement {part.type} {part.name}, i32 {lane}")

        return self if self.lanes == 1 else self.each(extracted)

    def with_lane(self, lane: int, value: Value) -> Value:
        """Return a vector with one number exchanged."""

        def inserted(part: Value, number: Value) -> Value:
            text = f"insertelement {part.type} {part.name}, {number.type} {number.name}, i32 {lane}"
            return self.function.new(part.type, text)

        return value if self.lanes == 1 else self.each(inserted, value)

    def spread(self, lanes: int) -> Value:
        """Return a vector of this number."""

        def filled(part: Value) -> Value:
            kind = vector(part.type, lanes)
            first = self.function.new(kind, f"insertelement {kind} poison, {part.type} {part.name}, i32 0")
            text = f"shufflevector {kind} {first.name}, {kind} poison, <{lanes} x i32> zeroinitializer"
            return self.function.new(kind, text)

        return self if lanes == 1 else self.each(filled)

    def any(self) -> Value:
        """Return a mask that is set if this mask is set in any lane."""
        lanes = self.lanes
        if lanes == 1:
            return self
        whole = self.function.new(f"i{lanes}", f"bitcast {self.type} {self.name} to i{lanes}")
        return self.function.new(BOOL, f"icmp ne i{lanes} {whole.name}, 0")


class WideValue(Value):
    """A double-double number: high + low, |low| at most half a unit in the last place of high.

    Sums are Knuth's, products take one `fma` for the rounding error, quotients and roots one correction (Dekker 1971,
    Numer. Math. 18, 224; Joldes, Muller and Popescu 2017, ACM TOMS 44, 15). Relative errors are a few 2^-106.
    """

    __slots__ = ("high", "low")
    high: Value

    def __init__(self, high: Value, low: Value) -> None:
        super().__init__(high.function, Wide(high.type), "")
        self.high, self.low = high, low

    @property
    @override
    def parts(self) -> tuple[Value, ...]:
        return self.high, self.low

    @override
    def of_parts(self, parts: Iterator[Value]) -> Value:
        return WideValue(next(parts), next(parts))

    @override
    def like(self, other: Argument) -> WideValue:
        if isinstance(other, WideValue):
            return other
        if isinstance(other, Value):
            return WideValue(other, Value.like(self.high, 0.0))
        return WideValue(*self.function.constant(self.type, other).parts)

    @override
    def __add__(self, other: Argument) -> WideValue:
        if isinstance(other, Value) and not isinstance(other, WideValue):
            high, low = exact_sum(self.high, other)
            return WideValue(*sum_of_ordered(high, low + self.low))
        other = self.like(other)
        (high, small), (low, smaller) = exact_sum(self.high, other.high), exact_sum(self.low, other.low)
        high, low = sum_of_ordered(high, small + low)
        return WideValue(*sum_of_ordered(high, low + smaller))

    __radd__ = __add__

    @override
    def __sub__(self, other: Argument) -> WideValue:
        return self + (-other)

    @override
    def __rsub__(self, other: Argument) -> WideValue:
        return -self + other

    @override
    def __mul__(self, other: Argument) -> WideValue:
        if isinstance(other, float | int) and math.frexp(other)[0] in (0.5, -0.5):
            return self.times_power_of_two(float(other))
        if isinstance(other, Value) and not isinstance(other, WideValue):
            high, low = exact_product(self.high, other)
            return WideValue(*sum_of_ordered(high, self.low.fma(other, low)))
        other = self.like(other)
        high, low = exact_product(self.high, other.high)
        return WideValue(*sum_of_ordered(high, self.high.fma(other.low, self.low.fma(other.high, low))))

    __rmul__ = __mul__

    @override
    def __truediv__(self, other: Argument) -> WideValue:
        other = self.like(other)
        first = self.high / other.high
        high, low = exact_product(first, other.high)
        rest = ((self.high - high) - low) + (self.low - first * other.low)
        return WideValue(*sum_of_ordered(first, rest / other.high))

    @override
    def __rtruediv__(self, other: Argument) -> WideValue:
        return self.like(other) / self

    @override
    def __neg__(self) -> WideValue:
        return WideValue(-self.high, -self.low)

    @override
    def __abs__(self) -> WideValue:
        return WideValue(*self.high.is_("lt", 0.0).choose(-self, self).parts)

    @override
    def fma(self, factor: Argument, addend: Argument) -> WideValue:
        return self * factor + addend

    @override
    def product_added(self, factor: Value, total: Value) -> WideValue:
        a, b, (sum_high, sum_low) = self, self.like(factor), total.parts
        product, rest = exact_product(a.high, b.high)
        rest = a.high.fma(b.low, a.low.fma(b.high, rest))
        high, small = exact_sum(sum_high, product)
        return WideValue(high, sum_low + (small + rest))

    @override
    def normalized(self) -> WideValue:
        return WideValue(*sum_of_ordered(self.high, self.low))

    @override
    def sqrt(self) -> WideValue:
        root = self.high.sqrt()
        high, low = exact_product(root, root)
        more = (((self.high - high) - low) + self.low) / (2.0 * root)
        return WideValue(*sum_of_ordered(root, root.is_("gt", 0.0).choose(more, 0.0)))

    @override
    def rint(self) -> WideValue:
        whole = self.high.rint()
        rest = self.high - whole  # low decides halves
        beyond = (abs(rest).is_("eq", 0.5) & (rest * self.low).is_("gt", 0.0)).choose(2.0 * rest, 0.0)
        low = rest.is_("eq", 0.0).choose(self.low.rint(), beyond)
        return WideValue(*sum_of_ordered(whole, low))

    @override
    def times_power_of_two(self, power: Argument) -> WideValue:
        return WideValue(self.high * power, self.low * power)

    @override
    def is_(self, relation: str, other: Argument) -> Value:
        if isinstance(other, float | int) and other == 0:
            return self.high.is_(relation, 0.0)
        return (self - other).high.is_(relation, 0.0)


def exact_product(a: Value, b: Value) -> tuple[Value, Value]:
    """Return the product of doubles and its rounding error."""
    product = a * b
    return product, a.fma(b, -product)


def _returned(kind: str) -> str:
    """Return the type of LLVM that a function returns for a type of numbers."""
    return f"{{{kind}, {kind}}}" if isinstance(kind, Wide) else kind


def _parts(values: Iterable[Value]) -> list[Value]:
    return [part for value in values for part in value.parts]


def _of_parts(parts: Iterable[Value], like: Iterable[Value]) -> list[Value]:
    """Return the numbers that consist of some parts, of the kinds of others."""
    own = iter(parts)
    return [value.of_parts(own) for value in like]


class Array:
    """Numbers or vectors of a type one after another in memory, from an address, which is a multiple of their size.

    Parameters
    ----------
    address : Value
    kind : str
        Type of an element.
    distance : int
        Elements between the high and the low parts of double-double numbers.
    align : int, optional
        Another number of bytes that the address is a multiple of.
    """

    def __init__(self, address: Value, kind: str, distance: int = 0, align: int | None = None) -> None:
        self.address, self.type, self._distance, self._align = address, kind, distance, align or 8 * _lanes(kind)

    def at(self, index: Value | int) -> Value:
        """Return the address of an element."""
        if isinstance(index, int) and index == 0:
            return self.address
        where = index.name if isinstance(index, Value) else index
        text = f"getelementptr {self.type}, ptr {self.address.name}, i64 {where}"
        return self.address.function.new(POINTER, text)

    def __getitem__(self, index: Value | int) -> Value:
        if isinstance(self.type, Wide):
            return WideValue(self.high[index], self.high[index + self._distance])
        text = f"load {self.type}, ptr {self.at(index).name}, align {self._align}"
        return self.address.function.new(self.type, text)

    def __setitem__(self, index: Value | int, value: Argument) -> None:
        function = self.address.function
        if isinstance(self.type, Wide):
            for place, part in enumerate(function.constant(self.type, 0.0).like(value).parts):
                self.high[index + place * self._distance if place else index] = part
            return
        given = value if isinstance(value, Value) else function.constant(self.type, value)
        function.line(f"store {self.type} {given.name}, ptr {self.at(index).name}, align {self._align}")

    def of(self, kind: str) -> Array:
        """Return a view of the memory with elements of another type, in equal precision."""
        if isinstance(self.type, Wide):
            return Array(self.address, Wide(kind), self._distance * _lanes(self.type) // _lanes(kind))
        return Array(self.address, kind)

    def from_(self, address: Value) -> Array:
        """Return an array of the type from another address."""
        return Array(address, self.type, self._distance, self._align)

    @property
    def high(self) -> Array:
        """The numbers in double precision."""
        return Array(self.address, str(self.type)) if isinstance(self.type, Wide) else self

    @property
    def low(self) -> Array:
        """The low parts of double-double numbers."""
        return Array(self.high.at(self._distance), str(self.type))


def offset_of(kind: np.dtype[np.void], name: str) -> int:
    """Return where a field of a structured type begins, in bytes."""
    assert kind.fields is not None  # noqa: S101
    return int(kind.fields[name][1])


class Structure:
    """A structure in memory with the fields of a NumPy type."""

    def __init__(self, address: Value, kind: np.dtype[np.void]) -> None:
        self.address, self._kind = address, kind

    @staticmethod
    def of(array: Value, index: Value, kind: np.dtype[np.void]) -> Structure:
        """Return a structure of an array of structures, from the address of the array."""
        return Structure(Array(array, f"[{kind.itemsize} x i8]").at(index), kind)

    def array(self, name: str, kind: str = DOUBLE) -> Array:
        """Return a field as elements of a type; low parts of double-double numbers fill the second half of a field."""
        address = Array(self.address, "i8").at(offset_of(self._kind, name))
        if isinstance(kind, Wide):
            return Array(address, kind, self._kind[name].itemsize // (16 * _lanes(kind)))
        return Array(address, kind)


class Module:
    """Functions, and declarations of the external functions that they call."""

    def __init__(self) -> None:
        self.functions: dict[str, FunctionText] = {}
        self.called: dict[str, str] = {}

    def function(
        self,
        name: str,
        returns: str,
        arguments: Sequence[str],
        body: Callable[..., Value | None],
        attributes: str = ATTRIBUTES,
    ) -> None:
        """Define a function, unless there is one of the name; `body` writes the instructions for its arguments."""
        if name in self.functions:
            return
        function = self.functions[name] = FunctionText(self, name, returns, arguments, attributes)
        result = body(*function.arguments)
        if isinstance(result, WideValue):
            result = function.struct(result)
        function.line("ret void" if result is None else f"ret {result.type} {result.name}")

    def __str__(self) -> str:
        declared = [text for name, text in self.called.items() if name not in self.functions]
        return "\n".join([*declared, *map(str, self.functions.values())])


class FunctionText:
    """The text of a function while it is written."""

    def __init__(self, module: Module, name: str, returns: str, arguments: Sequence[str], attributes: str) -> None:
        self.module, self.name, self._attributes = module, name, attributes
        self.returns = _returned(returns)
        names = (f"%a{i}" for i in itertools.count())
        self.arguments = [
            WideValue(*(Value(self, str(kind), next(names)) for _ in range(2)))
            if isinstance(kind, Wide)
            else Value(self, kind, next(names))
            for kind in arguments
        ]
        self._lines: list[str] = []
        self._count, self._block, self._cut = 0, "entry", False

    def line(self, text: str) -> None:
        """Add an instruction without a result."""
        self._lines.append(text)

    def new(self, kind: str, text: str) -> Value:
        """Add an instruction with a result of some type."""
        value = self._fresh(kind)
        self.line(f"{value.name} = {text}")
        return value

    def constant(self, kind: str, number: Number) -> Value:
        """Return a constant, a double or a fraction."""
        if isinstance(kind, Wide):
            high = float(number)
            low = float(Fraction(number) - Fraction(high)) if math.isfinite(high) else 0.0
            return WideValue(*(self.constant(str(kind), part) for part in (high, low)))
        return Value(self, kind, _number(kind, number if isinstance(number, int) else float(number)))

    def call(self, kind: str, name: str, *arguments: Value) -> Value:
        """Call a function that returns a value."""
        returns = _returned(kind)
        self.module.called[name] = f"declare {returns} @{name}({', '.join(value.type for value in _parts(arguments))})"
        found = self.new(returns, f"call {returns} @{name}({_listed(arguments)})")
        return WideValue(found.part(0), found.part(1)) if isinstance(kind, Wide) else found

    def call_defined(
        self, kind: str, name: str, body: Callable[..., Value], *arguments: Value, attributes: str = ATTRIBUTES
    ) -> Value:
        """Call a function of the module that returns a value; the first call defines the function."""
        self.module.function(name, kind, [argument.type for argument in arguments], body, attributes)
        return self.call(kind, name, *arguments)

    def run(self, name: str, *arguments: Value) -> None:
        """Call a function that returns nothing."""
        self.line(f"call void @{name}({_listed(arguments)})")

    def cut(self, always: Value) -> None:
        """Begin a new block, by a branch on a condition that always holds and that LLVM cannot see through."""
        inside = self._label()
        self.line(f"br i1 {always.name}, label %{inside}, label %{NEVER}")
        self._begin(inside)
        self._cut = True

    @contextmanager
    def when(self, condition: Value) -> Iterator[None]:
        """Execute the following instructions under a condition."""
        inside, after = self._label(), self._label()
        self.line(f"br i1 {condition.name}, label %{inside}, label %{after}")
        self._begin(inside)
        yield
        self.line(f"br label %{after}")
        self._begin(after)

    def either(self, condition: Value, otherwise: Sequence[Value], body: Callable[[], Sequence[Value]]) -> list[Value]:
        """Return the values of a body under a condition, other values otherwise."""
        before = self._block
        with self.when(condition):
            values, end = body(), self._block
        chosen = [
            self.new(value.type, f"phi {value.type} [{value.name}, %{end}], [{other.name}, %{before}]")
            for value, other in zip(_parts(values), _parts(otherwise), strict=True)
        ]
        return _of_parts(chosen, otherwise)

    def struct(self, *values: Value) -> Value:
        """Return values as one, whose parts `Value.part` returns."""
        parts = _parts(values)
        kind = f"{{{', '.join(part.type for part in parts)}}}"
        whole = Value(self, kind, "poison")
        for i, part in enumerate(parts):
            whole = self.new(kind, f"insertvalue {kind} {whole.name}, {part.type} {part.name}, {i}")
        return whole

    def repeat(
        self, carried: Sequence[Value], going: Callable[..., Value], body: Callable[..., Sequence[Value]]
    ) -> list[Value]:
        """Repeat a body while a condition holds; both take the carried values, and the body returns the next ones."""
        before, head, inside, after = self._block, self._label(), self._label(), self._label()
        self.line(f"br label %{head}")
        self._begin(head)
        place, fresh = len(self._lines), [self._fresh(part.type) for part in _parts(carried)]
        values = _of_parts(fresh, carried)
        self.line(f"br i1 {going(*values).name}, label %{inside}, label %{after}")
        self._begin(inside)
        following = body(*values)
        self._lines[place:place] = [
            f"{value.name} = phi {value.type} [{first.name}, %{before}], [{later.name}, %{self._block}]"
            for value, first, later in zip(fresh, _parts(carried), _parts(following), strict=True)
        ]
        self.line(f"br label %{head}")
        self._begin(after)
        return values

    def count(self, count: Value | int, body: Callable[[Value], None]) -> None:
        """Repeat a body with an index from zero."""

        def one(index: Value) -> list[Value]:
            body(index)
            return [index + 1]

        self.repeat([self.constant(INTEGER, 0)], lambda index: index.is_("lt", count), one)

    def _fresh(self, kind: str) -> Value:
        self._count += 1
        return Value(self, kind, f"%v{self._count}")

    def _label(self) -> str:
        self._count += 1
        return f"b{self._count}"

    def _begin(self, label: str) -> None:
        self._block = label
        self._lines.append(f"{label}:")

    def __str__(self) -> str:
        return "\n".join(
            [
                f"define {self.returns} @{self.name}({_listed(self.arguments)}) {self._attributes} {{",
                "entry:",
                *self._lines,
                *([f"{NEVER}:", "unreachable"] if self._cut else []),
                "}",
            ]
        )


def _listed(values: Sequence[Value]) -> str:
    return ", ".join(f"{value.type} {value.name}" for value in _parts(values))


@functools.cache
def llvm() -> ModuleType:
    """Return llvmlite's module of functions of LLVM.

    Raises
    ------
    ImportError
        If llvmlite is missing: pip has no wheel of it for every platform.
    """
    try:
        return importlib.import_module("llvmlite.binding")
    except (ImportError, OSError) as error:
        found = f"{platform.system()} {platform.machine()} with Python {platform.python_version()}"
        raise ImportError(
            f"llvmlite must be installed, which compiles the equations of motion, got on {found}: {error}. PyPI has "
            "wheels for Linux, macOS and Windows on common processors, and conda-forge for others."
        ) from error


@functools.cache
def host_features() -> dict[str, bool]:
    """Return the instructions of this processor by LLVM's names."""
    return dict(llvm().get_host_cpu_features())
