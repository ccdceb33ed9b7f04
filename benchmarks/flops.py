"""Floating-point operations of a Taylor step, counted from its decomposition, and the peak of a core."""

import ctypes
import re
import time

RULE = (
    "An entry of the decomposition is counted at the orders 0 to p - 1 at which a step of order p needs it. At order n "
    "a product of two variables takes n + 1 multiplications and n additions, a square about half of that, a product "
    "with a number or a parameter one multiplication, a sum or difference one addition, a quotient n multiplications, "
    "n additions and one division, a power with a fixed exponent 2 n multiplications, n additions and one division, a "
    "sine or cosine 2 n multiplications, n - 1 additions and one division. A change of sign counts nothing, a division "
    "or an elementary function at order 0 counts one. Each variable of the state takes p divisions by the order, p "
    "multiplications and p additions for the sum of its polynomial. The choice of the step is not counted."
)
VARIABLE = re.compile(r"u_\d+|x\d+")
NUMBER = re.compile(r"p\d+|-?\d[\d.e+-]*")
SHAPES = (
    ("difference", re.compile(r"sub\((\S+), (\S+)\)")),
    ("quotient", re.compile(r"div\((\S+), (\S+)\)")),
    ("product", re.compile(r"\((\S+) \* (\S+)\)")),
    ("sum", re.compile(r"\((\S+) \+ (\S+)\)")),
    ("difference", re.compile(r"\((\S+) - (\S+)\)")),
    ("power", re.compile(r"(\S+)\*\*(\S+)")),
    ("wave", re.compile(r"(?:combined_)?(?:sin|cos)\((\S+)\)")),
    ("free", re.compile(r"-u_\d+|t")),
)


def flops_per_step(engine):
    """Return the operations of one step of one lane, how many could pair up, and the size of its table."""
    size, order = len(engine.state), engine.order
    entries = [str(entry[0]) for entry in engine.decomposition][size:-size]
    totals = [0, 0, 0]
    for entry in entries:
        for n in range(order):
            totals = [total + more for total, more in zip(totals, _at_order(entry, n), strict=True)]
    multiplications, additions, divisions = totals
    multiplications, additions = multiplications + size * order, additions + size * order
    divisions += size * order
    paired = _paired(entries, order) + size * order
    flops = multiplications + additions + divisions
    return {
        "flops": flops,
        "divisions": divisions,
        "instructions": flops - paired,
        "order": order,
        "entries": len(entries),
        "table_bytes": (len(entries) * order + size * (order + 1)) * engine.batch_size * 8,
        "rule": RULE,
    }


def _at_order(entry, n):
    """Return multiplications, additions and divisions of an entry at one order."""
    shape, operands = _shape(entry)
    if shape == "product":
        if not all(map(VARIABLE.fullmatch, operands)):
            return 1, 0, 0
        return (n // 2 + 1 + n % 2, n // 2, 0) if operands[0] == operands[1] else (n + 1, n, 0)
    if shape in ("sum", "difference"):
        constant = any(map(NUMBER.fullmatch, operands))
        return 0, int(n == 0 or not constant), 0
    return {
        "quotient": (n, n, 1),
        "power": (2 * n, n, 1),
        "wave": (2 * n, max(n - 1, 0), 1),
        "free": (0, 0, 0),
    }[shape]


def _paired(entries, order):
    """Return how many additions follow a multiplication whose result goes nowhere else."""
    return sum(
        _at_order(entry, n)[1]
        for entry in entries
        if _shape(entry)[0] in ("product", "quotient", "power", "wave")
        for n in range(order)
    )


def _shape(entry):
    for name, pattern in SHAPES:
        match = pattern.fullmatch(entry)
        if match:
            return name, match.groups()
    raise ValueError(f"the count must know every entry of a decomposition, got {entry!r}.")


ACCUMULATORS, ROUNDS = 16, 20_000_000


def multiply_add_peak():
    """Return a function that measures multiply-add operations per second of one core; None without llvmlite.

    A loop of independent multiply-adds on the widest vectors of doubles, in registers only, compiled by LLVM.
    """
    try:
        import llvmlite.binding as llvm
    except (ImportError, OSError):
        return None
    from poinsot.engine.kernels import LANES

    lanes = max(LANES, 2)
    llvm.initialize_native_target()
    llvm.initialize_native_asmprinter()
    module = llvm.parse_assembly(_loop(lanes))
    target = llvm.Target.from_default_triple()
    features = llvm.get_host_cpu_features().flatten()
    machine = target.create_target_machine(cpu=llvm.get_host_cpu_name(), features=features, opt=3)
    compiled = llvm.create_mcjit_compiler(module, machine)
    compiled.finalize_object()
    loop = ctypes.CFUNCTYPE(ctypes.c_double, ctypes.c_int64)(compiled.get_function_address("peak"))

    def measure(_alive=compiled):
        began = time.perf_counter()
        loop(ROUNDS // ACCUMULATORS)
        return 2 * lanes * (ROUNDS // ACCUMULATORS) * ACCUMULATORS / (time.perf_counter() - began)

    return measure


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
