"""A stripe scanner as far as its own parts need to know it."""

from typing import Protocol

from robolaser.arrays import Array
from robolaser.data.dataset import Dataset
from robolaser.model.stages import Perturbation
from robolaser.parameters import Values


class StripeScanner(Protocol):
    """Where pixels of the stripe and target points lie."""

    dataset: Dataset

    def mount(self, values: Values, perturb: Perturbation) -> Array:
        """T_flange_camera, (c, n or 1, 4, 4)."""

    def in_camera(self, values: Values, perturb: Perturbation, pixel: Array | None = None) -> Array:
        """Points on the laser plane that the pixels show, in the camera frame, (c, m, 3) [m]."""

    def in_base(self, values: Values, T_base_flange: Array, perturb: Perturbation, pixel: Array | None = None) -> Array:
        """The same in the base frame."""

    def target(self, values: Values, perturb: Perturbation) -> Array:
        """The target points, in the base frame, (c, m, 3) [m]."""

    def initialize(self, values: Values, T_base_flange: Array, perturb: Perturbation) -> Values:
        """T_base_target of an unplaced target."""
