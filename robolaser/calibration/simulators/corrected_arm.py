"""A calibrated arm as simulators can have it: its URDF, the parts that stand for effects, and what has none."""

from dataclasses import dataclass
from functools import cached_property
from typing import final

import numpy as np

from robolaser.arrays import Array
from robolaser.calibration.export import corrected_urdf, robot_urdf
from robolaser.calibration.result import Calibration
from robolaser.geometry.kinematics import Robot
from robolaser.model.effects.effect import CandidateEffect, Effect
from robolaser.model.effects.mechanism import Part, Spring


@final
@dataclass(frozen=True)
class CorrectedArm:
    """A calibration of an arm.

    Attributes:
        calibration: Of a data set with a robot.
    """

    calibration: Calibration

    @cached_property
    def robot(self) -> Robot:
        """The nominal arm."""
        return self.calibration.model.dataset.arm[0]

    @cached_property
    def effects(self) -> tuple[tuple[CandidateEffect, Effect], ...]:
        """The effects of the model, with their values."""
        values = self.calibration.model.parameters.values(self.calibration.x[None])
        return tuple((one, one.at(values)) for one in self.calibration.model.effects)

    @cached_property
    def urdf(self) -> str:
        """With the sensor's frames, and offsets and placements of joints as they are."""
        return corrected_urdf(self.calibration) or robot_urdf(self.calibration)

    @cached_property
    def parts(self) -> tuple[Part, ...]:
        """What stands for effects, in the order of the model."""
        return tuple(part for _, effect in self.effects for part in effect.parts(self.calibration.model.run))

    @cached_property
    def payload_kg(self) -> float:
        """At the flange: the mean of what the data state, and what gave way under a weight that they do not state."""
        springs = [part for part in self.parts if isinstance(part, Spring)]
        soft = [1.0 / spring.stiffness for spring in springs]
        found = float(np.average([spring.payload_kg for spring in springs], weights=soft)) if springs else 0.0
        return self.stated_payload_kg + found

    @cached_property
    def stated_payload_kg(self) -> float:
        """The mean of what the data state."""
        stated = self.calibration.model.dataset.poses.payload_kg
        return 0.0 if stated is None else float(stated.mean())

    def said(self, one: CandidateEffect) -> str:
        """An effect with its numbers, for a note."""
        numbers = (
            f"{each.name.rpartition('.')[2]} {self.calibration.value(each.name):.4g} {each.unit}".rstrip()
            for each in one.parameters.items
        )
        return f"{one.clause} ({one}: {', '.join(numbers)})"

    @cached_property
    def without_parts(self) -> tuple[str, ...]:
        """What no part stands for."""
        run = self.calibration.model.run
        return tuple(self.said(one) for one, effect in self.effects if not (one.effect.in_urdf or effect.parts(run)))


def digits(values: Array) -> str:
    """Numbers to the last bit."""
    return " ".join(repr(float(value)) for value in np.ravel(values))
