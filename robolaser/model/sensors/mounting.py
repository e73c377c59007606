"""Where a scanner sits, how large it sees and where its target lies, given what its camera and its sheet show."""

from dataclasses import dataclass
from typing import final

import numpy as np

from robolaser.arrays import Array, Bools
from robolaser.data.dataset import Dataset
from robolaser.estimation.elimination import placement, similarity
from robolaser.estimation.elimination.loop import Loops
from robolaser.geometry.rigid_motion import apply, from_quaternion, inverse
from robolaser.model.stages import Perturbation, Stage
from robolaser.parameters import Parameters, Values

SIMILARITY = ("b", "w", "phi", "psi", "t_x", "t_y", "t_z")
"""What a similarity fit gives: how large the scanner sees, how it is turned, and where it sits."""


@final
@dataclass(frozen=True)
class Mounting:
    """Baseline, hand-eye and, where it is not placed, the target's pose, of a data set's scanner.

    Attributes:
        dataset: What was measured.
        names: The parameters, `SIMILARITY` first.
        bounds: Theirs.
    """

    dataset: Dataset
    names: tuple[str, ...]
    bounds: Parameters

    def reference(self, values: Values) -> Array:
        """The baseline at which points are taken, (c,) [m]: the one among the values, or a usual one."""
        item = self.bounds.items[0]
        usual = item.nominal or max(item.lower, item.upper, key=abs) or 1.0
        b = np.broadcast_to(values.get("b", np.array([usual])), len(values["theta"]))
        return np.where(b != 0, b, usual)

    def found(self, seen: Array, reference: Array, T_base_flange: Array, perturb: Perturbation) -> Values:
        """What fits best within bounds, nominal values for candidates with a point at a pole.

        Points grow with the baseline, as they do exactly where the sheet is flat.

        Args:
            seen: Points in the camera frame, the baseline being `reference`, (c, m, 3) [m].
            reference: (c,) [m].
            T_base_flange: (c or 1, n, 4, 4).
            perturb: Effects; those of the mount are taken as if the camera's frame were the flange's.
        """
        pose, (lower, upper) = self.dataset.points.pose, (self.bounds.lower, self.bounds.upper)
        if perturb.touches(Stage.MOUNT):
            moved = perturb(Stage.MOUNT, np.eye(4)[None, None])
            seen = apply(np.broadcast_to(moved, (len(moved), len(self.dataset.poses), 4, 4))[:, pose], seen)
        scale = np.sort(np.outer(1.0 / reference, [lower[0], upper[0]]), axis=1)
        found = np.tile(self.bounds.nominal, (len(seen), 1))
        assert self.dataset.points.xyz is not None  # the folder's reader sees to it
        known = perturb(Stage.TARGET, self.dataset.points.xyz[None])
        good = np.isfinite(seen).all(axis=(1, 2)) & np.isfinite(T_base_flange).all(axis=(1, 2, 3))
        if np.any(good):
            T, known = (_some(batch, np.asarray(good)) for batch in (T_base_flange, known))
            fit = self._on_flange if self.dataset.placed else self._in_loop
            fitted = fit(seen[good], known, T[:, pose], scale[good])
            fitted[:, 0] *= reference[good]
            found[good] = np.where(np.isfinite(fitted), fitted, found[good])
        return dict(zip(self.names, np.clip(found, lower, upper).T, strict=True))

    def _on_flange(self, seen: Array, known: Array, T: Array, scale: Array) -> Array:
        low, high = self.bounds.lower, self.bounds.upper
        room = similarity.Room(
            self._bracket, self.dataset.angles, np.stack([low[1:4], high[1:4]]), np.stack([low[4:], high[4:]])
        )
        return similarity.fit(seen, apply(inverse(T), known), room, scale)

    def _in_loop(self, seen: Array, known: Array, T: Array, scale: Array) -> Array:
        loops = Loops.of(_with_one(known), _with_one(seen), T[..., :3, :3], T[..., :3, 3])
        ends = self.bounds.lower[1:], self.bounds.upper[1:], self.bounds.nominal[1:]
        return placement.place(loops, placement.Room(self._bracket, self.dataset.angles, *ends), scale)

    @property
    def _bracket(self) -> Array:
        return from_quaternion(np.array(self.dataset.bracket_quat))


def _with_one(points: Array) -> Array:
    return np.concatenate([points, np.ones((*points.shape[:-1], 1))], axis=-1)


def _some(batch: Array, good: Bools) -> Array:
    """Those of a batch that are good; what all candidates share, they go on sharing."""
    return batch if len(batch) == 1 else batch[good]
