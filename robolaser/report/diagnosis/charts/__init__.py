"""Pictures of a diagnosis, one file each."""

from collections.abc import Callable

from robolaser.diagnosis.result import Diagnosis
from robolaser.report.canvas import Picture
from robolaser.report.diagnosis.pictures.cell import cell
from robolaser.report.diagnosis.pictures.front import front
from robolaser.report.diagnosis.pictures.plans import plans
from robolaser.report.diagnosis.pictures.poses import poses
from robolaser.report.diagnosis.pictures.waterfall import waterfall

FIRST: tuple[Callable[[Diagnosis], Picture | None], ...] = (waterfall, cell)
"""At the head of the page: how far the gap shrinks, and where it lies."""
THEN: tuple[Callable[[Diagnosis], Picture | None], ...] = (plans, poses, front)
"""Below: errors before and after, and how many effects it takes."""
