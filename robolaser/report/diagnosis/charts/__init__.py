"""Charts of a diagnosis, one file each."""

from collections.abc import Callable

from robolaser.diagnosis.result import Diagnosis
from robolaser.report.chart import Chart
from robolaser.report.diagnosis.charts.front import front
from robolaser.report.diagnosis.charts.poses import poses
from robolaser.report.diagnosis.charts.waterfall import waterfall

STEPS: tuple[Callable[[Diagnosis], Chart | None], ...] = (waterfall, front)
"""How far the gap shrinks, and how many effects that takes."""
ERRORS: tuple[Callable[[Diagnosis], Chart | None], ...] = (poses,)
"""Which poses err, before and after."""
