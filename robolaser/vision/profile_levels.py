"""What the compiled loops over a stripe's profile and their twins in NumPy have in common."""

FULL = 255  # grey of a saturated pixel: it was at least as bright
LEVEL = 0.6  # height, from background (0) to peak (1), above which light counts: on the steep flanks, above the halo
FOOT = 0.3  # height at which a second centre is taken; its distance from the other shows an asymmetric profile
LEAST_SECOND_MOMENT = 0.1  # sum of squared distances of pixels from the centre [px²], at least
STEPS = 4  # Gauss-Newton steps of a Gaussian fit; the start is good to a tenth of the width
DAMPING = 1e-3  # added to the normal equations' diagonal while stepping, as a share
SETTLED = 1e-9  # added always, so that the equations have a solution where pixels carry no information
STILL = 1e-3  # change of centre and breadth, in breadths, below which a fit has converged
LONGEST = (-0.4, 0.6)  # steps of the Gaussian's breadth at most, as shares; its centre moves by less than one breadth
FEWEST = 7  # pixels that are needed for a Gaussian's five unknowns
