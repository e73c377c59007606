"""Rows that are linear in the numbers of effects: torques against inverse dynamics, one encoder against another."""

from collections.abc import Sequence
from typing import final

import numpy as np

from robolaser.arrays import Array, Bools, Ints
from robolaser.motion.effect import UNKNOWN, At, MotionEffect
from robolaser.motion.effects.dynamics import TORQUE_CONSTANT
from robolaser.motion.evidence import IDEAL_SHARE, Fitted, independent_values, of_each, score_of
from robolaser.motion.gap import less_means, root_mean_squares
from robolaser.motion.quantities import Quantities

ROUNDS = 3  # of weights and numbers
SCALE_ROUNDS = 12  # the same where torques have a scale: it multiplies masses, so they are not linear
SIGMAS = 2.0  # by which an estimated mass or moment of inertia may be negative
UNCOUNTED = {"torque": ("clock_shift", "payload"), "load": ("gear_ripple",)}
"""Effects that are left out where effective sample sizes are estimated, by the kind of rows. A judgement: with the
clock among the others, the torque error of a real arm on unseen motions is 194 instead of 179 Nm."""
PRIOR_SHARE = 3.0  # of the values to explain, that one number may contribute: others would have to cancel it


@final
class LinearRows:
    """Models of rows by least squares; all joints at once, since they share payloads and clocks.

    Args:
        of: Rows and the quantities for columns.
        values: To be explained, (n, j); NaN where there is none.
        candidates: Effects that may explain it.
        used: Rows that count, (n, j) or (n, 1); all by default.
        like: The same rows, all of them, whose effective sample size and form hold here, too.
        form: Error of the models' form, (j,).
    """

    def __init__(
        self,
        of: Quantities,
        values: Array,
        candidates: Sequence[At],
        used: Bools | None = None,
        like: "LinearRows | None" = None,
        form: Array | float = 0.0,
    ) -> None:
        self.of, self.values, self.candidates = of, values, tuple(candidates)
        self._there = np.isfinite(values) & (True if used is None else used)
        self.rows = self._there.sum(axis=0).astype(np.float64)  # number of rows of each joint, (j,)
        self._blocks: dict[tuple[str, int], slice] = {}
        joints = range(values.shape[1])
        columns: list[Array] = []
        prior: list[Array] = []
        of_column: list[At] = []
        for one in self.candidates:
            assert one.effect.columns is not None
            for shape, block in enumerate(one.effect.columns(of, one.joint)):
                start = sum(len(each) for each in prior)
                self._blocks[str(one), shape] = slice(start, start + block.shape[-1])
                columns.append(block)
                of_column += [one] * block.shape[-1]
                physical = np.inf if one.effect.sizes is None else one.effect.sizes(of, one.joint)
                prior.append(self._prior_of(block) + 1.0 / np.square(physical))
        self._columns = np.concatenate(columns, axis=2) if columns else np.empty((*values.shape, 0))
        self._prior = np.concatenate(prior) if prior else np.empty(0)
        is_scale = np.array([one.effect.name == TORQUE_CONSTANT.name for one in of_column], dtype=bool)
        self._masses = np.array([one.effect.cause == "dynamics" for one in of_column], dtype=bool) & ~is_scale
        acts = [[one.effect.site != "joint" or one.joint == j for one in of_column] for j in joints]
        self._scales = (np.array(acts, dtype=bool) & is_scale).T  # at which joints, (k, j)
        names = [name for name, _ in self._blocks]
        self._tried = {name: names.count(name) for name in names}
        self._grams = [self._gram(joint) for joint in joints]
        self.independent: Array = (
            self.rows.copy() if like is None else like.independent * self.rows / np.maximum(like.rows, 1)
        )
        """Effective sample size of each joint's rows, (j,)."""
        self.is_scaled: bool = like is not None and like.is_scaled
        """Whether scales of torques multiply masses: models are not linear then."""
        self._shapes: dict[str, int] = {}
        self._form: Array = np.hypot(IDEAL_SHARE * root_mean_squares(values), form) if like is None else like._form

    def _prior_of(self, block: Array) -> Array:
        """Precision of numbers, by what they contribute where there are values, (n, j, k) -> (k,)."""
        there = self._there & np.any(block != 0.0, axis=2)
        if not there.any():
            return np.ones(block.shape[-1])
        wanted = np.mean(self.values[there] ** 2)
        return np.asarray(np.maximum(np.mean(block[there] ** 2, axis=0), 1e-24) / (PRIOR_SHARE**2 * max(wanted, 1e-24)))

    def _gram(self, joint: int) -> tuple[Array, Array, float]:
        there = self._there[:, joint]
        A, y = self._columns[there, joint], self.values[there, joint]
        A, y = self._less_constants(A, there), self._less_constants(y, there)
        return A.T @ A, A.T @ y, float(y @ y)

    def _less_constants(self, values: Array, there: Bools | slice = slice(None)) -> Array:
        """Values less the constants of each run, or of all where encoders keep their zeros; torques have none then."""
        if self.of.log.offset_per_series:
            return less_means(values, self.of.run[there])
        return values if self.of.kind == "torque" else less_means(values, np.zeros(len(values), dtype=np.int64))

    def count_memory(self) -> None:
        """Estimate the effective sample sizes, from the residuals of a model with every effect that counts for them."""
        known = [one for one in self.candidates if one.effect.cause != UNKNOWN]
        full = [one for one in known if one.effect.name not in UNCOUNTED[self.of.kind]]
        left = self.residuals(self.fitted(tuple(full), (0,) * len(full)))
        for joint in np.flatnonzero(self.rows > 0):
            there = self._there[:, joint]
            self.independent[joint] = independent_values(left[there, joint], self.of.run[there])

    def fit(self, requests: Sequence[tuple[int, tuple[At, ...]]]) -> list[Fitted]:
        """A model with each set of effects, each in its best shape; one search is for all joints."""
        return [self._best(effects) for _, effects in requests]

    def _best(self, effects: tuple[At, ...]) -> Fitted:
        """The model in the best shape of the last effect; the shapes of the others are known."""
        if not effects:
            return self.fitted((), ())
        *others, last = map(str, effects)
        known = [self._shapes.get(name, 0) for name in others]
        fits = [self.fitted(effects, (*known, shape)) for name, shape in self._blocks if name == last]
        best = min(fits, key=lambda fit: fit.score)
        self._shapes[last] = best.shapes[-1]
        return best

    def fitted(self, effects: tuple[At, ...], shapes: tuple[int, ...]) -> Fitted:
        """The model with effects in given shapes."""
        chosen = self._chosen(effects, shapes)
        squares = np.array([yy for *_, yy in self._grams])
        x, std, P, worth = np.zeros(len(chosen)), np.empty(0), np.diag(self._prior[chosen]), 0.0
        for _ in range((SCALE_ROUNDS if self.is_scaled else ROUNDS) if len(chosen) else 0):
            b, G, inverse, scale = self._solved(chosen, x, squares)
            x = scale * (inverse @ (scale * b))
            std = scale * np.sqrt(np.diag(inverse))
            worth = float(np.sum(inverse * (G * scale[:, None] * scale)))
            squares = self._squares(chosen, x)
        tried = sum(2.0 * np.log(self._tried[str(one)]) + one.effect.rarity for one in effects)
        score, exact = (
            score_of(squares, self.rows, self.independent, form, worth) + float(x @ P @ x) + tried
            for form in (self._form, np.zeros_like(self._form))
        )
        numbers, most = (of_each(effects, values) for values in (x, x + SIGMAS * std))
        if not all(map(self._is_possible, effects, numbers, most)):
            score = exact = float("inf")
        return Fitted(effects, numbers, shapes, score, squares, exact)

    def _chosen(self, effects: Sequence[At], shapes: Sequence[int]) -> Ints:
        """Columns of effects in given shapes."""
        blocks = [self._blocks[str(one), shape] for one, shape in zip(effects, shapes, strict=True)]
        return np.concatenate([np.empty(0, dtype=np.int64), *(np.arange(one.start, one.stop) for one in blocks)])

    def _numbers_of(self, fitted: Fitted) -> tuple[Ints, Array]:
        """The columns of a model, and its numbers, (k,)."""
        return self._chosen(fitted.effects, fitted.shapes), np.concatenate([np.empty(0), *fitted.numbers])

    def has_scaled_masses(self, fitted: Fitted) -> bool:
        """Whether a model has masses and a scale of torques that multiplies them."""
        chosen = self._chosen(fitted.effects, fitted.shapes)
        return bool(self._masses[chosen].any() and self._scales[chosen].any())

    def _read(self, chosen: Ints, x: Array) -> Array:
        """Numbers as they act on the torques of each joint, (j, k): masses times the scale of these torques."""
        return np.where(self._masses[chosen], 1.0 + (x @ (self._scales[chosen] & self.is_scaled))[:, None], 1.0) * x

    def _squares(self, chosen: Ints, x: Array) -> Array:
        """Sum of squared residuals of each joint, (j,)."""
        return np.array(
            [
                max(0.0, yy - 2.0 * z @ by[chosen] + z @ A[chosen[:, None], chosen] @ z)
                for z, (A, by, yy) in zip(self._read(chosen, x), self._grams, strict=True)
            ]
        )

    def _solved(self, chosen: Ints, x: Array, squares: Array) -> tuple[Array, Array, Array, Array]:
        """Right side of a step from given numbers, information, scaled inverse of it and the prior, and its scale."""
        weight = np.where(self.rows > 0, self.independent / np.maximum(squares, 1e-24), 0.0)
        G, b = np.zeros((len(x), len(x))), np.zeros(len(x))
        masses = self._masses[chosen]
        for w, z, scales, (A, by, _) in zip(
            weight, self._read(chosen, x), (self._scales[chosen] & self.is_scaled).T, self._grams, strict=True
        ):
            inside, right = A[chosen[:, None], chosen], by[chosen]
            if not scales.any():  # z is x
                b, G = b + w * right, G + w * inside
                continue
            T = np.diag(np.where(masses, 1.0 + x @ scales, 1.0)) + np.outer(masses * x, scales)  # slopes of z by x
            b += w * T.T @ (right - inside @ (z - T @ x))
            G += w * T.T @ inside @ T
        H = G + np.diag(self._prior[chosen])
        scale = 1.0 / np.sqrt(np.diag(H))
        inverse = np.linalg.inv(H * scale[:, None] * scale + 1e-12 * np.eye(len(H)))
        return b, G, np.asarray(inverse), scale

    def _is_possible(self, one: At, values: Array, most: Array) -> bool:
        """Whether an effect has numbers within their bounds, and physical ones within their errors."""
        within = all(n.lower <= value <= n.upper for n, value in zip(one.effect.numbers, values, strict=True))
        return within and (one.effect.least is None or bool((most >= one.effect.least(self.of, one.joint)).all()))

    def columns(self, at: At, shape: int) -> Array:
        """Columns of an effect in one of its shapes, (n, j, k)."""
        return self._columns[:, :, self._blocks[str(at), shape]]

    def predicted(self, fitted: Fitted) -> Array:
        """Prediction of a model for all rows, (n, j), without constants."""
        chosen, x = self._numbers_of(fitted)
        return np.asarray(np.einsum("njk,jk->nj", self._columns[:, :, chosen], self._read(chosen, x)))

    def residuals(self, fitted: Fitted, of_part: "LinearRows | None" = None) -> Array:
        """Residuals of all rows, (n, j), less constants of runs, by a model of all or a part of them."""
        left = np.where(np.isfinite(self.values), self.values - (of_part or self).predicted(fitted), np.nan)
        return self._less_constants(left)

    def deviations(self, fitted: Fitted) -> tuple[Array, ...]:
        """Standard deviations of the numbers, by the effective sample size."""
        chosen, x = self._numbers_of(fitted)
        _, _, inverse, scale = self._solved(chosen, x, fitted.squares)
        return of_each(fitted.effects, scale * np.sqrt(np.diag(inverse)))


def candidates_of(of: Quantities, effects: Sequence[MotionEffect], kind: str) -> tuple[list[At], dict[str, str]]:
    """Effects at all locations where rows of a kind can show them, and reasons why others cannot be tested."""
    if of.lacking:
        return [], {effect.name: of.lacking for effect in effects if effect.rows == kind}
    joints = [j for j in range(of.q.shape[1]) if np.isfinite(of.measured[:, j]).sum() > 1]
    found, missing = [], {}
    for effect in effects:
        if effect.rows != kind:
            continue
        if effect.site != "joint":
            found.append(At(effect, effect.site, joints[0]))
            continue
        reasons = [(joint, effect.needs(of, joint) if effect.needs else "") for joint in joints]
        found += [At(effect, of.log.joints[joint], joint) for joint, reason in reasons if not reason]
        if all(reason for _, reason in reasons):
            missing[effect.name] = reasons[0][1]
    return found, missing
