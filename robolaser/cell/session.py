"""The recorders: one moves the arm to each pose and stops it at any fault, one records an arm moved by others."""

from collections.abc import Callable
from contextlib import suppress
from typing import final

import numpy as np

from robolaser.arrays import Array, Image
from robolaser.cell.arm import Arm
from robolaser.cell.camera import Camera, Warn
from robolaser.cell.clock import Clock
from robolaser.cell.failures import ArmRestarted, at_worst, configuration_text, not_settled
from robolaser.cell.following import SetpointStreamer
from robolaser.cell.motion import Mover
from robolaser.cell.plan_validation import RouteCheck
from robolaser.cell.recording_writer import RecordingWriter, Sample
from robolaser.cell.route import Waypoint, pose_names
from robolaser.data.cell_config import Cell
from robolaser.data.image_list import UNLIT
from robolaser.errors import Interrupted, PlanError, RobolaserError, unwritable

LIGHT_GREY = 40  # least brightening of some pixel by a visible laser; noise causes a dozen
SAGGED = np.deg2rad(1.0)  # largest sag of an arm while its motors are off [rad or m]


@final
class Session:
    """One arm, one camera, one recording."""

    def __init__(
        self,
        cell: Cell,
        arm: Arm,
        camera: Camera,
        writer: RecordingWriter,
        clock: Clock,
        warn: Warn,
        *,
        position_confirmed: bool = False,
    ) -> None:
        self._cell = cell
        self._robot = robot = cell.robot
        self._arm = arm
        self._camera = camera
        self._writer = writer
        self._clock = clock
        self._warn = warn
        self._position_confirmed = position_confirmed
        self._mover = Mover(arm, robot, cell.limits.speed_rad_s, clock, cell.arm.unattended_s)
        hz, speed = cell.arm.setpoint_hz, cell.limits.speed_rad_s
        self._streamer = None if hz is None else SetpointStreamer(arm, robot, speed, clock, hz)
        self._began = clock.now() - writer.time_s
        self._at: Array | None = None
        self._sure = arm.absolute_encoders or not cell.arm.home  # whether readings are valid angles
        self._under_way = False

    def run(self, recorded: Callable[[Waypoint], None], begins: Callable[[str], None] = lambda what: None) -> None:
        """Visit all poses that remain; announce homing and poses as they begin, and each pose once it is on the disk.

        Raises:
            Interrupted: A fault, or Ctrl-C. The arm was stopped; the disk has a complete recording of the poses up to
                there.
            PlanError: Nothing was moved: the plan is not safe, or the arm's position is not known.
        """
        try:
            self._run(recorded, begins)
        except PlanError:
            raise
        except BaseException as error:
            raise self._why(error, self._stopped(error)) from None

    def _run(self, recorded: Callable[[Waypoint], None], begins: Callable[[str], None]) -> None:
        if self._cell.arm.home:
            begins("homing")
            self._arm.home()
            self._sure = True
        self._writer.state_quantization_noise(self._arm.step, self._warn)
        self._at = self._mover.resting("Before its first motion")
        if not (self._arm.absolute_encoders or self._cell.arm.home or self._position_confirmed):
            self._check_unmoved(self._at)
        waypoints = self._writer.remaining
        RouteCheck.of(self._cell).check(self._at, waypoints)
        name = self._writer.unused("resumed" if self._writer.begun else "start")
        self._writer.add([Sample(name, self._now(), self._at)])
        self._under_way = True
        self._light(on=True)
        for waypoint in waypoints:
            begins(waypoint.name)
            samples = self._record_pose(waypoint, self._at)
            self._writer.add(samples, self._streamer.taken() if self._streamer else ())
            recorded(waypoint)
        self._light(on=False)

    def _light(self, *, on: bool) -> None:
        """Switch the laser, if the controller can."""
        if self._cell.laser_output is not None:
            self._arm.switch(self._cell.laser_output, on=on)

    def _check_unmoved(self, at: Array) -> None:
        left = self._writer.last_position
        if left is not None and (np.abs(at - left) > SAGGED).any():
            joint, now, before = at_worst(self._robot, np.abs(at - left), at, left)
            raise PlanError(
                f"{joint} is at {now}, but was at {before} when this recording was"
                " interrupted. If the controller was switched off in between, its counts now mean other angles: home"
                " the arm (home = true in cell.toml, [arm]). If it was not, and you see the arm at"
                f" {configuration_text(self._robot, at)}, continue with --confirm-position."
            )

    def _record_pose(self, waypoint: Waypoint, at: Array) -> list[Sample]:
        samples: list[Sample] = []
        for name, goal in waypoint.places:
            if self._streamer is None:
                at = self._mover.move_and_wait(goal, name, at)
            else:
                at = self._streamer.move(goal, name)
            self._at = at
            samples.append(Sample(name, self._now(), at))
        if self._streamer is not None:
            at = self._at = self._streamer.rest(waypoint.name)
        settle_s = self._cell.camera.settle_s
        images = {"image": self._camera.shot(settle_s)}
        time_s = self._now()
        images |= {f"image_{k}": self._camera.shot(0.0) for k in range(2, self._writer.shots + 1)}
        if self._cell.laser_output is not None:
            self._light(on=False)
            images[UNLIT] = self._camera.shot(settle_s)
            self._light(on=True)
            self._check_laser(waypoint, images["image"], images[UNLIT])
        self._check_rest(waypoint, at)
        return [*samples[:-1], Sample(waypoint.name, time_s, at, images)]

    def _check_laser(self, waypoint: Waypoint, on: Image, off: Image) -> None:
        if int((on.astype(np.int16) - off).max()) < LIGHT_GREY:
            self._warn(
                f"{waypoint.name}: the laser makes no difference to the image."
                " Is it on and in view, or is the camera later than settle_s in cell.toml?"
            )

    def _check_rest(self, waypoint: Waypoint, before: Array) -> None:
        moved = np.abs(self._mover.resting(f"At {waypoint.name}") - before)
        if (moved > self._mover.near).any():
            worst = at_worst(self._robot, moved / self._mover.near, moved)
            raise not_settled(f"During the shots at {waypoint.name}", *worst)

    def _stopped(self, cause: BaseException) -> str:
        """Stop the arm, then the laser, and describe where the arm is."""
        last = "" if self._at is None else f" It last rested at {configuration_text(self._robot, self._at)}."
        rest: Array | None = None
        try:
            restarted = isinstance(cause, ArmRestarted)
            halted = self._mover.halt(restarted=restarted)
            if self._sure and not restarted:
                rest = self._at = halted
                outcome = f"The arm was stopped. It is at {configuration_text(self._robot, rest)}."
            else:
                outcome = f"The arm was stopped. It was not homed since it came on, so its position is not known.{last}"
        except (RobolaserError, KeyboardInterrupt) as error:
            why = "" if type(error) is type(cause) else f" {error or 'Interrupted again.'}"
            outcome = (
                f"The arm could not be seen to stop.{why}{last} It goes no further than to its next stop; keep clear of"
                " it, and press its emergency button."
            )
        with suppress(RobolaserError, KeyboardInterrupt):
            self._light(on=False)
        if rest is not None and self._under_way:
            with suppress(RobolaserError, OSError, KeyboardInterrupt):  # where to resume; the cause is raised anyway
                self._writer.add([Sample(self._writer.unused("stopped"), self._now(), rest)])
        return outcome

    def _why(self, error: BaseException, standing: str) -> BaseException:
        if isinstance(error, KeyboardInterrupt):
            cause = "Stopped by hand."
        elif isinstance(error, OSError):
            cause = str(unwritable(self._writer.folder, error.strerror or str(error)))
        elif isinstance(error, RobolaserError):
            cause = str(error)
        else:
            return error
        kept = "Nothing was recorded yet."
        if self._writer.begun:
            kept = f"{self._writer.done} of {len(self._writer.waypoints)} poses are in {self._writer.folder}."
            kept += " Continue with the next pose by --resume."
        return Interrupted(f"{cause}\n{standing}\n{kept}")

    def _now(self) -> float:
        return self._clock.now() - self._began


AT_A_TIME_S = 2.0  # that a crash may lose; each write interrupts the recording briefly


def watch(
    arm: Arm,
    camera: Camera,
    writer: RecordingWriter,
    clock: Clock,
    count: int,
    laser_output: int | None,
    recorded: Callable[[str], None],
    settle_s: float = 0.0,
) -> None:
    """Take images one after the other, and read the joints before and after each. Nothing is moved.

    An image's time is that of its arrival. The angles then, and their velocities, are interpolated between both
    readings. The unknown delay from exposure to arrival is found by the effect `latency`.

    Args:
        arm: Moved by others.
        camera: A live camera.
        writer: Of a recording without a plan; it is complete also after an error of arm, camera or disk.
        clock: Of the time stamps.
        count: Number of images.
        laser_output: The controller's output that is on meanwhile; None: none.
        recorded: Called with the name of each sample once it is on the disk.
        settle_s: Delay until the laser shows in the images [s].
    """
    began = clock.now()
    waiting: list[Sample] = []
    written_s = began
    try:
        if laser_output is not None:
            arm.switch(laser_output, on=True)
            camera.shot(settle_s)  # the first one may have been exposed before
        for name in pose_names("w", count):
            arm.poll_faults()
            before_s, before = _reading(arm, clock)
            image = camera.shot(0.0)
            came_s = clock.now()
            after_s, after = _reading(arm, clock)
            qd = (after - before) / (after_s - before_s)
            q = before + qd * (came_s - before_s)
            waiting.append(Sample(name, came_s - began, q, {"image": image}, qd))
            if clock.now() - written_s > AT_A_TIME_S:
                _write(writer, waiting, recorded)
                written_s = clock.now()
    finally:
        if laser_output is not None:
            with suppress(RobolaserError):
                arm.switch(laser_output, on=False)
        _write(writer, waiting, recorded)


def _reading(arm: Arm, clock: Clock) -> tuple[float, Array]:
    """Joint angles, (j,), and the middle of the time of reading [s]."""
    asked_s = clock.now()
    q = arm.read()
    return (asked_s + clock.now()) / 2, np.asarray(q)


def _write(writer: RecordingWriter, waiting: list[Sample], recorded: Callable[[str], None]) -> None:
    if waiting:
        writer.add(waiting)
        for sample in waiting:
            recorded(sample.name)
        waiting.clear()
