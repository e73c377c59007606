"""The world that an emulated cell holds: the true arm, scanner and things, and where they stand now."""

import zlib
from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from typing import final

import numpy as np
from scipy.spatial.transform import Rotation

from robolaser.arrays import Array
from robolaser.emulator.rendering import CameraModel, Checkerboard, EmulatedScene, LaserSheet, Photograph
from robolaser.emulator.rendering.photograph import NOISE_GREY, SPECKLE, WHITE_GREY, expose
from robolaser.emulator.rendering.radiance_image import RadianceImage, render_radiance
from robolaser.emulator.rendering.scene_view import SceneView
from robolaser.emulator.world.faults import TrackedBacklash
from robolaser.trials.synthetic.arm import ScrewArm
from robolaser.trials.synthetic.fault_model import FaultModel
from robolaser.trials.synthetic.run import SyntheticRun

SAME_PLACE_M = 1e-5  # the camera's place, and its turn in radians, within which speckle stays the same


@final
@dataclass(frozen=True)
class ImageSensor:
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
class EmulatedWorld:
    """A world, as it stands; play in the gears remembers the way it came.

    Args:
        arm: As its URDF has it.
        eye: The camera as it was built.
        sheet: The light as drawn, with the true base and angle.
        scene: Solids in the base frame.
        sensor: What the camera makes of light.
        faults: In what the cell is not what its model says, in the order in which they act.
    """

    def __init__(
        self,
        arm: ScrewArm,
        eye: CameraModel,
        sheet: LaserSheet,
        scene: EmulatedScene,
        sensor: ImageSensor,
        faults: Sequence[FaultModel] = (),
    ) -> None:
        self.arm, self.eye, self.scene, self.sensor = arm, eye, scene, sensor
        self.faults = tuple(faults)
        self._motor: Array | None = None
        run = self._run(np.zeros(arm.count))
        surface = sheet.surface
        for fault in self.faults:
            surface = fault.light(surface, run)
        self.sheet = sheet.on(surface)
        self._rendered: dict[bool, tuple[bytes, RadianceImage]] = {}

    def follow(self, motor: Array) -> None:
        """Go on to where the encoders are now, straight from where they were, (j,) [rad].

        The first call puts the arm there, in the middle of all play.
        """
        motor = np.asarray(motor, dtype=np.float64)
        if self._motor is not None and not np.array_equal(motor, self._motor):
            moves, run = motor - self._motor, self._run(motor)
            self.faults = tuple(
                fault.moved(float(moves[run.column(fault.where)])) if isinstance(fault, TrackedBacklash) else fault
                for fault in self.faults
            )
        self._motor = motor.copy()

    @property
    def q(self) -> Array:
        """True joint angles, (j,) [rad]; the arm is at zero until it was told to follow."""
        run = self._run(np.zeros(self.arm.count) if self._motor is None else self._motor)
        q = run.q
        for fault in self.faults:
            q = fault.joints(q, run)
        one: Array = q[0]
        return one

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
        radiance = self._render(T, lit=lit)
        grain = np.random.default_rng(zlib.crc32(np.rint(T / SAME_PLACE_M).astype(np.int64).tobytes()))
        sensor = self.sensor
        return expose(
            radiance,
            rng=rng,
            grain=grain,
            exposure=exposure * sensor.exposure,
            ambient=sensor.ambient_grey,
            noise_grey=sensor.noise_grey,
            speckle=sensor.speckle,
        )

    def truth(self) -> dict[str, float]:
        """The true numbers, by the names that a calibration and a diagnosis give them, SI.

        The scanner's fourteen; the board's placement, `target.x` to `target.psi`, if there is one; each fault as
        `NAME:WHERE`.
        """
        target: Mapping[str, float] = {}
        boards = [solid for solid in self.scene.solids if isinstance(solid, Checkerboard)]
        for board in boards[:1]:
            T = board.T_base_board
            turns = Rotation.from_matrix(T[:3, :3]).as_euler("XYZ")
            names = ("x", "y", "z", "w", "phi", "psi")
            target = {f"target.{name}": float(value) for name, value in zip(names, [*T[:3, 3], *turns], strict=True)}
        faults = {f"{fault.effect}:{fault.where}": fault.size for fault in self.faults}
        return {**self.eye.truth, **target, **faults}

    def _render(self, T_base_camera: Array, *, lit: bool) -> RadianceImage:
        place = T_base_camera.tobytes()
        if lit not in self._rendered or self._rendered[lit][0] != place:
            view = SceneView(self.scene, self.eye, T_base_camera)
            self._rendered[lit] = place, render_radiance(view, self.sheet, lit=lit, blur_px=self.sensor.blur_px)
        return self._rendered[lit][1]

    def _run(self, motor: Array) -> SyntheticRun:
        """What a fault may depend on, at rest at one configuration."""
        q = motor[None]
        return SyntheticRun(self.arm, q, np.zeros_like(q), np.zeros(1), np.zeros(3), radius=1.0, payload_kg=0.0)
