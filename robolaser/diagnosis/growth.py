"""Updates of a diagnosis: further poses change its probabilities and the sizes of its effects.

Held-out errors remain those of the last full examination. All poses are examined again after more than a small share of
further poses, after one that is improbable by chance, and after a change of a probability that could make a certain
effect doubtful: other effects may lead then.
"""

from collections.abc import Callable
from dataclasses import replace

import numpy as np

from robolaser.arrays import Array
from robolaser.data.dataset import Dataset
from robolaser.data.joining import check_same_arm, poses_beyond, with_poses_of
from robolaser.diagnosis.cause_classes import reweighed_classes, reweighed_kinds
from robolaser.diagnosis.fit import Fit
from robolaser.diagnosis.further_poses import Weighed
from robolaser.diagnosis.result import Diagnosis, Finding
from robolaser.diagnosis.summary_text import imitated_sentence, sentence, transfer_sentences
from robolaser.diagnosis.thresholds import LEAST_PROBABILITY, SMALL_SHARE
from robolaser.estimation.certainty import CERTAIN


def with_poses(found: Diagnosis, dataset: Dataset, examine: Callable[[Dataset], Diagnosis]) -> Diagnosis:
    """Update a diagnosis by further poses.

    Args:
        found: The diagnosis of the poses so far.
        dataset: The further poses, or all poses with those so far first.
        examine: Diagnoses a whole data set.

    Raises:
        DataError: The further poses are of another arm or kind of sensor, or have names of those so far.
    """
    so_far = found.as_given or found.dataset
    check_same_arm(so_far, dataset, f"appended to {so_far.name}")
    names = so_far.poses.names
    if dataset.poses.names[: len(names)] == names:
        whole, further = dataset, poses_beyond(so_far, dataset)
        if further is None:  # measurements at the poses so far have changed
            return examine(dataset)
    else:
        whole, further = with_poses_of(so_far, dataset), dataset
    if not len(further.poses):
        return found
    if not len(further.points) and not found.as_given:
        return replace(found, dataset=whole)
    weighed, examined = found.weighed, len(np.unique(found.observed.points.pose))
    is_as_described = not (found.wrong_input or found.hindrance or found.pose_scatter)
    is_as_described &= whole.sessions == so_far.sessions
    added = len(np.unique(further.points.pose)) + found.added_poses
    if not is_as_described or added > SMALL_SHARE * examined:
        return examine(whole)
    grown = weighed.with_poses(further)
    before = {one.candidate_effect: one.probability for one in weighed.evidence}
    change = max((abs(one.probability - before[one.candidate_effect]) for one in grown.reweighed), default=0.0)
    if change > 1.0 - CERTAIN or grown.now(grown.final).chance < LEAST_PROBABILITY:
        return examine(whole)
    return _updated(found, weighed, whole, grown)


def _updated(found: Diagnosis, before: Weighed, whole: Dataset, grown: Weighed) -> Diagnosis:
    evidence = grown.reweighed
    was, final = (each.now(grown.final) for each in (before, grown))
    was_start, start = (each.now(grown.start) for each in (before, grown))
    moved, narrowed = final.x - was.x, final.narrowed(was)
    probability = {one.candidate_effect: one.probability for one in evidence}
    findings = tuple(
        replace(_resized(one, final.fit, moved, narrowed), probability=probability[one.candidate_effect])
        for one in found.findings
    )
    classes = reweighed_classes(found.classes, grown.evidence, evidence)
    return replace(
        found,
        dataset=whole,
        added_poses=len(np.unique(grown.dataset.points.pose)) - len(np.unique(found.observed.points.pose)),
        sentence=sentence(found.verdict, findings, classes, found.where, found.gap, found.repeatability, found.odd_rows)
        + imitated_sentence(found.limits, classes)
        + transfer_sentences(found.validation, has_effects=bool(found.model.effects)),
        findings=findings,
        classes=classes,
        kinds=reweighed_kinds(found.kinds, grown.evidence, evidence),
        x=found.x + moved,
        std=found.std * narrowed,
        calibrated_x=found.calibrated_x + start.x - was_start.x,
        weighed=grown,
    )


def _resized(finding: Finding, final: Fit, moved: Array, narrowed: Array) -> Finding:
    """A finding with its parameters and standard errors changed as those of the model, (d,)."""
    names = final.problem.parameters.names
    parameters = {}
    for name, was in finding.parameters.items():
        i = names.index(finding.candidate_effect.key(name))
        std = None if was.std is None else was.std * float(narrowed[i])
        parameters[name] = replace(was, value=was.value + float(moved[i]), std=std)
    return replace(finding, parameters=parameters)
