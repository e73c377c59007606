"""Lenses whose focal length depends on the focus distance."""

from dataclasses import dataclass
from typing import final

from robolaser.arrays import Array
from robolaser.model.effects.effect import Effect, Run, Stage, parameter
from robolaser.model.effects.requirements import known_ranges


@final
@dataclass(frozen=True)
class FocusBreathing(Effect):
    """The image grows with the distance of the object: u' = u (1 + breathing (d / d0 - 1)).

    d is the distance of a row's point from the camera by the nominal model, d0 its mean over all rows. A lens that
    focuses on each image moves along its axis, which changes the focal length.
    """

    name = "focus_breathing"
    title = "the focal length changes with the distance"
    clause = "the focal length changes with the distance"
    caveat = "known within the measured distances only"
    remedy = "Switch autofocus off, and lock the focus ring of the lens."
    reference = (
        "Willson, Shafer 1994, What is the center of the image?; zoom and focus change the focal length by 1-5 %"
    )
    stage = Stage.IMAGE
    cause = "camera"
    site = "camera"
    needs = (known_ranges,)
    depends_on_trajectory = True

    breathing: Array = parameter(unit="", bound=0.5, prior_scale=5e-3)

    def apply(self, image: Array, run: Run, /) -> Array:
        return image * (1.0 + self.breathing[:, None] * run.relative_range)[..., None]
