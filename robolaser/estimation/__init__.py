"""Least squares: the problem, its solver, and how well its parameters are known."""
