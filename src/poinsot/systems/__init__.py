"""Systems of bodies, forces and parts: dynamics, integrals, trials and symbols of formulas, checks of times."""
