"""A calibrated arm for simulators: its URDF, the parts that represent effects, and effects without any."""

import re
from dataclasses import dataclass
from functools import cached_property
from typing import final

import numpy as np

from robolaser.arrays import Array
from robolaser.calibration.result import Calibration
from robolaser.export.urdf import corrected_urdf, robot_urdf
from robolaser.model.effects.effect import CandidateEffect, Effect
from robolaser.model.effects.mechanism import ElasticJoint, MechanismPart
from robolaser.robot.kinematics import Robot
from robolaser.robot.urdf.checking import read_xml
from robolaser.robot.urdf.editing import names_in

SEARCHED_KG = (np.linspace(0.0, 20.0, 201), np.linspace(-0.1, 0.1, 201))
SOFTEST = 1e-12  # least compliance [rad/Nm] of a spring


@final
@dataclass(frozen=True)
class CorrectedArm:
    """A calibration of an arm."""

    calibration: Calibration  # of a data set with a robot

    @cached_property
    def robot(self) -> Robot:
        """The nominal arm."""
        return self.calibration.model.dataset.arm[0]

    @cached_property
    def effects(self) -> tuple[tuple[CandidateEffect, Effect], ...]:
        """The effects of the model, with their values."""
        return tuple((one, one.at(self.calibration.values)) for one in self.calibration.model.effects)

    @cached_property
    def urdf(self) -> str:
        """With the sensor's frames, and corrected offsets and placements of joints."""
        return corrected_urdf(self.calibration) or robot_urdf(self.calibration)

    @cached_property
    def _taken(self) -> frozenset[str]:
        urdf = read_xml(self.urdf)
        return frozenset((*names_in(urdf, "link"), *names_in(urdf, "joint")))

    def unused_name(self, name: str) -> str:
        """The name, or one like it that no link and no joint of the URDF has."""
        while name in self._taken:
            name += "_"
        return name

    @cached_property
    def parts(self) -> tuple[MechanismPart, ...]:
        """The parts that represent effects, in the order of the model."""
        return tuple(part for _, effect in self.effects for part in effect.parts(self.calibration.model.run))

    @cached_property
    def payload_kg(self) -> float:
        """Mass at the flange: the mean of the stated payload, plus the mass with which springs fit the joints best.

        Payload and compliance are estimated for each joint by itself, and gears harden: one mass and a linear spring a
        joint are the least-squares fit to all of them at the calibrated poses.
        """
        found = np.zeros(1)
        for spread in SEARCHED_KG if self.springs else ():
            tried = np.maximum(found + spread, 0.0)
            fits = ((one.sunk, _compliance(one, tried)[:, None] * _torque(one, tried)) for one in self.springs)
            left = sum(np.sum((sunk - wound) ** 2, axis=1) for sunk, wound in fits)
            found = tried[[np.argmin(left)]]
        return self.stated_payload_kg + float(found[0])

    @cached_property
    def springs(self) -> tuple[ElasticJoint, ...]:
        """The elastic joints."""
        return tuple(part for part in self.parts if isinstance(part, ElasticJoint))

    def stiffness(self, spring: ElasticJoint) -> float:
        """Stiffness of a linear spring that carries the stated load and `payload_kg` [Nm/rad or N/m]."""
        return 1.0 / float(_compliance(spring, np.array([self.payload_kg - self.stated_payload_kg]))[0])

    @cached_property
    def stated_payload_kg(self) -> float:
        """The mean of the stated payload."""
        stated = self.calibration.model.dataset.poses.payload_kg
        return 0.0 if stated is None else float(stated.mean())

    def with_numbers(self, one: CandidateEffect) -> str:
        """An effect with its numbers, for a note."""
        numbers = (
            f"{each.name.rpartition('.')[2]} {self.calibration.value(each.name):.4g} {each.unit}".rstrip()
            for each in one.parameters_in(self.robot).items
        )
        return f"{one.clause} ({one}: {', '.join(numbers)})"

    @cached_property
    def without_parts(self) -> tuple[str, ...]:
        """Effects without parts."""
        run = self.calibration.model.run
        return tuple(
            self.with_numbers(one) for one, effect in self.effects if not (one.effect.in_urdf or effect.parts(run))
        )


def comment(text: str) -> str:
    """Text for a comment of XML, which must not contain two hyphens."""
    return re.sub("-(?=-)", "- ", text)


def _compliance(spring: ElasticJoint, payload_kg: Array) -> Array:
    """Compliance of the best linear spring with each of several masses at the flange, (k,) -> (k,)."""
    torque = _torque(spring, payload_kg)
    return np.asarray(np.maximum((torque @ spring.sunk) / np.maximum((torque**2).sum(axis=1), SOFTEST), SOFTEST))


def _torque(spring: ElasticJoint, payload_kg: Array) -> Array:
    return np.asarray(spring.borne + payload_kg[:, None] * spring.of_one_kg)
