"""Charts of a diagnosis, one file each."""

from collections.abc import Callable

from robolaser.diagnosis.result import Diagnosis
from robolaser.report.chart import Chart
from robolaser.report.diagnosis.charts.cell import cell
from robolaser.report.diagnosis.charts.front import front
from robolaser.report.diagnosis.charts.plans import plans
from robolaser.report.diagnosis.charts.poses import poses
from robolaser.report.diagnosis.charts.waterfall import waterfall

FIRST: tuple[Callable[[Diagnosis], Chart | None], ...] = (waterfall, cell)
"""At the head of the page: how far the gap shrinks, and where it lies."""
THEN: tuple[Callable[[Diagnosis], Chart | None], ...] = (plans, poses, front)
"""Below: errors before and after, and how many effects it takes."""
