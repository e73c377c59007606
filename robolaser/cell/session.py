"""The taking of a recording: from pose to pose, at rest, look, write; and stop at once when anything is wrong."""

from collections.abc import Callable
from contextlib import suppress
from typing import final

import numpy as np

from robolaser.arrays import Array
from robolaser.cell.angles import posture, shown
from robolaser.cell.arm import Arm
from robolaser.cell.arrival import Mover
from robolaser.cell.camera import Camera, Image, Warn
from robolaser.cell.clock import Clock
from robolaser.cell.plan_validation import carried, violations
from robolaser.cell.recording_writer import IMAGE_OFF, Journal, Stay
from robolaser.cell.route import Visit, way
from robolaser.data.cell_config import Cell
from robolaser.errors import (
    ArmRestarted,
    MovedMeanwhile,
    PlanUnsafe,
    RecordingStopped,
    Restless,
    RobolaserError,
    unwritable,
)
from robolaser.geometry.kinematics import Robot

LIGHT_GREY = 40
"""By which a laser brightens some pixel at least, if it is seen: noise alone does by a dozen."""
SAGGED = np.deg2rad(1.0)
"""How far an arm gives way while its motors are off [rad or m]."""


def _nothing(what: str) -> None:
    """Nobody wants to know."""


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
        self._sure = arm.knows_itself or not cell.arm.home
        """Whether what is read means the angles that the arm has."""
        self._under_way = False

    def run(self, told: Callable[[Visit], None], begins: Callable[[str], None] = _nothing) -> None:
        """Visit all poses that remain.

        Args:
            told: Hears of each pose once it is safe on the disk.
            begins: Hears what is done next: homing, or the name of a pose.

        Raises:
            RecordingStopped: Something was wrong, or somebody pressed Ctrl-C. The arm was stopped; what is on the disk
                is a whole recording of the poses up to there.
            PlanUnsafe: Nothing was moved.
            MovedMeanwhile: Likewise: it is not known where the arm stands.
        """
        try:
            self._run(told, begins)
        except (PlanUnsafe, MovedMeanwhile):
            raise
        except BaseException as error:
            standing = self._stopped(error)
            raise self._why(error, standing) from None

    def _run(self, told: Callable[[Visit], None], begins: Callable[[str], None]) -> None:
        if self._cell.arm.home:
            begins("homing")
            self._arm.home()
            self._sure = True
        self._journal.read_in_steps(self._arm.step, self._warn)
        self._at = self._mover.resting("Before its first motion")
        if not self._arm.knows_itself and not self._cell.arm.home:
            self._see_unmoved(self._at)
        visits = self._journal.remaining
        self._check(self._at, visits)
        name = self._journal.unused("resumed" if self._journal.begun else "start")
        self._journal.add([Stay(name, self._now(), self._at)])
        self._under_way = True
        if self._cell.laser_output is not None:
            self._arm.light(self._cell.laser_output)
        for visit in visits:
            begins(visit.name)
            self._journal.add(self._visit(visit, self._at))
            told(visit)
        if self._cell.laser_output is not None:
            self._arm.dark(self._cell.laser_output)

    def _see_unmoved(self, at: Array) -> None:
        left = self._journal.left_at
        if left is not None and (np.abs(at - left) > SAGGED).any():
            joint = int(np.argmax(np.abs(at - left)))
            stands, stood = (shown(self._robot, joint, float(q[joint])) for q in (at, left))
            raise MovedMeanwhile(self._robot.joints[joint], stands, stood)

    def _check(self, start: Array, visits: tuple[Visit, ...]) -> None:
        if visits:
            tools = carried(self._cell.description)
            broken = violations(self._robot, self._cell.limits, tools, start, *way(visits))
            if broken:
                run_up = any(visit.approach is not None for visit in visits)
                raise PlanUnsafe([str(violation) for violation in broken], run_up=run_up)

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
        last = "" if self._at is None else f" It last rested at {posture(self._robot, self._at)}."
        stands: Array | None = None
        try:
            halted = self._mover.halt()
            if self._sure and not isinstance(cause, ArmRestarted):
                stands = self._at = halted
                said = f"The arm was stopped. It stands at {posture(self._robot, stands)}."
            else:
                said = f"The arm was stopped. It was not homed since it came on, so where it stands is not known.{last}"
        except (RobolaserError, KeyboardInterrupt) as error:
            why = "" if isinstance(error, type(cause)) else f" {error or 'Interrupted again.'}"
            said = (
                f"The arm could not be seen to stop.{why}{last} It goes no further than to the place it was on its way"
                " to; keep clear of it, and press its emergency button."
            )
        if self._cell.laser_output is not None:
            with suppress(RobolaserError, KeyboardInterrupt):
                self._arm.dark(self._cell.laser_output)
        if stands is not None and self._under_way:
            with suppress(RobolaserError, OSError, KeyboardInterrupt):  # where to go on from; the cause is said anyway
                self._journal.add([Stay(self._journal.unused("stopped"), self._now(), stands)])
        return said

    def _why(self, error: BaseException, standing: str) -> BaseException:
        if isinstance(error, KeyboardInterrupt):
            cause = "Stopped by hand."
        elif isinstance(error, OSError):
            cause = str(unwritable(self._journal.folder, error.strerror or str(error)))
        elif isinstance(error, RobolaserError):
            cause = str(error)
        else:
            return error
        done = self._journal.done if self._journal.begun else None
        return RecordingStopped(cause, standing, self._journal.folder, done, len(self._journal.visits))

    def _now(self) -> float:
        return self._clock.now() - self._began
