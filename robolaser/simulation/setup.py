"""The request for a simulated cell's sensor, and the random numbers that draw the cell."""

from collections.abc import Mapping
from dataclasses import dataclass, field, fields
from typing import Self, final

import numpy as np

from robolaser.arrays import Array
from robolaser.data.sensor_format import Mount
from robolaser.data.stated_noise import Noise
from robolaser.geometry.rigid_motion import Quaternion
from robolaser.model.effects.effect import CandidateEffect
from robolaser.model.sensors.placements import motion
from robolaser.parameters import as_batch

Effects = tuple[CandidateEffect, ...]  # of a cell


@final
@dataclass(frozen=True)
class CellOptions:
    """Differences of a simulated cell from the usual one.

    Example:
        >>> from robolaser import find_robot
        >>> from robolaser.simulation import CellOptions, simulate
        >>> simulate(find_robot("ur5"), poses=8, points=10, options=CellOptions(repeats=2), seed=1).dataset
        <Dataset simulated-ur5: laser stripe scanner, robot ur5, 160 points in 8 poses>
    """

    placed: bool = True  # whether target points are given in the base frame, or in their own (stripe and camera)
    stripe_axis: str = "u"  # image axis the stripe runs along
    bracket_quat: Quaternion | None = None  # nominal turn of the camera on the flange; None: view away from the arm
    mount: Mount = "flange"  # mount of a camera or a profile sensor
    repeats: int = 1  # images at each unmoved pose
    sessions: int = 1  # campaigns of the same arm and sensor, each with base, target or sockets elsewhere
    # Joints' typical speed at the exposure [rad/s or m/s]. None: the arm rests and no speed is recorded, except for an
    # effect of the timing.
    speed: float | None = None
    stated: Noise | None = None  # the stated noise of the data set; None: all of it
    name: str = ""  # of the data set


@final
@dataclass(frozen=True)
class SensorSetup:
    """The request for a sensor; each kind uses its part of it."""

    points: int  # in each pose, or names of points
    options: CellOptions
    effects: frozenset[str] = frozenset()  # names of the cell's effects: fitted terms of a camera's lens may hide them
    known: Mapping[str, float] = field(default_factory=dict)  # parameters that an earlier session has, too

    @property
    def hand_eye(self) -> Array | None:
        """The sensor's pose of an earlier session, on the flange or in the cell, (4, 4); None in the first."""
        if "hand_eye.x" not in self.known:
            return None
        return np.asarray(motion(as_batch(self.known), "hand_eye")[0])


@final
@dataclass(frozen=True)
class RandomStreams:
    """Separate random generators, so that a further draw from one does not change the others."""

    build: np.random.Generator
    place: np.random.Generator
    order: np.random.Generator
    along: np.random.Generator
    speed: np.random.Generator
    joint_noise: np.random.Generator
    point_noise: np.random.Generator
    gross: np.random.Generator
    distance_noise: np.random.Generator

    @classmethod
    def of(cls, seed: int) -> Self:
        """All of them from one seed."""
        children = np.random.SeedSequence(seed).spawn(len(fields(cls)))
        return cls(*(np.random.default_rng(child) for child in children))
