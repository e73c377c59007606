"""All thresholds of the diagnosis, each with its value, unit and source.

"chi-squared" is the sum of squares of whitened residuals and of the parameters' distances from their priors: noise
alone contributes 1 for each residual. The source is a quantile of a distribution, a simulation or a judgement; a
threshold without a source is a judgement of how much to try. `benchmarks/thresholds/` has the effects of factors of 0.5
and 2 on a blind trial, and a list of all other numbers of the diagnosis.
"""

from statistics import NormalDist
from typing import Final

# Chi-squared that an effect must explain to enter the model.

CHI2_PER_EFFECT: Final = 16.0
"""Chi-squared that any effect must explain, and a function of unknown form at a joint as well; also the least value of
twice the logarithm of the likelihood ratio for a site of a gap, and the largest difference in chi-squared of an
indistinguishable alternative. Quantiles: among a hundred candidates of one parameter, chance reaches it once in 158
data sets, and among a hundred coordinates once in 316 (the half chi-squared distribution, Self and Liang 1987). With
half of it one more of six blind worlds is not right, with twice as much none."""
CHI2_PER_PARAMETER: Final = 4.5
"""Further chi-squared for each of its parameters. Chance gains 1 for each on average, the best of many candidates more.
A judgement: with half of it two of six blind worlds give a wrong name as certain, with twice as much none."""
CHI2_PER_FURTHER_PARAMETER: Final = 1.5
"""Chi-squared for each parameter beyond the six of a rigid motion: the more parameters, the less likely all gain more
than their share by chance. A judgement: with the full penalty a warped target and a sagging bracket, of 22 and 7
parameters, are no longer found on three of 258 data sets."""

SEEN: Final = 1e-3
"""Share of a squared length or variance, relative to the largest or to the whole, below which a direction does not
count: of scatter, of a basis function, of an effect's column beside other effects, of a pose beside the others. A
judgement: effects that are merely less visible beside others keep a hundredth and more."""

# The search over sets of effects.

MOST_RMS_M: Final = 0.1
"""Error of fitted points above which no effect is searched for [m]: a shoulder's zero on its bound, 0.1 rad, leaves
0.08 m on a UR10; rows shifted by a pose leave more."""

SHARE_OF_BEST_SCORE: Final = 0.75
"""Least score of a candidate that is refitted, relative to the best score or to the chi-squared that an effect
explains: scores are linear, with errors up to a quarter. With 0.5 the effects of one of 55 blind worlds are lost."""
SEARCH_LIMIT: Final = 4
"""Most effects in a model for which replacements are tried; most effects beside the geometry of a whole arm; most sites
of a gap; most alternatives to an effect; most restarts of the search for another noise, and most repeated searches for
gross errors with effects in the model. Most effects in a model are twice as many. With more effects or sites, effects
imitate a cause outside the library. Eight beside the geometry take twice the time."""
REFITS: Final = 2
"""Number of effects, best scores first, that are refitted before one is added or replaces another."""
PLACEMENTS_OF_AN_ARM: Final = 3
"""Least number of link placements that are the geometry of a whole arm, and of effects for which that geometry is
tried: errors of several joints hide each other. A judgement: tolerances of manufacture affect every joint, damage of an
arm one or two."""
NO_DIFFERENCE: Final = 1.1
"""Ratio, either way, of two sizes that count as equal: of a model's remaining noise and the assumed one, else the
search starts again; of a held-out gap and the noise floor, where a remainder may be an inexact form of an effect. A
judgement: with 2.2 three data sets with a scatter of 1 mrad have no gap."""
ONE_MEASUREMENT: Final = 0.1
"""Ratio of the scatter of rows to their noise, below which they are no independent measurements: reflectors computed
from one 6-D pose agree to their last digit, 1e-3 to 2e-2 on two real campaigns; the residuals of rows without noise are
rounding. A judgement."""

# An unmodelled cause: a smooth function of unknown form at some site.

CHI2_OF_UNMODELLED_CAUSE: Final = 12.0
"""Penalty of a cause outside the library, in chi-squared. A prior: odds of 1 to 400. With 6 or 24 no answer changes on
six blind worlds; 4 no longer finds some weak true causes, and -12 loses 5 of 18."""
SMOOTH: Final = 0.35
"""Correlation length of a function of unknown form, as a share of its coordinate's range, or of the posture's spread;
functions with corners have it, too: a ramp over a tenth of the range is a tenth off, over a fifth 0.03. A judgement:
with 0.25 for corners and 0.6 for the posture, 83 blind worlds have the same answers."""
SMOOTH_LOAD: Final = 2.0
"""Correlation length for loads: of a force at the flange, as a share of the extent of the flange's positions, since a
cable fixed far away pulls nearly equally everywhere; of the direction of gravity in the flange and the overturning
moment, as a share of their ranges, since elastic deflection is nearly proportional. A judgement: 1 and 4 change twice
the log-likelihood of seven cables by 25 at most."""
FINE: Final = 0.1
"""Correlation length of functions with several waves, which are no scatter: of a joint's coordinates, of time, in
which a stand sways, and of the position on a target with dents. A judgement: a wave with three periods over a joint's
range then explains 480 of 150 poses and 110 of 40, where half of the apparent scatter is granted, and chance 50 and 25,
for a price of 230 and 60; with 0.25 it explains 250 and 50. From 0.03 to 0.15 these change by 5 %."""
MAX_DISTORTION_PX: Final = 0.1
"""Largest plausible distortion of a lens beyond the model, as a standard deviation over the image. A judgement: without
a limit, scatter of a camera's poses by 0.1 mrad is reported as a gap in its lens."""

# The probability of an effect, and its alternatives.

SMALL_SHARE: Final = 0.05
"""Chi-squared beside an effect, relative to the chi-squared that the effect explains, up to which it may be an inexact
form of the effect, and which halves its credibility if no effect explains it: a judgement, set by blind trials. And
other small shares: of the largest range of a coordinate, below which another one is not scaled up, since a flat
target's height is its noise; of poses, above which a growing diagnosis starts again; of a parameter's bounds, by which
a check of the data moves it aside."""

LARGEST_PLAUSIBLE: Final = 10.0
"""Largest plausible size of an effect, relative to that usual in industry: a larger one is no certain cause beside an
alternative that fits as well. A judgement; a joint's zero may be off by 1°."""

LARGEST_USUAL: Final = 3.0
"""Size of the errors of an arm that was never calibrated, relative to that usual in industry. A judgement."""

# Standard errors.

SIGMA_OF_95_PERCENT: Final = NormalDist().inv_cdf(0.975)
"""Half-width of the 95 % interval of a normal distribution, in standard deviations."""

# Classes of causes.

CREDIBLE_MASS: Final = 0.95
"""Probability that a credible set contains the true cause. A convention (Wang et al. 2020)."""
LEAST_PROBABILITY: Final = 0.01
"""Probability below which a class or an effect is not reported: an effect is then reported as its class."""

# The verdict.

NO_NOISE: Final = 2.0
"""Ratio of an error to that expected from noise, above which it is not noise: of the root mean square of whitened rows
to that expected from their median; of the squares of a fit's residuals to those of the noise estimated from them, if
the search ended in a local optimum; of a held-out gap to its noise floor, beyond which no share of it is small enough
to be closed, also by effects too improbable to be reported. A judgement: of rows it is 1.08 at most on 84 data sets,
and 2.5 for a reflector that slips by ten times the noise; of gaps below 1.5 in blind worlds of known effects, and 5 for
a real scanner with an unknown remainder."""
MOST_OVER_STATED: Final = 3.0
"""Ratio of estimated to stated row noise, above which it is no noise. A judgement: in blind worlds it is 2.6 at most;
it is 3.4 with a rolling shutter, 5 with a tracked body whose angles have a bias that depends on the viewing position,
and 20 with a slipped reflector, half of it reported as a moved base."""
SIGMA_WITHOUT_LOCATION: Final = 3.0
"""Standard deviations by which a gap without any location must exceed the noise. A quantile: chance reaches it in one
of 740 sound data sets, and the end of a 95 % interval in one of 40. No unexplained gap of 257 data sets lacks one."""
OPEN_SHARE: Final = 0.005
"""Share of the squared gap above the noise, up to which a remainder may also be an inexact form of an effect, if the
noise is so small that any other form is visible. A judgement: of twelve blind worlds with a remainder, two true effects
each left 0.0004 and 0.002, causes outside the library 0.012 and more."""
LEFT_BY_IMITATION: Final = 1.0 / 3.0
"""Share of the squared error on new poses that effects of another form may leave for it to be no chance. A judgement:
the best of all ripples leaves 0.5 to 0.6 of a joint's scatter over 25 to 40 poses, and 0.3 of a ripple of another form
over 120."""
