"""The integrator: variables, compiled kernels, event detection, variational equations and the runs."""
