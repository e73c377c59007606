"""On what terms runs are made where nothing else is said."""

SEEDS = 15
"""With so many, an A12 of 0.87 is told from chance among all pairs of a dozen contestants."""
BUDGET = 20_000
"""Evaluations: those that solve the paper's problem at all have mostly solved it by then."""
TIME_LIMIT_S = 300.0
MEMORY_LIMIT_B = 2_000_000_000
