"""Pictures of a calibration, one file each, in the order of the page."""

from collections.abc import Callable

from robolaser.report.canvas import Picture
from robolaser.report.evidence import Evidence
from robolaser.report.pictures.convergence import convergence
from robolaser.report.pictures.distribution import distribution
from robolaser.report.pictures.image import image
from robolaser.report.pictures.parameters import parameters
from robolaser.report.pictures.points import points
from robolaser.report.pictures.poses import poses

PICTURES: tuple[Callable[[Evidence], Picture | None], ...] = (
    convergence,
    parameters,
    points,
    image,
    poses,
    distribution,
)
"""Each gives None where it has no meaning for a data set or a run."""
