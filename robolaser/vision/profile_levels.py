"""What the compiled loops over a stripe's profile and their twins in NumPy have in common."""

FULL = 255
"""Grey at which a pixel says no more than that it was at least as bright."""
LEVEL = 0.6
"""Height, from background (0) to peak (1), above which light counts: on the steep flanks, above the halo."""
FOOT = 0.3
"""Height at which a second middle is taken; how far it lies off tells a lopsided profile."""
LEAST_TOLD = 0.1
"""Squared distances of pixels from the middle [px²] that a middle hangs on, at least."""
STEPS = 4
"""Gauss-Newton steps of a bell; the start is good to a tenth of the width."""
DAMPING = 1e-3
"""Added to the normal equations' diagonal while stepping, as a share."""
SETTLED = 1e-9
"""Added always, so that the equations have a solution where pixels tell nothing."""
STILL = 1e-3
"""Step of middle and breadth, in breadths, after which no further one is worth while."""
LONGEST = (-0.4, 0.6)
"""Steps of the bell's breadth at most, as shares; its middle moves by less than one breadth."""
FEWEST = 7
"""Pixels that are needed for a bell's five unknowns."""
