"""Optimisers side by side on the same problems: who is better, by how much, and how sure is that?"""

SEEDS = 15  # with 15 seeds an A12 of 0.87 is significant after correction for all pairs of a dozen solvers
BUDGET = 20_000  # evaluations of a run: solvers that solve the paper's problem at all have mostly solved it by then
TIME_LIMIT_S = 300.0
