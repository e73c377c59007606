"""Which poses err."""

from robolaser.report.chart import Chart
from robolaser.report.error_analysis import ErrorAnalysis
from robolaser.report.pose_errors import pose_errors


def poses(analysis: ErrorAnalysis) -> Chart:
    """Root-mean-square error of each pose, fitted and held out."""
    dataset, errors = analysis.compared
    reading = "Dots: a pose when it was fitted; rings: when it was held out." if len(errors) > 1 else ""
    return pose_errors(dataset, errors, reading=reading)
