"""The package itself: one call of `propagate`, all of it timed."""

import poinsot as pt

SOLVES = ("free", "top", "satellite")
LEVELS = (1e-6, 1e-8, 1e-10, 1e-12, 1e-13, 1e-14, None)
SHORT_LEVELS = (1e-8, 1e-12, None)


def prepare(problem, level, formulation=None):
    """Return one propagation; None is the default tolerance."""

    def run():
        motion = pt.propagate(
            problem.system, problem.start, [0.0, problem.end], tolerance=level, formulation=formulation
        )
        return motion.quaternion[-1], problem.end

    return run
