"""Synthetic cells, independent of the effect library: their own kinematic chain and forms of faults."""
