"""Faults of the scanner: its camera, its line projector, and the bracket that holds it on the flange."""

from dataclasses import replace
from typing import Annotated, final

import numpy as np

from robolaser.arrays import Array, Ints
from robolaser.geometry.rigid_motion import exp_so3, pose
from robolaser.trials.synthetic.fault_model import Angle, Coin, FaultModel, SyntheticRun, Way, log_uniform, uniform
from robolaser.trials.synthetic.scanner import Light

NEAREST_M, FOCUSED_M = 0.01, 0.25
FAR_PX = (2.0, 40.0)


@final
class HigherRadialDistortion(FaultModel, effect="radial_distortion", sizes=(0.05, 0.9), signed=True, location="camera"):
    """OpenCV's second and third radial terms: k2 is `size`, k3 in proportion."""

    third: Annotated[float, lambda where, run, rng: float(rng.choice([0.0, rng.uniform(-2.0, 2.0)]))]  # k3 over k2

    def lens(self, terms: Array) -> Array:
        return np.asarray(terms + np.array([0.0, self.size, 0.0, 0.0, self.third * self.size]))


@final
class LensDecentring(FaultModel, effect="tangential_distortion", sizes=(5e-4, 1e-2), location="camera"):
    """The lens's elements are not on one axis: OpenCV's p1 and p2."""

    towards: Angle

    def lens(self, terms: Array) -> Array:
        side = self.size * np.array([np.cos(self.towards), np.sin(self.towards)])
        return np.asarray(terms + np.array([0.0, 0.0, *side, 0.0]))


@final
class FocusDrive(FaultModel, effect="focus_breathing", sizes=(3e-3, 5e-2), signed=True, location="camera"):
    """Autofocus moves the lens along its axis: the image grows by the share `size` for each doubling of the depth."""

    def zoom(self, depth: Array) -> Array:
        return np.asarray(self.size * np.log2(np.maximum(depth, NEAREST_M) / FOCUSED_M))


@final
class GrossErrors(FaultModel, effect="outliers", sizes=(0.01, 0.06), location="image"):
    """Glints and lost stripes: the share `size` of the points, or of their shots, is far off."""

    lasting: Coin  # whether all shots of a point are off, or only some

    def shots(self, pixel: Array, shot: Ints, rng: np.random.Generator) -> Array:
        points = np.unique(shot)
        hit = np.isin(shot, points[rng.random(len(points)) < self.size])
        if not self.lasting:
            hit = rng.random(len(shot)) < self.size
        group = shot if self.lasting else np.arange(len(shot))
        way = rng.uniform(-np.pi, np.pi, len(shot))[group]
        far = np.exp(rng.uniform(np.log(FAR_PX[0]), np.log(FAR_PX[1]), len(shot)))[group]
        return np.asarray(pixel + np.where(hit, far, 0.0)[:, None] * np.stack([np.cos(way), np.sin(way)], axis=-1))


@final
class ProjectorRoll(
    FaultModel, effect="laser_roll", sizes=(2e-3, 6e-2), signed=True, location="laser", parameter="angle"
):
    """The projector is turned about the view by `size` [rad]: the stripe is not parallel to the image's axis."""

    def light(self, light: Light, run: SyntheticRun) -> Light:
        return replace(light, roll=light.roll + self.size)


@final
class ConicalLight(
    FaultModel, effect="laser_curvature", sizes=(3e-3, 6e-2), signed=True, location="laser", parameter="cone"
):
    """The light is a shallow cone, by a rod lens that is not perpendicular to the beam.

    Its rays are off the plane by `size` [rad].
    """

    def light(self, light: Light, run: SyntheticRun) -> Light:
        return replace(light, cone=light.cone + self.size)


@final
class ProjectorWarmUp(FaultModel, effect="laser_drift", sizes=(2e-4, 3e-3), signed=True, location="laser"):
    """The beam's angle drifts until the projector is warm, by `size` [rad] in the end."""

    tau: Annotated[float, log_uniform(0.08, 1.0)]  # time constant, as a share of the run

    def values(self, run: SyntheticRun) -> dict[str, float]:
        return {"angle": self.size, "tau": self.tau}

    def light(self, light: Light, run: SyntheticRun) -> Light:
        return replace(light, theta=light.theta + self.size * run.warmed(self.tau))


@final
class FlankBias(FaultModel, effect="stripe_bias", sizes=(0.1, 2.0), signed=True, location="laser"):
    """One flank of the stripe is brighter: its centre is off by about `size` pixels on a surface tilted by 45°."""

    steep: Coin  # whether it is proportional to the tangent of the tilt or to its sine

    def stripe(self, tilt: Array) -> Array:
        return self.size * (np.tan(tilt) if self.steep else np.sin(tilt))


@final
class BracketCreep(FaultModel, effect="hand_eye_drift", sizes=(3e-4, 3e-3), location="hand_eye"):
    """The camera moves on its bracket, in proportion to the time or to its logarithm."""

    # time until it slows down, as a share of the run; 0: never
    settling: Annotated[float, lambda where, run, rng: float(rng.choice([0.0, rng.uniform(0.02, 0.3)]))]
    way: Way

    def mount(self, T_flange_camera: Array, run: SyntheticRun) -> Array:
        """Off by up to `size` [m] and radians at the end."""
        s = self.settling
        share = np.log1p(run.share / s) / np.log1p(1.0 / s) if s else run.share
        way = self.size * share[:, None] * np.array(self.way)
        moved = T_flange_camera.copy()
        moved[:, :3, 3] += way[:, :3]
        moved[:, :3, :3] = moved[:, :3, :3] @ exp_so3(way[:, 3:])
        return moved


@final
class SlippedBracket(FaultModel, effect="mount_shift", sizes=(3e-4, 3e-3), location="hand_eye"):
    """The bracket slips at some instant of the run, and creeps on a little."""

    moment: Annotated[float, uniform(0.2, 0.8)]  # as a share of the run
    way: Way

    def mount(self, T_flange_camera: Array, run: SyntheticRun) -> Array:
        """Off by up to `size` [m] and radians from then on, and a twentieth more at the end of the run."""
        later = run.share > self.moment
        way = (self.size * later * (1.0 + 0.05 * run.share))[:, None] * np.array(self.way)
        return np.asarray(pose(exp_so3(way[:, 3:]), way[:, :3]) @ T_flange_camera)


@final
class DroopingBracket(FaultModel, effect="hand_eye_sag", sizes=(2e-4, 2e-3), location="hand_eye"):
    """The bracket is a beam from the flange to the camera, which the camera's weight bends.

    Gere, Timoshenko, Mechanics of Materials: the end of a cantilever of length L sinks by d and turns by 3 d / (2 L).
    """

    along: Annotated[float, uniform(0.5, 1.0)]  # compliance along the beam over that across it

    def mount(self, T_flange_camera: Array, run: SyntheticRun) -> Array:
        """Sunk by `size` [m] where the weight is across the beam, and turned by as much as that bends it."""
        gravity = np.array(run.robot.gravity)
        down = np.einsum("nba,b->na", run.arm.forward(run.q)[:, :3, :3], gravity / np.linalg.norm(gravity))
        beam = T_flange_camera[:, :3, 3]
        length = np.linalg.norm(beam, axis=1, keepdims=True)
        inline = (beam * down).sum(axis=1, keepdims=True) * beam / length**2
        moved = T_flange_camera.copy()
        moved[:, :3, 3] += self.size * (down - (1.0 - self.along) * inline)
        moved[:, :3, :3] = exp_so3(1.5 * self.size / length**2 * np.cross(beam, down)) @ moved[:, :3, :3]
        return moved
