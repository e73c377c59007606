"""Probabilities from which on something is said, and how."""

from typing import Final

EVEN: Final = 0.5
"""Probability, below which a class is no more than possible; of an unmodelled cause in an effect's place, above which
the effect is not named; before any data, that an arm has no effects but those found. And half of a whole: of what is
left, which one effect must explain to be no scatter; of what is known of a direction, which must be from the data; of
the noise, from which on scatter is worth saying; of the prior's standard deviation, from which on the data do not
determine a parameter (of two of which they see the sum, each keeps 0.71); of another campaign's gap, which must close
to carry over; and the power of the range with which noise must grow to be worth a remark."""
CERTAIN: Final = 0.9
"""Probability, from which on an effect or a class is said to be a cause. A judgement: blind trials count how often such
names are right."""
LIKELY: Final = 0.5 * (0.5 + CERTAIN)
"""Most that an explanation is given where it does not predict new poses certainly better than its rival, or where a
multiple of the noise is left of torques: likely, and no more."""
