"""Diagnosis of the rows of one kind: the gap, its effects, and the remaining error."""

from dataclasses import dataclass, replace
from functools import cached_property
from typing import final

import numpy as np

from robolaser.arrays import Array, Bools, Ints
from robolaser.estimation.certainty import EVEN, LIKELY
from robolaser.motion.effect import TIMING, At
from robolaser.motion.gap import KindGap, medians, root_mean_squares, root_mean_squares_of_runs
from robolaser.motion.selection import SelectedEffect

FOLLOWS_RAD = 5e-4  # largest usual error of a joint that follows its commands. A judgement: 0.03°
FOLLOWS_SHARE, OF_LARGEST = 0.01, 0.005
"""The same as a share of a joint's torque, and of the largest one: no torque model is better. A judgement."""
LEFT_SHARE = 0.02  # share of the squared gap above the noise that may remain of an explained gap
LEFT_OVER_NOISE = 4.0
"""Times the noise, or the error of arms that follow, above which no share of the gap is small enough for that. A
judgement: a motor whose torque is cut off, taken for a scale, leaves 6 times as much, and 1 % of the gap."""
IS_NOISE = 1.1  # multiple of the noise up to which an error is noise
OVER_NOISE = 2.0  # multiple of the noise that may remain of an explained gap
LISTED = 0.33  # least probability of an effect or one of its rivals to be reported
REST_DISCOUNT = 0.15
"""Credibility that an effect loses by the remaining error: as much as it explains costs 13 %. A judgement, by
halves of a hobby arm's motions: scales, which that arm does not have, explain up to 1.02 of the remaining error,
dead zones, which it has, 3 to 58."""


def follows_nm(torques: Array) -> Array:
    """Usual error of joints with torques (n, j), (j,) [Nm]."""
    size = np.nan_to_num(root_mean_squares(torques))
    return np.asarray(np.maximum(FOLLOWS_SHARE * size, OF_LARGEST * size.max()))


@final
@dataclass(frozen=True, eq=False)
class KindDiagnosis:
    """Gap, effects and remaining error of the rows of one kind."""

    gap: KindGap
    candidates: tuple[At, ...]
    findings: tuple[SelectedEffect, ...]
    run: Ints  # of each row, (n,)
    before: Array  # errors of an ideal arm, (n, j)
    after: Array  # errors on unseen motions, (n, j)
    places: dict[str, str]  # coordinate of each joint's remaining error
    enough: Array  # usual error of each joint, (j,)
    cut: Bools | bool = False  # rows without a search for effects, (n, j)
    remarks: tuple[str, ...] = ()
    # errors on unseen motions with the shown effects alone, (n, j): others are in the model, but too small to name;
    # None where all are shown
    named: Array | None = None

    @property
    def has_gap(self) -> Bools:
        """Joints that do not follow their model, (j,)."""
        error = np.nan_to_num(self.gap.calibrated)
        return np.asarray(error > np.nan_to_num(np.maximum(self.enough, IS_NOISE * self.gap.noise_floor)))

    @property
    def shown(self) -> tuple[SelectedEffect, ...]:
        """Findings at joints that have a gap; clocks at other joints, too, which show them little."""
        return tuple(one for one in self._weighed if one.none < 1.0 - LISTED)

    @property
    def shown_at(self) -> frozenset[At]:
        """The effects that are shown, at their locations."""
        return frozenset(one.at for one in self.shown)

    @property
    def as_named(self) -> "KindDiagnosis":
        """The same with the errors of the shown effects alone."""
        if self.named is None:
            return self
        size = root_mean_squares(self.named)
        gap = replace(self.gap, after=size, noise_floor=np.minimum(self.gap.noise_floor, size))
        return replace(self, after=self.named, gap=gap)

    @cached_property
    def _weighed(self) -> list[SelectedEffect]:
        """These findings and doubtful ones, by the remaining error."""
        return [
            one.doubted(self._credibility(one))
            for one in self.findings
            if (one.at.effect.site == TIMING or (self.has_gap & (np.nan_to_num(one.gained) > 0.0)).any())
            and one.is_large
            and not one.is_on_bound
        ]

    def _credibility(self, one: SelectedEffect) -> float:
        """Credibility of an effect, by the remaining error at the joints where it acts.

        The less all effects together explain there, and the less it explains relative to the remaining error, the
        likelier it imitates a cause outside the library. Where a multiple of the noise remains, it is likely at most;
        except for servos, whose memory leaves as much of true effects, and clocks, which no single joint imitates.
        """
        before, rest = self._above_noise
        share = np.minimum(rest / np.maximum(before, 1e-24), 1.0)
        gained = np.nan_to_num(one.gained)
        if not gained.any() or (one.at.effect.rows == "tracking" and (gained > 0.0).sum() > 1):
            return 1.0  # joints that agree imitate no cause of one of them
        explained = 1.0 - float(share @ gained / gained.sum())
        is_exempt = one.at.effect.rows == "tracking" or one.at.effect.site == TIMING
        far = rest > (LEFT_OVER_NOISE**2 - 1.0) * self._usual_error**2  # a multiple of the noise is left
        most = 1.0 if is_exempt or far @ gained <= EVEN * gained.sum() else LIKELY
        return min(most, explained / (1.0 + REST_DISCOUNT * float(rest[gained > 0.0].sum() / gained.sum())))

    @property
    def _usual_error(self) -> Array:
        """Noise, or a joint's usual error, (j,)."""
        return np.asarray(np.maximum(self.enough, self.gap.noise_floor))

    @cached_property
    def _above_noise(self) -> tuple[Array, Array]:
        """Squared errors without the effects and with them, less those of noise, (j,) each."""
        counted = (np.where(self.cut, np.nan, errors) for errors in (self.before, self.after))
        # of most runs: an error in a single run is no reason for doubt
        usual = (medians(root_mean_squares_of_runs(errors, self.run) ** 2) for errors in counted)
        before, after = (np.nan_to_num(squares - self._usual_error**2) for squares in usual)
        return before, np.maximum(after, 0.0)

    @cached_property
    def _closed(self) -> Bools:
        """Joints whose gap is nearly closed, (j,)."""
        gap = self.gap
        with np.errstate(invalid="ignore"):
            small = gap.after**2 - gap.noise_floor**2 <= LEFT_SHARE * (gap.calibrated**2 - gap.noise_floor**2)
            small &= gap.after <= LEFT_OVER_NOISE * self._usual_error
            return np.asarray(small | (gap.after <= np.maximum(self.enough, OVER_NOISE * gap.noise_floor)))

    @property
    def is_open(self) -> Bools:
        """Joints whose gap has a cause outside the library, (j,)."""
        return np.asarray(self.has_gap & (~self._closed | self._is_doubted))

    @property
    def verdict(self) -> str:
        """The verdict on these rows."""
        if not self.shown and not self.has_gap.any():
            return "no_gap"
        return "explained" if self.shown and not self.is_open.any() else "unexplained"

    @property
    def _is_doubted(self) -> Bools:
        """Joints at which a cause outside the library is as likely as the main effect, (j,)."""
        if not self._weighed:
            return np.zeros(len(self.enough), dtype=bool)
        none = np.array([one.none for one in self._weighed])
        gained = np.nan_to_num([one.gained for one in self._weighed])
        return np.asarray((none[gained.argmax(axis=0)] >= EVEN) & gained.any(axis=0))

    @property
    def left(self) -> Array:
        """Errors on unseen motions with the effects that are as likely as unknown causes, (n, j)."""
        return np.where(self._is_doubted, self.before, self.after)
