"""Every threshold that decides what a diagnosis says: its value, its unit, and where it comes from.

"chi-squared" is the sum of squares of whitened residuals and of the parameters' distances from their priors: noise
alone contributes 1 for each residual. A threshold is a quantile of a distribution, or a simulation's, or a judgement:
what does not say where it comes from is a judgement of how much to try. What a factor of 0.5 and 2 changes on a blind
trial stands in `benchmarks/thresholds/`, and so does the list of all other numbers of the diagnosis.
"""

from statistics import NormalDist
from typing import Final

# What an effect must explain before it enters the model.

CHI2_PER_EFFECT: Final = 16.0
"""Chi-squared that any effect must explain, and a function of unknown form at a joint as well; and twice the logarithm
of the likelihood ratio from which on a gap is at a site; and by which an alternative may fit worse and still count as
indistinguishable. Quantiles: among a hundred candidates of one parameter, chance reaches it once in 158 data sets, and
among a hundred coordinates once in 316 (the half chi-squared distribution, Self and Liang 1987). With half of it one
more of six blind worlds is not right, with twice as much none."""
CHI2_PER_PARAMETER: Final = 4.5
"""The same for each of its parameters. Chance gains 1 for each on average, and the largest of many chances more. A
judgement: with half of it two of six blind worlds have a wrong name for certain, with twice as much none."""
FULLY_PENALIZED: Final = 6
"""Number of parameters up to which each costs that much: those of a rigid motion."""
CHI2_PER_FURTHER_PARAMETER: Final = 1.5
"""Chi-squared for each parameter beyond those: that all of many gain more than their share by chance is ever less
likely. A judgement: at the full price a warped target and a sagging bracket, of 22 and 7 numbers, are no longer found
on three of 258 data sets."""

# The search over sets of effects.

MOST_RMS_M: Final = 0.1
"""Error of fitted points above which no effect is searched for [m]: a shoulder's zero on its bound, 0.1 rad, leaves
0.08 m on a UR10; rows at the pose after theirs leave more."""

SHARE_OF_BEST_SCORE: Final = 0.75
"""Share of the best score, or of what an effect explains, that a candidate must promise to be refitted: scores are
linear, and may be a quarter off."""
MIN_IMPROVEMENT: Final = 1e-3
"""Change of the cost, in chi-squared, below which two models cost the same."""
MOST_CAUSES: Final = 4
"""Effects up to which exchanges are tried, and beside the geometry of a whole arm; sites that a gap is divided among.
With more, the library makes do without the cause. Eight beside the geometry take twice the time."""
MAX_EFFECTS: Final = 8
"""Effects in a model, but for those of an arm."""
REFITS: Final = 2
"""Effects, best score first, that are refitted before one is added, or takes the place of one that is taken out."""
PLACEMENTS_OF_AN_ARM: Final = 3
"""Link placements, from which on they stand for the geometry of a whole arm, and effects, from which on that geometry
is tried: errors of several joints hide each other. A judgement: a maker's tolerances are off at every joint, a damaged
arm at one or two."""
NO_DIFFERENCE: Final = 1.1
"""Factor, either way, within which two sizes count as the same: of noise that a model leaves and that was assumed, else
the search starts again; of a held-out gap and the noise floor, where a remainder may be an effect's form. A judgement:
with 2.2 three data sets that scatter by 1 mrad have no gap."""
ROUNDS: Final = 4
"""Times that it starts again for that, and that gross errors are looked for again once effects are in the model."""
ONE_MEASUREMENT: Final = 0.1
"""Scatter of a pose's rows over stated noise, below which they were made from one measurement: reflectors computed from
one 6-D pose agree to their last digit, 1e-3 to 2e-2 on two real campaigns. A judgement, of words alone."""

# Noise.

MOTIONS_PER_PARAMETER: Final = 2
"""Independent motions of poses for each parameter, below which the whole library is not tried when the scatter of whole
poses is first estimated: it would explain anything. A judgement."""

# An unmodelled cause: a smooth function of unknown form at some site.

CHI2_OF_UNMODELLED_CAUSE: Final = 12.0
"""Chi-squared that a cause outside the library costs. A prior: odds of 1 to 400. With 6 or 24 no answer changes on six
blind worlds; 4 no longer finds some weak true causes, and -12 loses 5 of 18."""
SMOOTH: Final = 0.35
"""Length over which a smooth function keeps its value, as a share of its coordinate's range. A judgement."""
SMOOTH_POSTURE: Final = 0.6
"""The same for functions of all joints at once, of the posture's spread. A judgement: with 0.35 a compliance, too rough
for such a function, leaves a part of itself to an eccentricity of its joint."""
SMOOTH_LOAD: Final = 2.0
"""The same for loads: a force at the flange, of the extent of the flange's positions, since a cable fixed far away
pulls nearly alike everywhere; the direction of gravity in the flange and the overturning moment, of their ranges, since
what yields does so nearly in proportion. A judgement: 1 and 4 change twice the log-likelihood of seven cables by 25 at
most."""
ROUGH: Final = 0.25
"""The same for functions with corners, which may be anything at a joint. A judgement: with 0.35 a ramp over a tenth of
the range is a tenth off, with 0.5 twice the log-likelihood of twelve blind worlds changes by 20 at most, and by 4 where
a joint has a dead zone."""
FLAT: Final = 0.05
"""Range of one coordinate over the largest, below which it is not stretched: a flat target's height is its noise. A
judgement."""
DENT: Final = 0.08
"""The same for dents in a target, as a share of its extent. A judgement."""
MAX_DISTORTION_PX: Final = 0.1
"""Largest plausible distortion of a lens beyond the model's, as a standard deviation over the image. A judgement:
without a limit, scatter of a camera's poses by 0.1 mrad is reported as a gap in its lens."""

# How sure an effect is, and what else it may be.

MAX_ALTERNATIVES: Final = 6
"""Candidates that are refitted in an effect's place, and reported."""
SMALL_SHARE: Final = 0.05
"""Share of what an effect explains: left unexplained it halves the effect's credibility. A judgement, set by
blind trials."""

LARGEST_PLAUSIBLE: Final = 10.0
"""Largest plausible size of an effect, in units of those usual in industry. A judgement; a joint's zero may be off by
1°."""

LARGEST_USUAL: Final = 3.0
"""Size of the errors of an arm that was never calibrated, in units of those usual in industry. A judgement."""

# Standard errors.

SIGMA_OF_95_PERCENT: Final = NormalDist().inv_cdf(0.975)
"""Standard deviations on either side that hold 95 % of a normal distribution."""

# Classes of causes.

CREDIBLE_MASS: Final = 0.95
"""Probability that one of a credible set's members is at work. A convention (Wang et al. 2020)."""
LEAST_PROBABILITY: Final = 0.01
"""Probability, below which a class or an effect is not reported: its class stands for an effect."""

# The verdict.

NO_NOISE: Final = 2.0
"""Ratio of an error to that expected from noise, from which on it is not noise: the root mean square of whitened rows,
to that expected from their median; the squares of a fit's residuals, to those of the noise estimated from them, where
the search ended in a lesser optimum; a held-out gap, to its noise floor. A judgement: of rows it is 1.08 at most on 84
data sets, and 2.5 where a reflector slips by ten times the noise; of gaps it is below 1.5 in blind worlds whose effects
are all known, and 5 for a real scanner with a remainder of unknown cause."""
MOST_OVER_STATED: Final = 3.0
"""Size of rows' noise that residuals give over the stated one, from which on it is no noise. A judgement: in blind
worlds it is 2.6 at most; a rolling shutter makes it 3.4, a tracked body whose angles are biased by where it is seen
from 5, a slipped reflector, half of it reported as a moved base, 20."""
LEAST_TYPICAL: Final = 0.25
"""What that median is at least: rows without noise are left to rounding."""
OPEN_SHARE: Final = 0.005
"""Share of the squared gap above the noise, up to which a remainder may be an effect's form, too, where the noise is so
small beside the gap that any other form shows. A judgement: of twelve blind worlds with a remainder, two true effects
each left 0.0004 and 0.002, causes outside the library 0.012 and more."""
FORM_SHARE: Final = 0.02
"""Share of what the effects explain, up to which a remainder counts as their form being a little different."""
