"""Projectors that are not mounted, or not ground, as drawn."""

from dataclasses import dataclass, replace
from typing import ClassVar, final

from robolaser.emulator.physics.effect import Departure
from robolaser.emulator.rendering import Sheet


@final
@dataclass(frozen=True)
class Rolled(Departure):
    """The sheet is turned about the view by `size` [rad]."""

    name: ClassVar[str] = "laser_roll"
    on_joints: ClassVar[bool] = False

    def light(self, sheet: Sheet) -> Sheet:
        """Turned."""
        return replace(sheet, roll=sheet.roll + self.size)


@final
@dataclass(frozen=True)
class Bent(Departure):
    """The sheet is a cone: its rays stand off the plane by `size` [rad]."""

    name: ClassVar[str] = "laser_curvature"
    on_joints: ClassVar[bool] = False

    def light(self, sheet: Sheet) -> Sheet:
        """Bent."""
        return replace(sheet, curvature=sheet.curvature + self.size)
