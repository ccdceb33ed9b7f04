"""CUDA C from LLVM's representation of a kernel of one lane, instruction by instruction: so all bits are the same.

It translates the instructions that `poinsot.taylor.llvm_ir` writes. Branches become goto. Values that a block receives
from the block before it are passed in variables of their own, as all of them change at once.
"""

from __future__ import annotations

import re
import struct
from typing import NamedTuple

from poinsot.printable import quoted

__all__ = ["translated"]

TYPES = {"double": "double", "i64": "long long", "i1": "bool", "i8": "char", "ptr": "char *", "void": "void"}
TYPES["pair"] = "Pair"

WORDS = {
    **TYPES,
    **dict.fromkeys(("oeq", "eq"), "=="),
    **dict.fromkeys(("olt", "slt"), "<"),
    **dict.fromkeys(("ole", "sle"), "<="),
    **dict.fromkeys(("ogt", "sgt"), ">"),
    **dict.fromkeys(("oge", "sge"), ">="),
    "ne": "!=",
    "poison": "Pair()",
    "": "",
}
"""Types and relations in C; one of doubles that are not equal is missing, as it is true of NaN there."""

TWO, COMPARED, CAST = r"(\w+) (\S+), (\S+)", r"(\w+) \w+ (\S+), (\S+)", r"\w+ (\S+) to (\w+)"


class _Instruction(NamedTuple):
    """Pattern of the operands, and the type of the result and the text in C by the groups of the pattern."""

    pattern: str
    kind: str
    text: str


INSTRUCTIONS = {
    **dict.fromkeys(("add", "fadd"), _Instruction(TWO, "{0}", "{1} + {2}")),
    **dict.fromkeys(("sub", "fsub"), _Instruction(TWO, "{0}", "{1} - {2}")),
    **dict.fromkeys(("mul", "fmul"), _Instruction(TWO, "{0}", "{1} * {2}")),
    **dict.fromkeys(("icmp", "fcmp"), _Instruction(COMPARED, "bool", "{1} {0} {2}")),
    **dict.fromkeys(("zext", "fptosi", "sitofp"), _Instruction(CAST, "{1}", "({1}){0}")),
    "fdiv": _Instruction(TWO, "{0}", "{1} / {2}"),
    "fneg": _Instruction(r"(\w+) (\S+)", "{0}", "-{1}"),
    "and": _Instruction(TWO, "{0}", "{1} & {2}"),
    "or": _Instruction(TWO, "{0}", "{1} | {2}"),
    "xor": _Instruction(TWO, "{0}", "{1} ^ {2}"),
    "shl": _Instruction(TWO, "{0}", "({0})((unsigned {0}){1} << {2})"),
    "lshr": _Instruction(TWO, "{0}", "({0})((unsigned {0}){1} >> {2})"),
    "bitcast": _Instruction(CAST, "{1}", "same_bits({0})"),
    "select": _Instruction(r"i1 (\S+), (\w+) (\S+), \w+ (\S+)", "{1}", "{0} ? {2} : {3}"),
    "load": _Instruction(r"(\w+), ptr (\S+), align \d+", "{0}", "*({0} *){1}"),
    "store": _Instruction(r"(\w+) (\S+), ptr (\S+), align \d+", "", "*({0} *){2} = {1}"),
    "getelementptr": _Instruction(
        r"(?:\[(\d+) x )?(\w+)\]?, ptr (\S+), i64 (\S+)", "char *", "{2} + (long long)sizeof({1}) * {0} * {3}"
    ),
    "extractvalue": _Instruction(r"pair (\S+), ([01])", "double", "{0}.part[{1}]"),
    "insertvalue": _Instruction(r"pair (\S+), double (\S+), ([01])", "Pair", "with_part({0}, {1}, {2})"),
    "atomicrmw": _Instruction(r"add ptr (\S+), i64 (\S+) monotonic", "long long", "fetch_and_add({0}, {1})"),
    "unreachable": _Instruction("", "", ""),
    "ret": _Instruction(r"\w+ ?(\S*)", "", "return {0}"),
}

HEAD = """\
struct Pair { double part[2]; };
__device__ static Pair with_part(Pair pair, double value, int place) { pair.part[place] = value; return pair; }
__device__ static long long same_bits(double x) { return __double_as_longlong(x); }
__device__ static double same_bits(long long x) { return __longlong_as_double(x); }
__device__ static long long fetch_and_add(char *x, long long n) { return atomicAdd((unsigned long long *)x, n); }
"""


def translated(text: str) -> str:
    """Return the functions of a module as CUDA C; those that others call stay apart, which leaves more registers."""
    functions = re.findall(
        r"^define (\w+) @(\w+)\((.*?)\).*?\n(.*?)^\}",
        text.replace("{double, double}", "pair"),
        re.MULTILINE | re.DOTALL,
    )
    heads = [
        f"__device__ {'__noinline__ ' * (text.count(f'@{name}(') > 1)}static {TYPES[kind]} {name}({_declared(given)})"
        for kind, name, given, _ in functions
    ]
    bodies = [_Body(body) for *_, body in functions]
    return HEAD + "\n".join([*(f"{head};" for head in heads), *map("{} {}".format, heads, bodies)])


def _declared(arguments: str) -> str:
    return ", ".join(f"{TYPES[kind]} {name}" for kind, name in re.findall(r"(\w+) %(\w+)", arguments))


def _word(word: str | None) -> str:
    """Return a type, a relation, a variable or a number in C; what is left out is 1."""
    if word is None:
        return "1"
    if word in WORDS:
        return WORDS[word]
    if word.startswith("%"):
        return word[1:]
    if not word.startswith("0x"):
        return f"({int(word)}LL)"
    (number,) = struct.unpack("<d", bytes.fromhex(word[2:])[::-1])
    return f"({number!r})" if abs(number) < float("inf") else f"same_bits((long long){word}ULL)"


class _Body:
    """The lines of a function, with its variables declared first: no goto may pass over a declaration."""

    def __init__(self, body: str) -> None:
        self._kinds: dict[str, str] = {}
        self._handed: dict[tuple[str, str], list[str]] = {}
        blocks = re.findall(r"^(\w+):\n(.*?)(?=^\w+:|\Z)", body, re.MULTILINE | re.DOTALL)
        taken = {label: self._taken(label, lines) for label, lines in blocks}
        self._lines: list[str] = []
        for label, lines in blocks:
            self._lines += [f"{label}:;", *taken[label]]
            self._lines += [self._line(label, line) for line in lines.splitlines() if " = phi " not in line]

    def _taken(self, label: str, lines: str) -> list[str]:
        """Return what a block begins with: it takes what the block before it hands over."""
        taken = re.findall(r"%(\w+) = phi (\w+) (.*)", lines)
        for name, kind, values in taken:
            self._kinds |= {name: TYPES[kind], f"{name}n": TYPES[kind]}
            for value, before in re.findall(r"\[(\S+), %(\w+)\]", values):
                self._handed.setdefault((before, label), []).append(f"{name}n = {_word(value)};")
        return [f"{name} = {name}n;" for name, *_ in taken]

    def _line(self, label: str, line: str) -> str:
        """Return an instruction, and store the type of its result."""
        own, _, rest = line.rpartition(" = ")
        name, _, rest = rest.partition(" ")
        if name == "br":
            return self._branch(label, rest)
        if name == "call":
            kind, text = _call(rest)
        else:
            instruction = INSTRUCTIONS[name]
            groups = [_word(group) for group in _matched(instruction.pattern, rest)]
            kind, text = instruction.kind.format(*groups), instruction.text.format(*groups)
        if not own:
            return f"{text};"
        self._kinds[own[1:]] = kind
        return f"{own[1:]} = {text};"

    def _branch(self, label: str, rest: str) -> str:
        ways = [
            " ".join(["{", *self._handed.get((label, target), ()), f"goto {target};", "}"])
            for target in re.findall(r"label %(\w+)", rest)
        ]
        condition = re.match(r"i1 %(\w+)", rest)
        return f"if ({condition[1]}) {ways[0]} else {ways[1]}" if condition else ways[0]

    def __str__(self) -> str:
        return "\n".join(["{", *(f"{kind} {name};" for name, kind in self._kinds.items()), *self._lines, "}"])


def _call(rest: str) -> tuple[str, str]:
    """Return the type of a call and its text; intrinsics of LLVM have the names of C."""
    kind, name, arguments = _matched(r"(\w+) @(?:llvm\.)?(\w+)(?:\.f64)?\((.*)\)", rest)
    return TYPES[kind], f"{name}({', '.join(_word(argument.split(' ')[-1]) for argument in arguments.split(', '))})"


def _matched(pattern: str, text: str) -> tuple[str, ...]:
    found = re.match(pattern, text)
    if found is None:
        raise ValueError(f"an instruction must have a translation, got {quoted(text)}.")
    return found.groups()
