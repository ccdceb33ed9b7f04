"""Decompositions evaluated one operation after another, with NumPy's functions: values of order zero."""

import numpy as np

from poinsot import functions
from poinsot.taylor.decomposition import Coefficient
from poinsot.taylor.graph import Evaluator


def rates(program, states, numbers):
    """Return the time derivatives of the states for the numbers of a run."""
    given = _Values(states, Evaluator(program.parameters, np.float64)(numbers))
    for operation in program.decomposition.operations:
        given.known.append(getattr(given, type(operation).__name__)(*operation))
    return [given.of(rate) for rate in program.decomposition.rates]


class _Values:
    """Values of operations; each kind of these has the method of its name."""

    def __init__(self, states, parameters):
        self.known, self.states, self.parameters = [], states, parameters

    def of(self, operand):
        """Return the value of a coefficient or of an operation."""
        if not isinstance(operand, Coefficient):
            return self.known[operand]
        return float(operand.number) * (1.0 if operand.parameter is None else self.parameters[operand.parameter])

    def Variable(self, place):
        return self.states[place]

    def Sum(self, terms, constants):
        return sum(self.of(c) * self.known[k] for c, k in terms) + sum(map(self.of, constants))

    def Product(self, first, second):
        return self.known[first] * self.known[second]

    def Quotient(self, numerator, denominator):
        return self.of(numerator) / self.known[denominator]

    def Select(self, condition, first, second):
        return self.of(first) if self.parameters[condition] else self.of(second)

    def Invariant(self, roots):
        return sum(self.known[root] ** 2 for root in roots)

    def Function(self, name, arguments, _):
        function = np.power if name == "pow" else getattr(functions, name)
        return function(*map(self.of, arguments))
