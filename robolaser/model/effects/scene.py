"""What an effect may look at besides what passes: poses, points, and what follows from them once and for all."""

from dataclasses import dataclass
from functools import cached_property
from typing import final

import numpy as np

from robolaser.arrays import Array, Ints
from robolaser.data.dataset import Dataset, Points, Poses
from robolaser.geometry.kinematics import Robot
from robolaser.model.effects.course import approached, progress, rise
from robolaser.model.effects.surface import Plane, plane_of, tilt_of
from robolaser.model.effects.weight import of_one_kg, torques


@final
@dataclass(frozen=True, eq=False)
class Scene:
    """A data set as effects see it. What costs something is worked out when first asked for, and kept.

    Attributes:
        dataset: What was measured.
    """

    dataset: Dataset

    @classmethod
    def of(cls, dataset: Dataset) -> "Scene":
        """The scene of a data set."""
        return cls(dataset)

    @property
    def poses(self) -> Poses:
        """Where the arm stood."""
        return self.dataset.poses

    @property
    def points(self) -> Points:
        """What was seen."""
        return self.dataset.points

    @property
    def robot(self) -> Robot | None:
        """The nominal arm."""
        return self.dataset.robot

    @property
    def stripe_axis(self) -> str:
        """Image axis that the stripe runs along."""
        return self.dataset.stripe_axis

    @cached_property
    def order(self) -> Ints:
        """Numbers of the poses as they followed one another, (n,)."""
        assert self.poses.time_s is not None  # effects that need the order say so in `missing`
        return np.argsort(self.poses.time_s, kind="stable").astype(np.int64)

    @cached_property
    def progress(self) -> Array:
        """How far the run had come at each pose, (n,), from 0 to 1; in time, or in order where only that is known."""
        assert self.poses.time_s is not None  # as above
        return progress(self.poses.time_s, self.order, in_order=self.dataset.time_is_order)

    @cached_property
    def rise(self) -> Array | None:
        """Rise of temperature at each pose over its largest, (n,); None where it was not measured."""
        return rise(self.poses)

    @cached_property
    def approach(self) -> Array:
        """The way each joint last moved before each pose, (n, j): +1, -1, or 0 where it has not moved yet."""
        assert self.poses.q is not None  # as above
        return approached(self.poses.q, self.order)

    @cached_property
    def gravity_torques(self) -> Array:
        """What each joint must bear at the angles read, the payload included, (n, j) [Nm or N]."""
        assert self.robot is not None  # as above
        return torques(self.robot, self.poses)

    @cached_property
    def torques_of_one_kg(self) -> Array:
        """What each joint must bear of one kilogram at the flange, (n, j) [Nm or N]."""
        assert self.robot is not None  # as above
        assert self.poses.q is not None
        return of_one_kg(self.robot, self.poses.q)

    @cached_property
    def flange(self) -> Array:
        """T_base_flange as the nominal arm or the measurement says, (n, 4, 4)."""
        return self.dataset.flange()

    @cached_property
    def target(self) -> Plane:
        """The plane of the target points, in the frame that they are given in."""
        assert self.points.xyz is not None  # as above
        return plane_of(self.points.xyz)

    @cached_property
    def tilt(self) -> Array:
        """Tangent of the surface's tilt against each ray, across the stripe, by the nominal model, (m,)."""
        return tilt_of(self.dataset, self.flange, self.target)
