"""Comparison of optimisers on the same problems: which is better, by how much, and with which certainty."""

SEEDS = 15  # with 15 seeds an A12 of 0.87 is significant after correction for all pairs of a dozen solvers
BUDGET = 20_000  # evaluations of a run: most solvers that solve the paper's problem at all need fewer
TIME_LIMIT_S = 300.0
