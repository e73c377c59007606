"""The result of a diagnosis: the verdict, the gap step by step, the locations, the effects, and what to do next."""

from collections.abc import Mapping
from dataclasses import dataclass
from functools import cached_property
from typing import final

import numpy as np

from robolaser.arrays import Array, Ints
from robolaser.data.dataset import Dataset
from robolaser.diagnosis.further_poses import Weighed
from robolaser.diagnosis.localization import Localization
from robolaser.diagnosis.pose_scatter import PartScatter
from robolaser.diagnosis.repeatability import NoiseSource, Repeatability
from robolaser.estimation.folds import FoldFits
from robolaser.model.effects.effect import CandidateEffect
from robolaser.model.forward_model import Model
from robolaser.robot.kinematics import Robot


@final
@dataclass(frozen=True)
class Estimate:
    """A parameter of an effect.

    Attributes:
        value: In its unit.
        std: One standard deviation; None where the data do not fix it, or a bound does.
        unit: SI.
        bound: `lower` or `upper` where the value ended on that bound, else empty.
    """

    value: float
    std: float | None
    unit: str
    bound: str = ""


@final
@dataclass(frozen=True)
class Alternative:
    """An effect that these poses cannot distinguish from one that was found.

    Attributes:
        candidate_effect: Which, and where.
        parameters: Its parameters instead of the other's, by name.
        gap_m: Held-out gap with it instead of the other.
    """

    candidate_effect: CandidateEffect
    parameters: Mapping[str, Estimate]
    gap_m: float


@final
@dataclass(frozen=True)
class Finding:
    """An effect that was found.

    Attributes:
        candidate_effect: Which, and where.
        probability: Of it, at this location, against every other candidate, none, and something unknown.
        parameters: By name.
        gap_before_m: Held-out gap with the effects found before it in the model.
        gap_after_m: With this one too.
        gap_without_m: With all but this one.
        alternatives: Effects that these poses cannot distinguish from it, the nearest first.
    """

    candidate_effect: CandidateEffect
    probability: float
    parameters: Mapping[str, Estimate]
    gap_before_m: float
    gap_after_m: float
    gap_without_m: float
    alternatives: tuple[Alternative, ...]


@final
@dataclass(frozen=True)
class CauseKind:
    """An effect at all locations where it seems to be at work.

    Attributes:
        effect: Its name.
        where: The locations.
        probability: That it is at work somewhere.
        gap_without_m: Held-out gap of the final model without it [m].
    """

    effect: str
    where: tuple[str, ...]
    probability: float
    gap_without_m: float


@final
@dataclass(frozen=True)
class CauseClass:
    """A class of causes.

    Attributes:
        name: Of the class.
        probability: That at least one of its members is at work.
        gap_without_m: Held-out gap of the final model without all of its members [m]; None where it has none of them.
        gap_with_m: The same of the final model [m].
        members: Its effects that may be at work, each with its probability, the most probable first.
        credible_sets: For each of its effects that were found, the fewest candidates of any class of which one is at
            work with 95 %, where there is such a set.
        site: Of an unknown cause.
    """

    name: str
    probability: float
    gap_without_m: float | None
    gap_with_m: float
    members: tuple[tuple[CandidateEffect, float], ...] = ()
    credible_sets: tuple[tuple[CandidateEffect, ...], ...] = ()
    site: str = ""


@final
@dataclass(frozen=True)
class WrongInput:
    """What is wrong with the data set rather than with the cell: it is corrected in the files.

    Attributes:
        name: `mispaired` or `held_parameter`.
        where: The sensor's part.
        cause: Its class of causes.
        probability: That this is wrong.
        parameters: By name; those that the data set holds, as they would be if they were free.
        gap_before_m: Held-out gap with the fault.
        gap_after_m: Once it is corrected.
        alternatives: Effects that may be at work instead.
    """

    name: str
    where: str
    cause: str
    probability: float
    parameters: Mapping[str, Estimate]
    gap_before_m: float
    gap_after_m: float
    alternatives: tuple[CandidateEffect, ...] = ()


@final
@dataclass(frozen=True)
class RotationGap:
    """Root-mean-square error of rotations on held-out poses [rad].

    Attributes:
        calibrated_rad: After the ordinary parameters were fitted.
        after_rad: With all that was found.
        least_rad: The lower end of its 95 % interval.
        noise_floor_rad: By noise alone.
    """

    calibrated_rad: float
    after_rad: float
    least_rad: float
    noise_floor_rad: float


@final
@dataclass(frozen=True)
class Gap:
    """Root-mean-square 3-D error on held-out poses, repeats averaged, gross errors left out [m].

    Attributes:
        nominal_m: Of the sim as given; None where none was given.
        rotations: The same of rotations; None where none are measured.
        is_held_out: Whether any pose was held out; else all errors are of the poses that were fitted.
        distances_m: Error of known distances that were not known, calibrated and after; None without any.
    """

    nominal_m: float | None
    calibrated_m: float
    after_m: float
    noise_floor_m: float
    after_ci95_m: tuple[float, float]
    rotations: RotationGap | None = None
    is_held_out: bool = True
    distances_m: tuple[float, float] | None = None


@final
@dataclass(frozen=True)
class DetectionLimit:
    """The smallest size of an effect's principal number that these data would have shown nine times in ten.

    Attributes:
        candidate_effect: Which, and where.
        parameter: Name of its principal parameter.
        size: In its unit; None where no plausible size shows.
        unit: SI.
        identifiable: The smallest plausible size at which it is distinguished from its nearest rival; None without one.
        rival: The candidate, of no higher complexity penalty, that looks most like it; None where none does.
        at_tool_m: By how much an effect of just the detectable size moves what is measured, root mean square over these
            data, nothing refitted [m].
        is_imitated: Whether it is unseen only because the effects found do the same.
    """

    candidate_effect: CandidateEffect
    parameter: str
    size: float | None
    unit: str
    identifiable: float | None = None
    rival: CandidateEffect | None = None
    at_tool_m: float | None = None
    is_imitated: bool = False


@final
@dataclass(frozen=True)
class Validation:
    """Other data of the same arm, predicted with what was found; only the positions of things in the cell are refitted.

    Errors are root-mean-square 3-D errors on poses held out from that fit, gross errors left out [m].

    Attributes:
        dataset: Name of the other data set.
        nominal_m: With the sim's arm and sensor; None where there is no nominal model.
        calibrated_m: With the ordinary parameters that were found, without effects.
        after_m: With all effects found, as they carry over.
        noise_floor_m: What noise alone would give.
        is_better: Whether the effects clearly lower the error, poses being drawn by chance.
        rows: Rows compared, repeats averaged.
        remarks: What did not carry over as it was found, and rows left out.
    """

    dataset: str
    nominal_m: float | None
    calibrated_m: float
    after_m: float
    noise_floor_m: float
    is_better: bool
    rows: int
    remarks: tuple[str, ...]


@final
@dataclass(frozen=True)
class Diagnosis:
    """The answer.

    Attributes:
        dataset: What was diagnosed; where a fault of the data set was found, without that fault.
        verdict: `no_gap`, `explained` or `unexplained`.
        sentence: The verdict for a person.
        gap: How far the gap shrinks.
        where: Locations of the gap; for `unexplained`, of the remaining error.
        findings: Effects found, that without which the gap would be largest first; of those in the model, the few that
            are too improbable by themselves are left out.
        kinds: Effects with all of their locations, those that explain most first.
        classes: Possible classes of causes, most important first.
        outliers: Rows of points.csv (from 0) that are gross errors.
        not_testable: Why an effect could not be tested, by its name.
        next_poses: Joint values by name that distinguish the leading rivals.
        limits: Detection limits of effects that were not found.
        model: The final model, on averaged rows.
        x: Its parameters, in the order of `model.parameters`.
        std: One standard deviation of each; NaN for fixed ones.
        calibrated_x: The sensor's parameters without effects in the model, in the same order.
        unseen: Fits of the final model without each fold of these rows; None where none could be held out.
        before_m: Held-out errors of the averaged rows in the calibrated model, (m, 3).
        after_m: The same with all effects, (m, 3).
        noise: Sources of noise, by name.
        repeatability: How much whole poses scatter.
        odd_rows: What the sentence says of rows that do not agree with the others; may be empty.
        noise_remarks: Remarks on contradictions of the stated noise.
        seconds: Time taken.
        validation: Other data of the same arm, predicted with what was found.
        hindrance: Why no effect was searched for, as a sentence; empty otherwise.
        wrong_input: A fault of the data set; None without one.
        pose_scatter: By how much whole poses scatter beyond what counts as noise; None where they do not.
        weighed: The models that were weighed, for charts and for further poses; None where the data are too bad.
        as_given: The data set with its fault; None where `dataset` is as it was given.
        added_poses: How many poses count in the probabilities beside those that are used for all else.

    Examples:
        >>> from robolaser.diagnosis import examine
        >>> examine(dataset, effects=[]).gap.nominal_m > 0
        True
    """

    dataset: Dataset
    verdict: str
    sentence: str
    gap: Gap
    where: tuple[Localization, ...]
    findings: tuple[Finding, ...]
    kinds: tuple[CauseKind, ...]
    classes: tuple[CauseClass, ...]
    outliers: Ints
    not_testable: Mapping[str, str]
    next_poses: tuple[Mapping[str, float], ...]
    limits: tuple[DetectionLimit, ...]
    model: Model
    x: Array
    std: Array
    calibrated_x: Array
    unseen: FoldFits | None
    before_m: Array
    after_m: Array
    noise: Mapping[str, NoiseSource]
    repeatability: Repeatability
    noise_remarks: tuple[str, ...]
    seconds: float
    odd_rows: str = ""
    validation: tuple[Validation, ...] = ()
    hindrance: str = ""
    wrong_input: WrongInput | None = None
    pose_scatter: PartScatter | None = None
    weighed: Weighed | None = None
    as_given: Dataset | None = None
    added_poses: int = 0

    @property
    def observed(self) -> Dataset:
        """Averaged rows without gross errors."""
        return self.model.dataset

    @cached_property
    def robot(self) -> Robot | None:
        """The corrected arm, as the exported URDF has it: `forward`, `jacobian` and `inverse`, in batches.

        With the offsets and placements of joints in the model, but without what a URDF cannot hold, such as compliance.
        None for a data set of measured flange poses.
        """
        return self.model.robot_at(self.x)

    @property
    def poses(self) -> tuple[int, int]:
        """How many poses are used, and how many have points."""
        used, every = (len(np.unique(one.points.pose)) for one in (self.observed, self.dataset))
        return used + self.added_poses, every
