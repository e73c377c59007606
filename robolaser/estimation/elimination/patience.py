"""When steps downhill are taken, damped and ended: alike in the compiled loops and in NumPy."""

STEPS = 120  # three are usual
PIVOTS = 6  # rounds of deciding which variables stand on a bound, more than there are variables
CALM = 1e-14  # of a problem's size: sums of squares of that size differ by this from one rounding to the next
DONE = 1e-16  # of the same: a step that promises less is taken without a look, and is the last
WORTH = 1e-3  # of what a step promised, it must hold at least
FIRST = 0.1  # damping once a step has failed, in units of the curvature's diagonal
FIRM, LOOSE = 3.0, 0.03  # what the damping is multiplied by after a step that failed, and after one that did not
HOPELESS = 1e9  # damping at which steps no longer move anything
WIDE = 1.0  # bounds of an angle farther apart than this [rad] have more than one start
