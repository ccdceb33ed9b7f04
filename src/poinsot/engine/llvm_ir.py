"""LLVM's intermediate representation as text: values with operators, memory with indices, branches and loops.

Every operation is one instruction, in the order of the program; no multiplication is contracted with an addition
unless it says so (`fma`). So the same formulas give the same bits in vectors of any length.
"""

from __future__ import annotations

import ctypes
import functools
import hashlib
import importlib.util
import platform
import struct
from collections.abc import Callable, Iterator, Sequence
from contextlib import contextmanager
from typing import Any

import numpy as np

from poinsot.engine.object_cache import ObjectCache, folder

__all__ = [
    "BOOL",
    "DOUBLE",
    "INTEGER",
    "POINTER",
    "SELDOM",
    "Array",
    "Function",
    "Module",
    "Record",
    "Value",
    "host_features",
    "machine_code",
    "vector",
]

DOUBLE, INTEGER, BOOL, POINTER = "double", "i64", "i1", "ptr"

CODE_GENERATION = 1
"""LLVM's level: code of level 2 is not faster, and of a large system it takes nearly twice as long to make."""

MAX_OPTIMIZED = 20_000_000
"""Characters of a text above which code is of level 0: of some 35,000 operations level 1 takes 10 s, level 0 a fifth of
that, and a step of level 0 takes nearly twice as long."""

FORMAT = 1
"""A number to change where the same text is compiled or loaded otherwise than before."""

ATTRIBUTES = 'alignstack(64) "prefer-vector-width"="512"'
"""Of all functions. LLVM by itself keeps vectors that find no register at any multiple of 16 bytes of the stack: where
they cross lines of the cache, which is chance, a step takes up to 1.2 times as long."""

SELDOM = f"noinline optnone {ATTRIBUTES}"
"""Of functions that run once a task or less: they are compiled without optimization, in a third of the time."""


NEVER = "never"
"""The label of the block that no run reaches."""


def vector(kind: str, lanes: int) -> str:
    """Return the type of so many values of a kind; of one it is the kind."""
    return kind if lanes == 1 else f"<{lanes} x {kind}>"


def _lanes(kind: str) -> int:
    return int(kind[1:].split(" ")[0]) if kind.startswith("<") else 1


def _kind(kind: str) -> str:
    return kind[:-1].split(" ")[-1] if kind.startswith("<") else kind


def _number(kind: str, number: float) -> str:
    """Return a constant of a type."""
    is_double = _kind(kind) == DOUBLE
    text = f"0x{struct.unpack('<Q', struct.pack('<d', number))[0]:016X}" if is_double else str(int(number))
    return text if _lanes(kind) == 1 else "<" + ", ".join([f"{_kind(kind)} {text}"] * _lanes(kind)) + ">"


def _operators(name: str) -> tuple[Callable[[Value, Value | float], Value], Callable[[Value, float], Value]]:
    """Return the methods of an operator: with the value on its left and on its right."""

    def written(value: Value, *operands: Value | float) -> Value:
        return value._new("f" * (DOUBLE in value.type) + name, *map(value.like, operands))

    return (lambda value, other: written(value, value, other)), (lambda value, other: written(value, other, value))


class Value:
    """A number, a vector of numbers or an address; operators on it write instructions."""

    __slots__ = ("function", "name", "type")

    def __init__(self, function: Function, kind: str, name: str) -> None:
        self.function, self.type, self.name = function, kind, name

    def like(self, other: Value | float) -> Value:
        """Return a value, or a number as a constant of this one's type."""
        return other if isinstance(other, Value) else self.function.constant(self.type, other)

    def _new(self, operation: str, *operands: Value, kind: str = "") -> Value:
        names = ", ".join(operand.name for operand in operands)
        return self.function.new(kind or self.type, f"{operation} {self.type} {names}")

    __add__, __radd__ = _operators("add")
    __sub__, __rsub__ = _operators("sub")
    __mul__, __rmul__ = _operators("mul")

    def __truediv__(self, other: Value | float) -> Value:
        return self._new("fdiv", self, self.like(other))

    def __rtruediv__(self, other: float) -> Value:
        return self._new("fdiv", self.like(other), self)

    def __neg__(self) -> Value:
        return self._new("fneg", self)

    def __and__(self, other: Value | int) -> Value:
        return self._new("and", self, self.like(other))

    def __or__(self, other: Value | int) -> Value:
        return self._new("or", self, self.like(other))

    def __xor__(self, other: Value | int) -> Value:
        return self._new("xor", self, self.like(other))

    def __invert__(self) -> Value:
        return self ^ self.like(-1 if _kind(self.type) == INTEGER else 1)

    def __lshift__(self, bits: int) -> Value:
        return self._new("shl", self, self.like(bits))

    def __rshift__(self, bits: int) -> Value:
        return self._new("lshr", self, self.like(bits))

    def is_(self, relation: str, other: Value | float) -> Value:
        """Compare: lt, le, gt, ge, eq; NaN is in no relation to anything."""
        other = self.like(other)
        if DOUBLE in self.type:
            test = f"fcmp o{relation}"
        else:
            test = f"icmp {relation if relation in ('eq', 'ne') else 's' + relation}"
        return self._new(test, self, other, kind=vector(BOOL, _lanes(self.type)))

    def choose(self, yes: Value, no: Value | float) -> Value:
        """Return one of two values where this mask is set, the other elsewhere."""
        no = yes.like(no)
        text = f"select {self.type} {self.name}, {yes.type} {yes.name}, {no.type} {no.name}"
        return self.function.new(yes.type, text)

    def larger(self, other: Value | float) -> Value:
        """Return the larger one of two; of NaN and a number, the number, if that is the other one."""
        other = self.like(other)
        return self.is_("gt", other).choose(self, other)

    def smaller(self, other: Value | float) -> Value:
        """Return the smaller one of two, likewise."""
        other = self.like(other)
        return self.is_("lt", other).choose(self, other)

    def intrinsic(self, name: str, *others: Value | float) -> Value:
        """Call an elementwise intrinsic of LLVM."""
        lanes = _lanes(self.type)
        name = f"llvm.{name}.{'v' + str(lanes) if lanes > 1 else ''}{'f64' if DOUBLE in self.type else 'i64'}"
        return self.function.call(self.type, name, self, *map(self.like, others))

    def fma(self, factor: Value | float, addend: Value | float) -> Value:
        """Return self * factor + addend with one rounding."""
        return self.intrinsic("fma", factor, addend)

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
        kind = vector(kind, _lanes(self.type))
        return self.function.new(kind, f"{operation} {self.type} {self.name} to {kind}")

    def part(self, part: int) -> Value:
        """Return one of two values."""
        kind = self.type[1:-1].split(", ")[part]
        return self.function.new(kind, f"extractvalue {self.type} {self.name}, {part}")

    def lane(self, lane: int) -> Value:
        """Return one of the numbers of a vector."""
        if _lanes(self.type) == 1:
            return self
        return self.function.new(_kind(self.type), f"extractelement {self.type} {self.name}, i32 {lane}")

    def with_lane(self, lane: int, value: Value) -> Value:
        """Return a vector with one number exchanged."""
        if _lanes(self.type) == 1:
            return value
        text = f"insertelement {self.type} {self.name}, {value.type} {value.name}, i32 {lane}"
        return self.function.new(self.type, text)

    def spread(self, lanes: int) -> Value:
        """Return a vector of this number."""
        if lanes == 1:
            return self
        kind = vector(self.type, lanes)
        first = self.function.new(kind, f"insertelement {kind} poison, {self.type} {self.name}, i32 0")
        text = f"shufflevector {kind} {first.name}, {kind} poison, <{lanes} x i32> zeroinitializer"
        return self.function.new(kind, text)

    def any(self) -> Value:
        """Whether a mask is set somewhere."""
        lanes = _lanes(self.type)
        if lanes == 1:
            return self
        whole = self.function.new(f"i{lanes}", f"bitcast {self.type} {self.name} to i{lanes}")
        return self.function.new(BOOL, f"icmp ne i{lanes} {whole.name}, 0")


class Array:
    """Numbers or vectors of a type one after another in memory, from an address, which is a multiple of their size.

    `align` says what else it is a multiple of, in bytes.
    """

    def __init__(self, address: Value, kind: str, align: int | None = None) -> None:
        self.address, self.type, self._align = address, kind, align or 8 * _lanes(kind)

    def at(self, index: Value | int) -> Value:
        """Return the address of an element."""
        if isinstance(index, int) and index == 0:
            return self.address
        where = index.name if isinstance(index, Value) else index
        text = f"getelementptr {self.type}, ptr {self.address.name}, i64 {where}"
        return self.address.function.new(POINTER, text)

    def __getitem__(self, index: Value | int) -> Value:
        text = f"load {self.type}, ptr {self.at(index).name}, align {self._align}"
        return self.address.function.new(self.type, text)

    def __setitem__(self, index: Value | int, value: Value | float) -> None:
        function = self.address.function
        given = value if isinstance(value, Value) else function.constant(self.type, value)
        function.line(f"store {self.type} {given.name}, ptr {self.at(index).name}, align {self._align}")

    def of(self, kind: str) -> Array:
        """Return the same memory as elements of another type."""
        return Array(self.address, kind)


class Record:
    """A structure in memory whose fields are those of a NumPy type."""

    def __init__(self, address: Value, kind: np.dtype[Any]) -> None:
        self.address, self._kind = address, kind

    def array(self, name: str, kind: str = DOUBLE) -> Array:
        """Return a field as elements of a type."""
        fields: Any = self._kind.fields
        return Array(Array(self.address, "i8").at(fields[name][1]), kind)


class Module:
    """Functions, and what they call from outside."""

    def __init__(self) -> None:
        self.functions: dict[str, Function] = {}
        self.called: dict[str, str] = {}

    def function(
        self,
        name: str,
        returns: str,
        arguments: Sequence[str],
        body: Callable[..., Value | None],
        attributes: str = ATTRIBUTES,
    ) -> None:
        """Define a function, if there is none of that name, by what writes its body from its arguments."""
        if name in self.functions:
            return
        function = self.functions[name] = Function(self, name, returns, arguments, attributes)
        result = body(*function.arguments)
        function.line("ret void" if result is None else f"ret {result.type} {result.name}")

    def __str__(self) -> str:
        declared = [text for name, text in self.called.items() if name not in self.functions]
        return "\n".join([*declared, *map(str, self.functions.values())])


class Function:
    """The text of a function while it is written."""

    def __init__(self, module: Module, name: str, returns: str, arguments: Sequence[str], attributes: str) -> None:
        self.module, self.name, self.returns, self._attributes = module, name, returns, attributes
        self.arguments = [Value(self, kind, f"%a{i}") for i, kind in enumerate(arguments)]
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

    def constant(self, kind: str, number: float) -> Value:
        """Return a constant."""
        return Value(self, kind, _number(kind, number))

    def call(self, kind: str, name: str, *arguments: Value) -> Value:
        """Call a function that returns a value."""
        self.module.called[name] = f"declare {kind} @{name}({', '.join(value.type for value in arguments)})"
        return self.new(kind, f"call {kind} @{name}({_listed(arguments)})")

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
        """Do what follows under a condition."""
        inside, after = self._label(), self._label()
        self.line(f"br i1 {condition.name}, label %{inside}, label %{after}")
        self._begin(inside)
        yield
        self.line(f"br label %{after}")
        self._begin(after)

    def either(self, condition: Value, otherwise: Sequence[Value], body: Callable[[], Sequence[Value]]) -> list[Value]:
        """Return what a body returns under a condition, other values otherwise."""
        before = self._block
        with self.when(condition):
            values, end = body(), self._block
        return [
            self.new(value.type, f"phi {value.type} [{value.name}, %{end}], [{other.name}, %{before}]")
            for value, other in zip(values, otherwise, strict=True)
        ]

    def pair(self, first: Value, second: Value) -> Value:
        """Return two values as one."""
        kind = f"{{{first.type}, {second.type}}}"
        half = self.new(kind, f"insertvalue {kind} poison, {first.type} {first.name}, 0")
        return self.new(kind, f"insertvalue {kind} {half.name}, {second.type} {second.name}, 1")

    def repeat(
        self,
        carried: Sequence[Value],
        going: Callable[..., Value],
        body: Callable[..., Sequence[Value]],
    ) -> list[Value]:
        """Repeat a body while a condition holds; both take the carried values, and the body returns the next ones."""
        before, head, inside, after = self._block, self._label(), self._label(), self._label()
        self.line(f"br label %{head}")
        self._begin(head)
        place, values = len(self._lines), [self._fresh(value.type) for value in carried]
        self.line(f"br i1 {going(*values).name}, label %{inside}, label %{after}")
        self._begin(inside)
        following = body(*values)
        self._lines[place:place] = [
            f"{value.name} = phi {value.type} [{first.name}, %{before}], [{later.name}, %{self._block}]"
            for value, first, later in zip(values, carried, following, strict=True)
        ]
        self.line(f"br label %{head}")
        self._begin(after)
        return values

    def count(self, count: Value | int, body: Callable[[Value], Any]) -> None:
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
    return ", ".join(f"{value.type} {value.name}" for value in values)


@functools.cache
def host_features() -> dict[str, bool]:
    """Return the instructions that this processor has, by LLVM's names; none without llvmlite."""
    if importlib.util.find_spec("llvmlite") is None:
        return {}
    import llvmlite.binding as llvm

    return dict(llvm.get_host_cpu_features())


def machine_code(text: str, library: Sequence[str]) -> Any:
    """Compile a module that calls some functions of the C library, or load it from disk; return the code's owner."""
    import llvmlite.binding as llvm

    llvm.initialize_native_target()
    llvm.initialize_native_asmprinter()
    own = ctypes.CDLL("ucrtbase" if platform.system() == "Windows" else None)
    for name in library:
        llvm.add_symbol(name, ctypes.cast(getattr(own, name), ctypes.c_void_p).value)
    cpu, features = llvm.get_host_cpu_name(), llvm.get_host_cpu_features().flatten()
    level = CODE_GENERATION if len(text) <= MAX_OPTIMIZED else 0
    machine = llvm.Target.from_default_triple().create_target_machine(cpu=cpu, features=features, opt=level)
    cache, key = ObjectCache(folder()), _key(text, machine.triple, cpu, features, level)
    code = cache.load(key)
    if code is None:
        code = machine.emit_object(llvm.parse_assembly(text))
        cache.store(key, code)
    engine = llvm.create_mcjit_compiler(llvm.parse_assembly(""), machine)
    engine.add_object_file(llvm.ObjectFileRef.from_data(code))
    engine.finalize_object()
    return engine


def _key(text: str, *machine: object) -> str:
    """Return the name of all that decides what object code is."""
    import llvmlite
    import llvmlite.binding as llvm

    decided = (FORMAT, llvmlite.__version__, llvm.llvm_version_info, *machine)
    return hashlib.sha256(repr(decided).encode() + b"\0" + text.encode()).hexdigest()
