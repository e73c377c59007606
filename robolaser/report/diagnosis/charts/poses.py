"""Which poses erred before the effects were in the model, and which still do."""

from robolaser.diagnosis.result import Diagnosis
from robolaser.report.chart import Chart
from robolaser.report.pose_errors import pose_errors


def poses(diagnosis: Diagnosis) -> Chart:
    """Root-mean-square error of each pose on held-out data, before and after, in the order of the run."""
    both = {"before": diagnosis.before_m, "after": diagnosis.after_m}
    errors = both if diagnosis.model.effects else {"each pose": diagnosis.after_m}
    reading = "Each pose predicted by fits that did not see it."
    return pose_errors(diagnosis.observed, errors, reading=reading, noise_m=diagnosis.gap.noise_floor_m)
