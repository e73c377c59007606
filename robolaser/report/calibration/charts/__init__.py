"""Charts of a calibration, one file each, in the order of the page."""

from collections.abc import Callable

from robolaser.report.calibration.charts.convergence import convergence
from robolaser.report.calibration.charts.distribution import distribution
from robolaser.report.calibration.charts.image import image
from robolaser.report.calibration.charts.parameters import parameters
from robolaser.report.calibration.charts.poses import poses
from robolaser.report.chart import Chart
from robolaser.report.error_analysis import ErrorAnalysis

CHARTS: tuple[Callable[[ErrorAnalysis], Chart | None], ...] = (
    convergence,
    parameters,
    image,
    poses,
    distribution,
)
"""Each gives None where it has no meaning for a data set or a run."""
