"""Compiler of Taylor integrators: formulas on a graph become machine code that integrates them. It knows no bodies."""
