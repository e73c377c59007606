"""Measures of a comparison: pure functions on arrays over problems p, algorithms a, seeds s and targets t.

A running time is that of a run to a target, in evaluations or seconds: infinite where it was not reached, NaN without
a run. Where runs are too few or too similar for a result, it is NaN.
"""
