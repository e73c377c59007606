"""The taking of a recording: from pose to pose, at rest, look, write; and stop at once when anything is wrong."""

from collections.abc import Callable
from contextlib import suppress
from typing import final

import numpy as np

from robolaser.arrays import Array
from robolaser.cell import Cell
from robolaser.devices.angles import posture, shown
from robolaser.devices.arm import Arm
from robolaser.devices.arriving import Mover
from robolaser.devices.camera import Camera, Image, Warn
from robolaser.devices.checked import carried, violations
from robolaser.devices.clock import Clock
from robolaser.devices.journal import IMAGE_OFF, Journal, Stay
from robolaser.devices.route import Visit, way
from robolaser.errors import FileUnwritable, PlanUnsafe, RecordingStopped, Restless, RobolaserError
from robolaser.robot import Robot

LIGHT_GREY = 40
"""By which a laser brightens some pixel at least, if it is seen: noise alone does by a dozen."""


@final
class Session:
    """One arm, one camera, one recording."""

    def __init__(
        self, cell: Cell, robot: Robot, arm: Arm, camera: Camera, journal: Journal, clock: Clock, warn: Warn
    ) -> None:
        self._cell = cell
        self._robot = robot
        self._arm = arm
        self._camera = camera
        self._journal = journal
        self._clock = clock
        self._warn = warn
        self._mover = Mover(arm, robot, cell.limits.speed_rad_s, clock)
        self._began = clock.now() - journal.time_s
        self._at: Array | None = None

    def run(self, told: Callable[[Visit], None]) -> None:
        """Visit all poses that remain.

        Args:
            told: Hears of each pose once it is safe on the disk.

        Raises:
            RecordingStopped: Something was wrong, or somebody pressed Ctrl-C. The arm was stopped; what is on the disk
                is a whole recording of the poses up to there.
            PlanUnsafe: Nothing was moved.
        """
        try:
            self._run(told)
        except PlanUnsafe:
            raise
        except BaseException as error:
            standing = self._stopped(error)
            raise self._why(error, standing) from None

    def _run(self, told: Callable[[Visit], None]) -> None:
        if self._cell.arm.home:
            self._arm.home()
        self._journal.read_in_steps(self._arm.step)
        self._at = self._mover.resting("Before its first motion")
        visits = self._journal.remaining
        self._check(self._at, visits)
        name = self._journal.unused("resumed" if self._journal.begun else "start")
        self._journal.add([Stay(name, self._now(), self._at)])
        if self._cell.laser_output is not None:
            self._arm.light(self._cell.laser_output)
        for visit in visits:
            self._journal.add(self._visit(visit, self._at))
            told(visit)
        if self._cell.laser_output is not None:
            self._arm.dark(self._cell.laser_output)

    def _check(self, start: Array, visits: tuple[Visit, ...]) -> None:
        if visits:
            tools = carried(self._cell.description)
            broken = violations(self._robot, self._cell.limits, tools, start, *way(visits))
            if broken:
                raise PlanUnsafe([str(violation) for violation in broken])

    def _visit(self, visit: Visit, at: Array) -> list[Stay]:
        stays: list[Stay] = []
        if visit.approach is not None:
            at = self._at = self._mover.travel(visit.approach, visit.approach_name, at)
            stays.append(Stay(visit.approach_name, self._now(), at))
        at = self._at = self._mover.travel(visit.q, visit.name, at)
        images = {"image": self._camera.shot(self._cell.camera.settle_s)}
        time_s = self._now()
        for k in range(2, self._journal.shots + 1):
            images[f"image_{k}"] = self._camera.shot(0.0)
        if self._cell.laser_output is not None:
            self._arm.dark(self._cell.laser_output)
            images[IMAGE_OFF] = self._camera.shot(self._cell.camera.settle_s)
            self._arm.light(self._cell.laser_output)
            self._see_light(visit, images["image"], images[IMAGE_OFF])
        self._see_rest(visit, at)
        return [*stays, Stay(visit.name, time_s, at, images)]

    def _see_light(self, visit: Visit, on: Image, off: Image) -> None:
        if int((on.astype(np.int16) - off).max()) < LIGHT_GREY:
            self._warn(
                f"{visit.name}: the laser makes no difference to the image."
                " Is it on and in view, or is the camera later than settle_s in cell.toml?"
            )

    def _see_rest(self, visit: Visit, before: Array) -> None:
        moved = np.abs(self._mover.resting(f"At {visit.name}") - before)
        if (moved > self._mover.near).any():
            joint = int(np.argmax(moved / self._mover.near))
            raise Restless(
                f"During the shots at {visit.name}",
                self._robot.joints[joint],
                shown(self._robot, joint, float(moved[joint])),
            )

    def _stopped(self, cause: BaseException) -> str:
        """Stop the arm, then the laser, and say where the arm is."""
        try:
            self._at = self._mover.halt()
            said = f"The arm was stopped. It stands at {posture(self._robot, self._at)}."
        except (RobolaserError, KeyboardInterrupt) as error:
            why = "" if isinstance(error, type(cause)) else f" {error or 'Interrupted again.'}"
            last = "" if self._at is None else f" It last rested at {posture(self._robot, self._at)}."
            said = (
                f"The arm could not be seen to stop.{why}{last} It goes no further than to the place it was on its way"
                " to; keep clear of it, and press its emergency button."
            )
        if self._cell.laser_output is not None:
            with suppress(RobolaserError, KeyboardInterrupt):
                self._arm.dark(self._cell.laser_output)
        return said

    def _why(self, error: BaseException, standing: str) -> BaseException:
        if isinstance(error, KeyboardInterrupt):
            cause = "Stopped by hand."
        elif isinstance(error, OSError):
            cause = str(FileUnwritable(self._journal.folder, error.strerror or str(error)))
        elif isinstance(error, RobolaserError):
            cause = str(error)
        else:
            return error
        done = self._journal.done if self._journal.begun else None
        return RecordingStopped(cause, standing, self._journal.folder, done, len(self._journal.visits))

    def _now(self) -> float:
        return self._clock.now() - self._began
