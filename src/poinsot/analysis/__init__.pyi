"""The public names of poinsot.analysis, by the module of each, as `make face` writes them."""

from .chaos import ChaosIndicators, LyapunovSpectrum, chaos_indicators, lyapunov_spectrum
from .continuation import Bifurcation, Branch, continue_motion
from .equilibrium import Equilibrium, equilibria
from .free_rotation import FreeRotation
from .libration import Librations, librations
from .line_combinations import LineIdentification, identify_lines
from .line_spectrum import LineSpectrum, diffusion, frequencies
from .mutual_orbit import Revolutions, apsidal_precession, revolutions
from .pair_equilibrium import PairEquilibrium, pair_equilibria
from .periodic import CassiniState, PeriodicMotion, cassini_state, periodic_motion
from .reading_partials import ObservedPartials, observed_partials
from .relaxation import InelasticRelaxation
from .run_estimate import RunEstimate, estimate_run
from .sections import Section, andoyer_section, section, spin_orbit_section
from .secular import SecularEvolution, secular_evolution
from .transition_matrix import StateTransition, state_transition
from .yorp import YorpCoefficients, yorp_coefficients

__all__ = [
    "Bifurcation",
    "Branch",
    "CassiniState",
    "ChaosIndicators",
    "Equilibrium",
    "FreeRotation",
    "InelasticRelaxation",
    "Librations",
    "LineIdentification",
    "LineSpectrum",
    "LyapunovSpectrum",
    "ObservedPartials",
    "PairEquilibrium",
    "PeriodicMotion",
    "Revolutions",
    "RunEstimate",
    "Section",
    "SecularEvolution",
    "StateTransition",
    "YorpCoefficients",
    "andoyer_section",
    "apsidal_precession",
    "cassini_state",
    "chaos_indicators",
    "continue_motion",
    "diffusion",
    "equilibria",
    "estimate_run",
    "frequencies",
    "identify_lines",
    "librations",
    "lyapunov_spectrum",
    "observed_partials",
    "pair_equilibria",
    "periodic_motion",
    "revolutions",
    "section",
    "secular_evolution",
    "spin_orbit_section",
    "state_transition",
    "yorp_coefficients",
]
