"""Measures of a comparison: pure functions on arrays over problems p, algorithms a, seeds s and targets t.

A running time is what a run needed to reach a target, in evaluations or seconds: infinite where it did not, NaN where
there is no such run. Where runs are too few or too much alike to say anything, the answer is NaN.
"""
