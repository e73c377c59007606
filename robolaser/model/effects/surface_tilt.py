"""How a flat target is tilted against the rays of a scanner that sees it."""

import numpy as np

from robolaser.arrays import Array
from robolaser.data.dataset import Dataset
from robolaser.geometry.camera import intersect, laser_plane, rays
from robolaser.geometry.rigid_motion import apply, rigid_fit
from robolaser.model.effects.target_plane import TargetPlane
from robolaser.model.sensors import scanner_geometry
from robolaser.model.stages import Perturbation

GRAZING = 0.05  # cosine of the steepest tilt that is distinguished: 87°


def surface_tilt(dataset: Dataset, T_base_flange: Array, target: TargetPlane) -> Array:
    """Tangent of the angle from each ray back to the camera to the surface's normal, across the stripe, (m,).

    By the nominal model: a degree more or less matters little to a bias of tenths of a pixel. Where the target is not
    placed, its pose is the rigid fit of its points to those of the nominal model.
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
