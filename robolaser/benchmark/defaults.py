"""Defaults of a benchmark: seeds, budget and limits of a run."""

SEEDS = 15
"""With 15 seeds an A12 of 0.87 is significant after correction for all pairs of a dozen solvers."""
BUDGET = 20_000
"""Evaluations of a run: solvers that solve the paper's problem at all have mostly solved it by then."""
TIME_LIMIT_S = 300.0
MEMORY_LIMIT_B = 2_000_000_000
