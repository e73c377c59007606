"""Blind trials: data sets whose faults are sealed, and the score of a diagnosis on them."""
