"""Arms whose links are all longer by one factor."""

from dataclasses import dataclass
from typing import final

from robolaser.arrays import Array
from robolaser.geometry.rigid_motion import pose
from robolaser.model.effects.effect import Effect, Run, Stage, parameter
from robolaser.model.effects.requirements import joint_angles


@final
@dataclass(frozen=True)
class ArmScale(Effect):
    """Each joint is farther from the one before by a share of their distance: t' = t (1 + scale).

    A steel arm grows by 1.2e-5 a kelvin, an aluminium one by 2.3e-5. A tracker whose lengths are too short looks the
    same: known distances distinguish them.
    """

    name = "arm_scale"
    title = "all links are longer by one factor"
    clause = "all links are longer by one factor than the model's"
    caveat = (
        "a measuring system whose lengths are all too short looks the same, unless distances between points are known"
    )
    remedy = (
        "Let the arm warm up, or cool down, to the temperature at which it is used; check the measuring system's scale."
    )
    reference = (
        "Santolaria et al. 2009, thermal drift of articulated arms; 1.2e-5 (steel) to 2.3e-5 (aluminium) per kelvin"
    )
    stage = Stage.LINKS
    cause = "measuring_system"
    site = "base"
    needs = (joint_angles,)
    in_urdf = True

    scale: Array = parameter(unit="", bound=2e-3, prior_scale=2e-4)

    def apply(self, placements: Array, run: Run, /) -> Array:
        longer = 1.0 + self.scale[:, None, None, None]
        return pose(placements[..., :3, :3], placements[..., :3, 3] * longer)
