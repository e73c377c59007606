"""The world that an emulated cell holds: the true arm, scanner and things, and where they stand now."""

import zlib
from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from typing import final

import numpy as np
from scipy.spatial.transform import Rotation

from robolaser.arrays import Array
from robolaser.emulator.physics import Departure
from robolaser.emulator.rendering import Checkerboard, Eye, Photograph, Scene, Sheet
from robolaser.emulator.rendering.photograph import NOISE_GREY, SPECKLE, WHITE_GREY, expose
from robolaser.emulator.rendering.radiance_image import Painting, paint
from robolaser.emulator.rendering.view import View
from robolaser.trials.worlds.arm import Arm

SAME_PLACE_M = 1e-5  # the camera's place, and its turn in radians, within which speckle stays the same


@final
@dataclass(frozen=True)
class Sensor:
    """What the camera makes of light.

    Attributes:
        ambient_grey: Of white paper in the room's light.
        noise_grey: Standard deviation of the noise at middle grey.
        speckle: Contrast of the laser's speckle.
        blur_px: Standard deviation of the lens's blur [px].
        exposure: Factor on all light.
    """

    ambient_grey: float = WHITE_GREY
    noise_grey: float = NOISE_GREY
    speckle: float = SPECKLE
    blur_px: float = 0.6
    exposure: float = 1.0


@final
class World:
    """A world, as it stands; play in the gears remembers the way it came.

    Args:
        arm: As its URDF has it.
        eye: The camera as it was built.
        sheet: The light as drawn, with the true base and angle.
        scene: Solids in the base frame.
        sensor: What the camera makes of light.
        departures: In what the cell is not what its model says, in the order in which they act.
    """

    def __init__(
        self, arm: Arm, eye: Eye, sheet: Sheet, scene: Scene, sensor: Sensor, departures: Sequence[Departure] = ()
    ) -> None:
        self.arm, self.eye, self.scene, self.sensor = arm, eye, scene, sensor
        self.departures = tuple(departures)
        for departure in self.departures:
            sheet = departure.light(sheet)
        self.sheet = sheet
        self._columns = [self._column(departure) for departure in self.departures]
        self._motor: Array | None = None
        self._hanging = [0.0] * len(self.departures)
        self._painted: dict[bool, tuple[bytes, Painting]] = {}

    def follow(self, motor: Array) -> None:
        """Go on to where the encoders are now, straight from where they were, (j,) [rad].

        The first call puts the arm there, in the middle of all play.
        """
        motor = np.asarray(motor, dtype=np.float64)
        if self._motor is not None and not np.array_equal(motor, self._motor):
            for i, (departure, column) in enumerate(zip(self.departures, self._columns, strict=True)):
                now, last = float(motor[column]), float(self._motor[column])
                self._hanging[i] = departure.follow(now, last, self._hanging[i])
        self._motor = motor.copy()

    @property
    def q(self) -> Array:
        """True joint angles, (j,) [rad]; the arm is at zero until it was told to follow."""
        q = np.zeros(self.arm.count) if self._motor is None else self._motor
        for departure, column, hanging in zip(self.departures, self._columns, self._hanging, strict=True):
            q = departure.joints(q, column, hanging, self.arm)
        return q

    @property
    def T_base_flange(self) -> Array:  # noqa: N802 - the field's symbol
        """True pose of the flange, (4, 4)."""
        T: Array = self.arm.forward(self.q[None])[0]
        return T

    @property
    def T_base_camera(self) -> Array:  # noqa: N802 - the field's symbol
        """True pose of the camera, (4, 4)."""
        T: Array = self.T_base_flange @ self.eye.mount
        return T

    def photograph(self, rng: np.random.Generator, *, lit: bool, exposure: float = 1.0) -> Photograph:
        """Take a picture from where the arm stands: fresh noise in each, the same speckle while nothing moves.

        Args:
            rng: Where the noise comes from.
            lit: Whether the laser is on.
            exposure: Factor on all light, besides the sensor's own.
        """
        T = self.T_base_camera
        painting = self._paint(T, lit=lit)
        grain = np.random.default_rng(zlib.crc32(np.rint(T / SAME_PLACE_M).astype(np.int64).tobytes()))
        sensor = self.sensor
        return expose(
            painting,
            rng=rng,
            grain=grain,
            exposure=exposure * sensor.exposure,
            ambient=sensor.ambient_grey,
            noise_grey=sensor.noise_grey,
            speckle=sensor.speckle,
        )

    def truth(self) -> dict[str, float]:
        """The true numbers, by the names that a calibration and a diagnosis give them, SI.

        The scanner's fourteen; the board's placement, `target.x` to `target.psi`, if there is one; each departure as
        `NAME:WHERE`.
        """
        target: Mapping[str, float] = {}
        boards = [solid for solid in self.scene.solids if isinstance(solid, Checkerboard)]
        for board in boards[:1]:
            T = board.T_base_board
            turns = Rotation.from_matrix(T[:3, :3]).as_euler("XYZ")
            names = ("x", "y", "z", "w", "phi", "psi")
            target = {f"target.{name}": float(value) for name, value in zip(names, [*T[:3, 3], *turns], strict=True)}
        departures = {f"{departure.name}:{departure.where}": departure.size for departure in self.departures}
        return {**self.eye.truth, **target, **departures}

    def _paint(self, T_base_camera: Array, *, lit: bool) -> Painting:
        place = T_base_camera.tobytes()
        if lit not in self._painted or self._painted[lit][0] != place:
            view = View(self.scene, self.eye, T_base_camera)
            self._painted[lit] = place, paint(view, self.sheet, lit=lit, blur_px=self.sensor.blur_px)
        return self._painted[lit][1]

    def _column(self, departure: Departure) -> int:
        return self.arm.columns[self.arm.joints.index(departure.where)] if departure.on_joints else 0
