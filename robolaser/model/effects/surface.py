"""The surface that the stripe falls on: its plane, and how it is tilted against the view."""

from dataclasses import dataclass
from typing import final

import numpy as np

from robolaser.arrays import Array
from robolaser.data.dataset import Dataset
from robolaser.geometry import camera as optics
from robolaser.geometry.rigid_motion import apply, from_angles, from_quaternion, pose, rigid_fit

THIN = 0.05  # a target is flat where its planes are less thick than this share of their breadth
STEP = 0.01  # of the target's size along the normal: points farther apart lie on different steps
FEWEST = 8  # points on each plane on average: any three lie on one
GRAZING = 0.05  # cosine of the steepest tilt that is told apart: 87°


@final
@dataclass(frozen=True, eq=False)
class Plane:
    """The plane of a flat target, or of each step of a stepped one.

    Attributes:
        centre: Middle of the points' extent along the axes of their frame, (3,) [m].
        axes: In its columns two axes in the plane and the normal, which points along the frame's axis next to it,
            (3, 3).
        half: Half the larger extent in the plane [m].
        flatness: Thickness over the smaller breadth, as standard deviations; no plane where it is not small.
    """

    centre: Array
    axes: Array
    half: float
    flatness: float


def plane_of(xyz: Array) -> Plane:
    """The plane of points (m, 3) [m], or that of all steps where they lie on parallel ones.

    Of the plane through all points and the three across the frame's axes, the one is taken in whose steps the points
    are thinnest; its axes are as near to those of the frame as can be.
    """
    centre = (xyz.max(axis=0) + xyz.min(axis=0)) / 2
    through = np.linalg.svd(xyz - xyz.mean(axis=0), full_matrices=False)[2][-1]
    normal, flatness = min((_stepped(xyz, guess) for guess in (through, *np.eye(3))), key=lambda found: found[1])
    normal = normal * np.sign(normal[np.abs(normal).argmax()])
    first = np.eye(3)[0 if np.abs(normal).argmax() != 0 else 1]
    x = first - normal * (normal @ first)
    x /= np.linalg.norm(x)
    axes = np.column_stack([x, np.cross(normal, x), normal])
    half = float(np.ptp((xyz - centre) @ axes[:, :2], axis=0).max() / 2)
    return Plane(centre, axes, half, flatness)


def _stepped(xyz: Array, guess: Array) -> tuple[Array, float]:
    """Normal and flatness of points on steps across a guessed normal; infinite where they tell no plane."""
    along = xyz @ guess
    order = np.argsort(along, kind="stable")
    size = float(np.ptp(xyz, axis=0).max())
    step = np.empty(len(xyz), dtype=np.int64)
    step[order] = np.cumsum(np.diff(along[order], prepend=along[order[0]]) > STEP * size)
    count = np.bincount(step)
    if len(xyz) < FEWEST * len(count) and len(count) > 1:
        return guess, np.inf
    mean = np.stack([np.bincount(step, weights=column) / count for column in xyz.T], axis=-1)
    _, spread, axes = np.linalg.svd(xyz - mean[step], full_matrices=False)
    if len(spread) < 3 or spread[1] <= np.finfo(float).eps * size:
        return guess, np.inf
    return axes[2], float(spread[2] / spread[1])


def tilt_of(dataset: Dataset, T_base_flange: Array, target: Plane) -> Array:
    """Tangent of the angle from each ray back to the camera to the surface's normal, across the stripe, (m,).

    By the nominal model: a degree more or less matters little to a bias of tenths of a pixel. Where the target is not
    placed, its place is the rigid fit of its points to those of the nominal model.
    """
    points = dataset.points
    assert points.pixel is not None  # a stripe has both
    assert points.xyz is not None
    nominal = {name: np.array([item.nominal]) for name, item in dataset.parameters.items()}
    flat = optics.undistort(optics.metric(points.pixel[None], nominal), nominal["k"])
    ray = optics.rays(flat, nominal["f"], dataset.stripe_axis)
    turn = from_angles(nominal["w"], nominal["phi"], nominal["psi"], order=dataset.angles)
    shift = np.stack([nominal[f"t_{axis}"] for axis in "xyz"], axis=-1)
    T_flange_camera = pose(from_quaternion(np.array(dataset.bracket_quat)) @ turn, shift)[0]
    T_base_camera = (T_base_flange @ T_flange_camera)[points.pose]
    normal = target.axes[:, 2]
    if not dataset.placed:
        shown = apply(T_base_camera, optics.cut(ray, optics.sheet(nominal))[0])
        good = np.isfinite(shown).all(axis=1)
        normal = rigid_fit(points.xyz[good], shown[good])[:3, :3] @ normal
    in_camera = np.einsum("mba,b->ma", T_base_camera[:, :3, :3], normal)
    back = -ray[0] / np.linalg.norm(ray[0], axis=-1, keepdims=True)
    in_camera *= np.sign((in_camera * back).sum(axis=-1, keepdims=True))
    cos = in_camera[:, 0] * back[:, 0] + in_camera[:, 2] * back[:, 2]
    sin = in_camera[:, 0] * back[:, 2] - in_camera[:, 2] * back[:, 0]
    return np.asarray(sin / np.maximum(cos, GRAZING))
