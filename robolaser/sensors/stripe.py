"""A camera and a light sheet on the flange: a pixel of the stripe is a point in space."""

from functools import cached_property
from typing import ClassVar, final

import numpy as np

from robolaser import optics
from robolaser.arrays import Array, Bools
from robolaser.compiled import available
from robolaser.dataset import Dataset
from robolaser.elimination import placement, similarity
from robolaser.elimination.loop import Loops
from robolaser.parameters import Parameters, Values
from robolaser.se3 import apply, from_angles, from_quaternion, inverse, pose, rigid_fit
from robolaser.seams import Bend, Seam
from robolaser.sensors.chain import SCANNER, Chain
from robolaser.sensors.sensor import SIX, Sensor, motion, six_of

SIMILARITY = ("b", "w", "phi", "psi", "t_x", "t_y", "t_z")
"""Those that a similarity fit gives: how large the scanner sees, how it is turned, and where it sits."""

_Bounds = tuple[Array, Array, Array]
"""Lower and upper bounds and nominal values."""


@final
class Stripe(Sensor):
    """The laser scanner of the paper, eqs. 1-13, its target placed or not."""

    kind: ClassVar[str] = "stripe"

    def __init__(self, dataset: Dataset) -> None:
        super().__init__(dataset)
        assert dataset.points.pixel is not None  # the folder's reader sees to both
        assert dataset.points.xyz is not None
        self._pixel = dataset.points.pixel[None]
        self._xyz = dataset.points.xyz[None]

    @property
    def own(self) -> tuple[str, ...]:
        """The paper's fourteen."""
        return SCANNER

    @property
    def following(self) -> tuple[str, ...]:
        """T_base_target, where the target is not placed."""
        return () if self.dataset.placed else tuple(f"target.{part}" for part in SIX)

    @property
    def eliminated(self) -> tuple[str, ...]:
        """The scanner's place and size, a similarity fit given its camera and its sheet, and the target's pose."""
        return (*SIMILARITY, *self.following)

    @property
    def held(self) -> tuple[str, ...]:
        """The focal length: see `with_gauge_held`."""
        return ("f",)

    def with_gauge_held(self, values: Values) -> Values:
        """(f, s_u, s_v, k) → (c f, c s_u, c s_v, k/c²) changes no point: take c so that f is nominal."""
        c = self.dataset.parameters["f"].nominal / values["f"]
        scaled = {name: values[name] * c for name in ("f", "s_u", "s_v")}
        return {**values, **scaled, "k": values["k"] / c**2}

    def in_camera(self, values: Values, bend: Bend, pixel: Array | None = None) -> Array:
        """Points on the sheet that the pixels show, in the camera frame, (c, m, 3) [m]."""
        read = bend(Seam.PIXELS, self._pixel if pixel is None else pixel)
        flat = bend(Seam.IMAGE, optics.undistort(optics.metric(read, values), values["k"]))
        ray = optics.rays(flat, values["f"], self.dataset.stripe_axis)
        return bend(Seam.LIGHT, optics.cut(ray, bend(Seam.SHEET, optics.sheet(values))))

    def mount(self, values: Values, bend: Bend) -> Array:
        """T_flange_camera, (c, n or 1, 4, 4)."""
        bracket = from_quaternion(np.array(self.dataset.bracket_quat))
        turn = from_angles(values["w"], values["phi"], values["psi"], order=self.dataset.angles)
        shift = np.stack([values["t_x"], values["t_y"], values["t_z"]], axis=-1)
        return bend(Seam.MOUNT, pose(bracket @ turn, shift)[:, None])

    def in_base(self, values: Values, T_base_flange: Array, bend: Bend, pixel: Array | None = None) -> Array:
        """Points that the pixels show, in the base frame, (c, m, 3) [m]. Eqs. 9, 11, 13."""
        T_base_camera = T_base_flange @ self.mount(values, bend)
        return apply(T_base_camera[:, self.dataset.points.pose], self.in_camera(values, bend, pixel))

    def target(self, values: Values, bend: Bend) -> Array:
        """The target points, in the base frame, (c, m, 3) [m]."""
        points = bend(Seam.TARGET, self._xyz)
        return points if self.dataset.placed else apply(motion(values, "target")[:, None], points)

    def follow(self, values: Values, T_base_flange: Array, bend: Bend) -> Values:
        """T_base_target by a rigid fit; candidates with a pole among their points get the identity."""
        seen = self.in_base(values, T_base_flange, bend)
        known = np.broadcast_to(bend(Seam.TARGET, self._xyz), seen.shape)
        good = np.isfinite(seen).all(axis=(1, 2))
        T = np.broadcast_to(np.eye(4), (len(seen), 4, 4)).copy()
        if good.any():
            T[good] = rigid_fit(known[good], seen[good])
        return six_of(T, "target")

    def complete(self, values: Values, T_base_flange: Array, bend: Bend, bounds: Parameters) -> Values:
        """Baseline, hand-eye and target's pose that fit best within their bounds.

        Points grow with the baseline, as they do exactly where the sheet is flat; effects that break this, and those of
        the mount, are taken as they are at the `b` among the values.
        """
        names = self.eliminated
        columns = bounds.columns(names)
        lower, upper, nominal = bounds.lower[columns], bounds.upper[columns], bounds.nominal[columns]
        usual = nominal[0] if nominal[0] != 0 else max(abs(lower[0]), abs(upper[0]), np.finfo(float).tiny)
        reference = np.broadcast_to(values.get("b", np.array([usual])), len(values["theta"]))
        reference = np.where(reference != 0, reference, usual)
        seen = self.in_camera({**values, "b": reference}, bend)
        still = np.eye(4)[None, None]
        moved = bend(Seam.MOUNT, still)
        if moved is not still:
            seen = apply(moved[:, self.dataset.points.pose if moved.shape[1] > 1 else [0]], seen)
        good = np.asarray(np.isfinite(seen).all(axis=(1, 2)) & np.isfinite(T_base_flange).all(axis=(1, 2, 3)))
        scale = np.sort(np.outer(1.0 / reference, [lower[0], upper[0]]), axis=1)
        found = np.tile(nominal, (len(seen), 1))
        if good.any():
            T = _some(T_base_flange, good)[:, self.dataset.points.pose]
            known = _some(bend(Seam.TARGET, self._xyz), good)
            fitted = (self._on_flange if self.dataset.placed else self._in_loop)(
                seen[good], known, T, scale[good], (lower[1:], upper[1:], nominal[1:])
            )
            fitted[:, 0] *= reference[good]
            found[good] = np.where(np.isfinite(fitted), fitted, nominal)
        return dict(zip(names, np.clip(found, lower, upper).T, strict=True))

    def _on_flange(self, seen: Array, known: Array, T: Array, scale: Array, bounds: _Bounds) -> Array:
        in_flange = apply(inverse(T), known)
        lower, upper, _ = bounds
        bracket = from_quaternion(np.array(self.dataset.bracket_quat))
        angles, shift = np.stack([lower[:3], upper[:3]]), np.stack([lower[3:], upper[3:]])
        room = similarity.Room(bracket, self.dataset.angles, angles, shift)
        size, turned, moved = similarity.fit(similarity.Moments.of(seen, in_flange), room, scale)
        return np.column_stack([size, turned, moved])

    def _in_loop(self, seen: Array, known: Array, T: Array, scale: Array, bounds: _Bounds) -> Array:
        ones = np.ones((1, seen.shape[1], 1))
        chi, phi = (np.concatenate([of, np.broadcast_to(ones, (len(of), *ones.shape[1:]))], -1) for of in (known, seen))
        loops = Loops.of(chi, phi, T[..., :3, :3], T[..., :3, 3])
        bracket = from_quaternion(np.array(self.dataset.bracket_quat))
        return placement.place(loops, placement.Room(bracket, self.dataset.angles, *bounds), scale)

    @cached_property
    def _chain(self) -> Chain:
        return Chain(self.dataset)

    def residuals(self, values: Values, T_base_flange: Array, bend: Bend) -> Array:
        """E of eq. 17: target point less predicted point, in the base frame, (c, m, 3) [m]."""
        known = self.target(values, bend)
        if available() and not bend.touches(Seam.LIGHT):
            return self._chain.residuals(values, T_base_flange, bend, known)
        return known - self.in_base(values, T_base_flange, bend)

    def squares(self, values: Values, T_base_flange: Array, bend: Bend) -> Array:
        """J of eq. 18; in one go where the compiler can."""
        if available() and not bend.touches(Seam.LIGHT):
            return self._chain.squares(values, T_base_flange, bend, self.target(values, bend))
        return super().squares(values, T_base_flange, bend)

    def costs(self, own: Array, T_base_flange: Array) -> Array | None:
        """J where nothing bends the chain and the target is placed."""
        return self._chain.costs(own, T_base_flange) if self.dataset.placed and available() else None



def _some(batch: Array, good: Bools) -> Array:
    """Those of a batch that are good; what all candidates share, they go on sharing."""
    return batch if len(batch) == 1 else batch[good]
