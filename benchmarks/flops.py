"""Floating-point operations of a Taylor step, counted from a decomposition, and the peak of a core."""

import ctypes
import re
import time

from benchmarks import problems
from benchmarks.peers import heyoka_by_hand

RULE = (
    "An entry of the decomposition is counted at the orders 0 to p - 1 at which a step of order p needs it. At order n "
    "a product of two variables takes n + 1 multiplications and n additions, a square about half of that, a product "
    "with a number one multiplication, a sum or difference one addition, a quotient n multiplications, n additions and "
    "one division, a power with another exponent 2 n multiplications, n additions and one division, a sine, a cosine "
    "or Kepler's equation 2 n multiplications, n - 1 additions and one division. A change of sign counts nothing, an "
    "elementary function at order 0 counts one division. Each variable of the state takes p divisions by the order, p "
    "multiplications and p additions for the sum of its polynomial. The choice of the step is not counted."
)
NUMBER = re.compile(r"-?\d[\d.e+-]*")
SHAPES = (
    ("difference", re.compile(r"sub\((\S+), (\S+)\)")),
    ("quotient", re.compile(r"div\((\S+), (\S+)\)")),
    ("squares", re.compile(r"\((\S+)\*\*2 \+ (\S+)\*\*2\)")),
    ("product", re.compile(r"\((\S+) \* (\S+)\)")),
    ("sum", re.compile(r"\((\S+) \+ (\S+)\)")),
    ("difference", re.compile(r"\((\S+) - (\S+)\)")),
    ("square", re.compile(r"(\S+)\*\*2\.0+")),
    ("power", re.compile(r"(\S+)\*\*(\S+)")),
    ("wave", re.compile(r"combined_(?:sin|cos)\((\S+)\)|kepE\((\S+), (\S+)\)")),
    ("free", re.compile(r"-u_\d+|t")),
)
WITH_PRODUCTS = ("product", "square", "squares", "quotient", "power", "wave")


def of_motion(problem, tolerance):
    """Return the operations and instructions of the fastest script per unit of time of a motion, at a tolerance.

    Every tool is credited with this work for the same motion, however much it does.
    """
    name = heyoka_by_hand.fastest(problem.key)
    engine, writing = (
        heyoka_by_hand.integrator(problem.key, name, tolerance),
        heyoka_by_hand.WRITINGS[problem.kind][name],
    )
    engine.time, engine.state[:] = 0.0, writing.start(problem.initial)
    end = min(problem.end, 20 * problems.PERIOD)
    steps = engine.propagate_until(end)[3]
    step = of_a_step(engine)
    per_time = {f"{key}_per_time": step[key] * steps / end for key in ("flops", "instructions")}
    return {"writing": name, "end": problem.end, "rule": RULE, **step, **per_time}


def of_a_step(engine):
    """Return the operations of one step of one lane, and how many instructions they need if all pair up that can."""
    size, order = len(engine.state), engine.order
    multiplications = additions = divisions = size * order
    paired = size * order
    for entry, _ in engine.decomposition[size:-size]:
        shape, operands = _shape(str(entry))
        for n in range(order):
            times, plus, over = _at_order(shape, operands, n)
            multiplications, additions, divisions = multiplications + times, additions + plus, divisions + over
            paired += plus if shape in WITH_PRODUCTS else 0
    flops = multiplications + additions + divisions
    return {"flops": flops, "instructions": flops - paired, "order": order}


def _at_order(shape, operands, n):
    """Return multiplications, additions and divisions of an entry at one order."""
    numbers = any(operand and NUMBER.fullmatch(operand) for operand in operands)
    half = n // 2
    if shape == "product":
        return (1, 0, 0) if numbers else (n + 1, n, 0)
    if shape in ("sum", "difference"):
        return 0, int(n == 0 or not numbers), 0
    return {
        "square": (half + 1 + n % 2, half, 0),
        "squares": (2 * (half + 1 + n % 2), 2 * half + 1, 0),
        "quotient": (n, n, 1),
        "power": (2 * n, n, 1),
        "wave": (2 * n, max(n - 1, 0), 1),
        "free": (0, 0, 0),
    }[shape]


def _shape(entry):
    for name, pattern in SHAPES:
        match = pattern.fullmatch(entry)
        if match:
            return name, match.groups()
    raise ValueError(f"the count must know every entry of a decomposition, got {entry!r}.")


ACCUMULATORS, ROUNDS = 16, 20_000_000


def peak():
    """Return the most multiply-add operations per second of one core, two each; None without llvmlite.

    A loop of independent multiply-adds on the widest vectors of doubles, in registers only, compiled by LLVM.
    """
    try:
        import llvmlite.binding as llvm
    except (ImportError, OSError):
        return None
    llvm.initialize_native_target()
    llvm.initialize_native_asmprinter()
    target, features = llvm.Target.from_default_triple(), llvm.get_host_cpu_features()
    lanes = 8 if features.get("avx512f") else 4 if features.get("avx") else 2
    machine = target.create_target_machine(cpu=llvm.get_host_cpu_name(), features=features.flatten(), opt=3)
    compiled = llvm.create_mcjit_compiler(llvm.parse_assembly(_loop(lanes)), machine)
    compiled.finalize_object()
    loop = ctypes.CFUNCTYPE(ctypes.c_double, ctypes.c_int64)(compiled.get_function_address("peak"))
    rates = []
    for _ in range(9):
        began = time.process_time()
        loop(ROUNDS // ACCUMULATORS)
        rates.append(2 * lanes * (ROUNDS // ACCUMULATORS) * ACCUMULATORS / (time.process_time() - began))
    return max(rates)


def _loop(lanes):
    """Return the loop in LLVM's language: accumulator = accumulator * factor + term, many side by side."""
    vector, many = f"<{lanes} x double>", range(ACCUMULATORS)
    names = "\n".join(f"  %a{k} = phi {vector} [ %s{k}, %start ], [ %b{k}, %loop ]" for k in many)
    fma = f"call {vector} @llvm.fma.v{lanes}f64"
    body = "\n".join(f"  %b{k} = {fma}({vector} %a{k}, {vector} %factor, {vector} %factor)" for k in many)
    starts = "\n".join(f"  %s{k} = insertelement {vector} %factor, double {k}.5, i32 0" for k in many)
    sums = "\n".join(f"  %t{k + 1} = fadd {vector} %t{k}, %b{k}" for k in many)
    bits = 64 * lanes
    return f"""
declare {vector} @llvm.fma.v{lanes}f64({vector}, {vector}, {vector})
define double @peak(i64 %rounds) #0 {{
start:
  %real = sitofp i64 %rounds to double
  %small = fdiv double 0.5, %real
  %seed = insertelement {vector} undef, double %small, i32 0
  %factor = shufflevector {vector} %seed, {vector} undef, <{lanes} x i32> zeroinitializer
{starts}
  br label %loop
loop:
  %i = phi i64 [ 0, %start ], [ %next, %loop ]
{names}
{body}
  %next = add i64 %i, 1
  %again = icmp slt i64 %next, %rounds
  br i1 %again, label %loop, label %end
end:
  %t0 = fadd {vector} %factor, %factor
{sums}
  %out = extractelement {vector} %t{ACCUMULATORS}, i32 0
  ret double %out
}}
attributes #0 = {{ "prefer-vector-width"="{bits}" "min-legal-vector-width"="{bits}" }}
"""
