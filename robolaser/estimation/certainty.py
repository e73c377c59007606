"""Probabilities that decide what a diagnosis reports, and how firmly."""

from typing import Final

EVEN: Final = 0.5
"""Probability below which a class is no more than possible; of an unmodelled cause instead of an effect, above which
the effect is not named; before any data, that an arm has no further effects. And half of a whole: of the remaining
error, which one effect must explain to be no scatter; of the information on a direction, which must be from the data;
of the noise, above which scatter is reported; of the prior's standard deviation, above which the data do not determine
a parameter (of two with a known sum, each keeps 0.71); of another campaign's gap, which must close to carry over; and
the power of the range with which noise must grow to be reported."""
CERTAIN: Final = 0.9
"""Probability above which an effect or a class is reported as a cause. A judgement: blind trials count how often such
names are right."""
LIKELY: Final = 0.5 * (0.5 + CERTAIN)
"""Largest probability of an explanation that does not predict new poses certainly better than its alternative, or that
leaves a multiple of the noise of torques: likely, and no more."""
