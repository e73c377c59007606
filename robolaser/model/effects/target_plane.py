"""The plane of a flat target, or of one with flat steps, and how a scanner's rays meet it."""

from dataclasses import dataclass
from typing import final

import numpy as np

from robolaser.arrays import Array
from robolaser.data.dataset import Dataset
from robolaser.geometry.camera import intersect, laser_plane, rays
from robolaser.geometry.rigid_motion import apply, rigid_fit
from robolaser.model.grouped_rows import group_means
from robolaser.model.sensors import scanner_geometry
from robolaser.model.stages import Perturbation

THIN = 0.05  # a target is flat where its planes are less thick than this share of their breadth
STEP = 0.01  # of the target's size along the normal: points farther apart are on different steps
GRAZING = 0.05  # cosine of the steepest tilt that is distinguished: 87°
FEWEST = 8  # points on each plane on average: any three are on one


@final
@dataclass(frozen=True, eq=False)
class TargetPlane:
    """The plane of a flat target, or of each step of a stepped one."""

    centre: Array  # middle of the points' extent along the axes of their frame, (3,) [m]
    # in its columns two axes in the plane and the normal, which points along the frame's axis next to it, (3, 3)
    axes: Array
    half: float  # half the larger extent in the plane [m]
    flatness: float  # thickness over the smaller breadth, as standard deviations; no plane where it is not small


def plane_of(xyz: Array) -> TargetPlane:
    """The plane of points (m, 3) [m], or of all steps where they are on parallel ones.

    Candidates are the plane through all points and the three across the frame's axes; the one with the thinnest steps
    is taken. Its axes are as near to the frame's as possible.
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
    return TargetPlane(centre, axes, half, flatness)


def _stepped(xyz: Array, guess: Array) -> tuple[Array, float]:
    """Normal and flatness of points on steps across a guessed normal; infinite where they determine no plane."""
    along = xyz @ guess
    order = np.argsort(along, kind="stable")
    size = float(np.ptp(xyz, axis=0).max())
    step = np.empty(len(xyz), dtype=np.int64)
    step[order] = np.cumsum(np.diff(along[order], prepend=along[order[0]]) > STEP * size)
    mean = group_means(xyz, step)
    if len(xyz) < FEWEST * len(mean) and len(mean) > 1:
        return guess, np.inf
    _, spread, axes = np.linalg.svd(xyz - mean[step], full_matrices=False)
    if len(spread) < 3 or spread[1] <= np.finfo(float).eps * size:
        return guess, np.inf
    return axes[2], float(spread[2] / spread[1])


def surface_tilt(dataset: Dataset, T_base_flange: Array, target: TargetPlane) -> Array:
    """Tangent of the angle from each ray back to the camera to the surface's normal, across the stripe, (m,).

    By the nominal model: a degree matters little to a bias of tenths of a pixel. If the target is not placed, its pose
    is the rigid fit of its points to the nominal model's.
    """
    points, unperturbed = dataset.points, Perturbation()
    nominal = {name: np.array([item.nominal]) for name, item in dataset.parameters.items()}
    image = scanner_geometry.in_image(points["pixel"][None], nominal, unperturbed)
    ray = rays(image, nominal["f"], dataset.stripe_axis)
    T_base_camera = (T_base_flange @ scanner_geometry.mount(dataset, nominal, unperturbed)[0])[points.pose]
    normal = target.axes[:, 2]
    if not dataset.placed:
        shown = apply(T_base_camera, intersect(ray, laser_plane(nominal))[0])
        finite = np.isfinite(shown).all(axis=1)
        normal = rigid_fit(points["xyz"][finite], shown[finite])[:3, :3] @ normal
    in_camera = np.einsum("mba,b->ma", T_base_camera[:, :3, :3], normal)
    back = -ray[0] / np.linalg.norm(ray[0], axis=-1, keepdims=True)
    in_camera *= np.sign((in_camera * back).sum(axis=-1, keepdims=True))
    cos = in_camera[:, 0] * back[:, 0] + in_camera[:, 2] * back[:, 2]
    sin = in_camera[:, 0] * back[:, 2] - in_camera[:, 2] * back[:, 0]
    return np.asarray(sin / np.maximum(cos, GRAZING))
