"""Rows of joints that follow commands: servos with effects, fitted by damped least squares over simulations."""

from collections.abc import Sequence
from dataclasses import dataclass, field, replace
from functools import cached_property
from typing import final

import numpy as np

from robolaser.arrays import Array, Bools, Ints
from robolaser.motion.effect import At, MotionEffect, Number, Trace
from robolaser.motion.effects.servo import is_one_clock
from robolaser.motion.evidence import IDEAL_SHARE, Fitted, independent_values, names_of, of_each, score_of
from robolaser.motion.gap import less_means, root_mean_squares
from robolaser.motion.log import MotionLog, filled
from robolaser.motion.series_clocks import Lateness
from robolaser.motion.servo import IDEAL, CommandSeries

ROUNDS = 3  # of a fit that starts from one with an effect less, or more
MORE_ROUNDS = 8  # of the final fit
SETTLED = 3e-3  # least gain of a round, as a share of the squares
STEP = 0.05  # of finite differences, in usual sizes
DAMPINGS = (1e-3, 1e-1, 10.0)  # tried in each round, by the diagonal
KEPT_ROWS = 4_000  # of a joint, whose residuals are used
LONGEST = 2_500  # rows of one simulation; the next one starts from the measured position
FOLLOWS = ("lag", "offset", "droop")
FORM_RAD = 3e-5  # further error of the form of servo models: a judgement
DELAY_STEP_S = 1e-3  # of the derivative by a delay
ENDS_S = 0.1  # lost at the ends of runs that end in motion: few servos have a longer delay
FEWEST_SHARE = 4  # a run loses up to one row in so many at each of its ends


@final
@dataclass(eq=False)
class _ServoFit:
    """The state of a fit."""

    joint: int
    effects: tuple[At, ...]
    x: Array  # in usual sizes
    cost: float = np.inf
    residual: Array = field(default_factory=lambda: np.empty(0))

    @property
    def numbers(self) -> list[Number]:
        """Numbers of all its effects."""
        return [number for one in self.effects for number in one.effect.numbers]

    @property
    def usual(self) -> Array:
        """Usual sizes of its numbers, the units of `x`."""
        return np.array([number.usual for number in self.numbers])

    def servo(self, x: Array) -> dict[str, float]:
        """Numbers by their names in the servo's model."""
        return {one.servo: float(value * one.usual) for value, one in zip(x, self.numbers, strict=True)}

    def within(self, x: Array) -> Array:
        """Numbers clipped to their bounds."""
        lower, upper = (np.array(ends) for ends in ([n.lower for n in self.numbers], [n.upper for n in self.numbers]))
        return np.asarray(np.clip(x, lower / self.usual, upper / self.usual))


@final
class TrackingRows:
    """Models of joints that follow commands, one joint each; a joint's index in `joints` is the number of its search.

    Some runs count, by number; all by default.
    """

    def __init__(self, log: MotionLog, runs: Ints | None = None) -> None:
        self.log = log
        pieces = [
            (slice(start, min(start + LONGEST, part.stop)), int(log.run[part.start]))
            for part in log.pieces
            if runs is None or log.run[part.start] in runs
            for start in range(part.start, part.stop, LONGEST)
        ]
        pieces.sort(key=lambda piece: piece[0].start - piece[0].stop)
        self._pieces, self._run = [rows for rows, _ in pieces], np.array([run for _, run in pieces])
        lengths = np.array([rows.stop - rows.start for rows in self._pieces], dtype=np.int64)
        longest, count, joints = int(lengths.max()), len(pieces), log.q.shape[1]
        q = log.q
        if log.offset_per_series:  # a joint starts where it is, whatever its encoder's zero in that run
            command = filled(log.command)
            q = command + less_means(q - command, log.run)
        self._q, step = np.full((joints, longest, count), np.nan), np.full((longest, count), log.step_s)
        for s, part in enumerate(self._pieces):
            self._q[:, : lengths[s], s] = q[part].T
            step[: lengths[s] - 1, s] = np.diff(log.time_s[part])
        sent = CommandSeries.of(log.robot, [filled(log.command[part]) for part in self._pieces], step, log.step_s)
        read = np.isfinite(self._q)
        first = np.take_along_axis(self._q, read.argmax(axis=1)[:, None], axis=1)[:, 0]
        # earlier commands: the median of no change, the rate of commands, and the rate of the joint
        rate = np.median([0.0 * sent.rate, _rate(sent.command), _rate(self._q)], axis=0) / max(log.step_s, 1e-4)
        self._runs = replace(sent, start=np.where(read.any(axis=1), first, sent.start), rate=rate)
        # rows at an end may show commands outside the run; the first one gives the start of the joints
        self._used = np.ones((longest, count), dtype=bool)
        for s, length in enumerate(lengths.tolist()):
            rows = min(round(ENDS_S / max(log.step_s, 1e-4)), length // FEWEST_SHARE)
            for order in (1, -1):
                moves = (np.abs(_rate(sent.command[:, :length, s, None][:, ::order])) * rows > FORM_RAD).any()
                self._used[:length, s][::order][: rows if moves else int(order > 0)] = False
        known = log.has("command") & (read & self._used).any(axis=(1, 2))
        self.joints: Ints = np.flatnonzero(known).astype(np.int64)
        """Columns of the joints that have commands, and readings that count."""
        self._form = np.hypot(IDEAL_SHARE * root_mean_squares(log.q - log.command), FORM_RAD)
        self.independent = np.ones(joints)  # effective sample size of each joint's rows, (j,)
        self._found: dict[tuple[int, frozenset[str]], _ServoFit] = {}

    @property
    def used(self) -> int:
        """Number of rows of the log that count."""
        return sum(rows.stop - rows.start for rows in self._pieces)

    @property
    def counted(self) -> Bools:
        """Which rows of the log count, (n,)."""
        out = np.zeros(len(self.log), dtype=bool)
        for s, part in enumerate(self._pieces):
            out[part] = self._used[: part.stop - part.start, s]
        return out

    def count(self, joint: int) -> int:
        """Number of residuals of a joint that are used."""
        return len(self._kept[joint][0])

    def without(self, held_out: Bools) -> "TrackingRows":
        """The same without the held-out rows of the log, (n,), starting from the fits so far."""
        fresh = object.__new__(TrackingRows)
        fresh.__dict__ = {key: value for key, value in self.__dict__.items() if key != "_kept"}
        fresh._used = self._used.copy()
        for s, part in enumerate(self._pieces):
            fresh._used[: part.stop - part.start, s] &= ~held_out[part]
        fresh._found = dict(self._found)
        return fresh

    @cached_property
    def _kept(self) -> list[tuple[Ints, Ints, Ints]]:
        """Row in the piece, index of the piece, and run of each joint's used residuals."""
        kept = []
        for q in self._q:
            s, at = np.nonzero((np.isfinite(q) & self._used).T)
            stride = max(1, len(at) // KEPT_ROWS)
            kept.append((at[::stride], s[::stride], self._run[s[::stride]]))
        return kept

    def candidates(self, effects: Sequence[MotionEffect]) -> tuple[list[list[At]], dict[str, str]]:
        """Effects that may be present at each joint, and reasons why others cannot be tested at some."""
        effects, found = [one for one in effects if one.rows == "tracking"], []
        missing: dict[str, str] = {}
        for joint in self.joints.tolist():
            name, trace = self.log.joints[joint], self._trace(joint)
            reasons = [(effect, trace.stuck or effect.untested(trace)) for effect in effects]
            missing = {effect.name: reason for effect, reason in reversed(reasons) if reason} | missing
            places = [(effect, name if effect.site == "joint" else effect.site) for effect, why in reasons if not why]
            found.append([At(effect, place, joint) for effect, place in places])
        return found, missing

    def _trace(self, joint: int) -> Trace:
        runs = self._runs
        return Trace(runs.command[joint], self._q[joint], runs.holding[joint], runs.moving[joint], runs.step)

    def usual(self, candidates: Sequence[Sequence[At]]) -> list[tuple[At, ...]]:
        """Usual effects of servos, fitted step by step: the start of the search at each joint.

        A search that starts from an ideal servo would take the lag for a dead time, and the rest for play.
        """
        numbers = range(len(candidates))
        late, early = ([_named(each, (name,)) for each in candidates] for name in ("dead_time", "clock_shift"))
        fits = [self.fit(list(enumerate(each)), MORE_ROUNDS) for each in (late, early)]
        delays = [late[i] if fits[0][i].squares.sum() <= fits[1][i].squares.sum() else early[i] for i in numbers]
        simple = [[at for at in _named(each, FOLLOWS) if not at.effect.form] for each in candidates]
        follows = [(*delays[i], *simple[i]) for i in numbers]
        self.fit(list(enumerate(follows)), MORE_ROUNDS)
        rested = [[(*follows[i], *_named(candidates[i], (name,))) for i in numbers] for name in ("dead_zone", "play")]
        for each in rested:
            self.fit(list(enumerate(each)), MORE_ROUNDS)
        self.count_memory()
        fits = [self.fit(list(enumerate(each))) for each in rested]
        return [min((fits[0][i], fits[1][i]), key=lambda fit: fit.score).effects for i in numbers]

    def with_one_clock(self, candidates: Sequence[Sequence[At]]) -> list[list[At]]:
        """Candidates without the clock where the joints' delays exclude it: it shifts all by one time."""
        early = [_named(each, ("clock_shift",)) for each in candidates]
        if not all(early):
            return [list(each) for each in candidates]
        delays = np.array([fit.numbers[0][0] for fit in self.fit(list(enumerate(early)), MORE_ROUNDS)])
        agree = (delays >= 0.0).all() or is_one_clock(delays)
        return [[at for at in each if agree or at.effect.name != "clock_shift"] for each in candidates]

    def count_memory(self) -> None:
        """Estimate the effective sample sizes, from the residuals of the models so far."""
        for joint in self.joints.tolist():
            fits = [fit for (j, _), fit in self._found.items() if j == joint]
            best = min(fits, key=lambda fit: fit.cost)
            self.independent[joint] = independent_values(best.residual, self._kept[joint][2])

    def fit(self, requests: Sequence[tuple[int, tuple[At, ...]]], rounds: int = ROUNDS) -> list[Fitted]:
        """Models of the joint of each search, with each set of effects."""
        keys = [(int(self.joints[number]), names_of(effects)) for number, effects in requests]
        fits = {
            key: self._begun(key[0], effects)
            for key, (_, effects) in zip(keys, requests, strict=True)
            if key not in self._found
        }
        self._improve([fit for group in fits.values() for fit in group], rounds)
        self._found.update({key: min(group, key=lambda fit: fit.cost) for key, group in fits.items()})
        return [self._as_fitted(self._found[key]) for key in keys]

    def refined(self, models: Sequence[Fitted], like: "TrackingRows") -> list[Fitted]:
        """Models of all joints, selected on other rows of the same log, fitted to these."""
        fits = [_ServoFit(found.joint, found.effects, found.x) for found in like._fits(models)]
        self._forget_unseen(fits)
        self._improve(fits, MORE_ROUNDS)
        self._found.update({(fit.joint, names_of(fit.effects)): fit for fit in fits})
        return [self._as_fitted(fit) for fit in fits]

    def _fits(self, models: Sequence[Fitted]) -> list[_ServoFit]:
        """The stored fit of a model of each joint."""
        return [self._found[joint, one.names] for joint, one in zip(self.joints.tolist(), models, strict=True)]

    def _forget_unseen(self, fits: Sequence[_ServoFit]) -> None:
        """Reset numbers that change nothing in these rows to an ideal servo's: only other rows determine them."""
        moving = [fit for fit in fits if fit.effects]
        self._evaluate(moving)
        for fit, slopes in zip(moving, self._slopes(moving), strict=True):
            ideal = [IDEAL[number.servo] / number.usual for number in fit.numbers]
            fit.x = np.where((slopes == 0.0).all(axis=0), ideal, fit.x)

    def _begun(self, joint: int, effects: tuple[At, ...]) -> list[_ServoFit]:
        """Fits that start from a model with an effect less, or more; new effects start at two sizes."""
        there = [(names, fit) for (j, names), fit in self._found.items() if j == joint]
        near = min(there, key=lambda one: len(names_of(effects) ^ one[0]), default=None)
        known, of_servo, spread = {}, {}, 0.0
        if near:
            known = dict(zip(map(str, near[1].effects), map(list, of_each(near[1].effects, near[1].x)), strict=True))
            of_servo = near[1].servo(near[1].x)
            spread = float(np.nan_to_num(root_mean_squares(near[1].residual)))
        starts, trace = [], self._trace(joint)
        for size in (1.0, 4.0):
            x: list[float] = []
            for one in effects:
                numbers = one.effect.numbers
                begun = zip(numbers, one.effect.begins(numbers, trace, size, spread), strict=True)
                x += known.get(str(one)) or [of_servo.get(n.servo, value * n.usual) / n.usual for n, value in begun]
            starts.append(np.array(x))
            if all(str(one) in known for one in effects):
                break
        fits = [_ServoFit(joint, effects, start) for start in starts]
        for fit in fits:
            fit.x = fit.within(fit.x)
        return fits

    def _evaluate(self, fits: Sequence[_ServoFit]) -> None:
        for fit, residual in zip(fits, self._computed([(fit, [fit.x]) for fit in fits]), strict=True):
            fit.residual = residual[:, 0]
            fit.cost = float(fit.residual @ fit.residual)

    def _improve(self, fits: list[_ServoFit], rounds: int) -> None:
        self._evaluate(fits)
        moving = [fit for fit in fits if fit.effects]
        for _ in range(rounds):
            steps = [
                (fit, [fit.within(fit.x + step) for step in _steps(slopes, fit.residual)])
                for fit, slopes in zip(moving, self._slopes(moving), strict=True)
            ]
            going = []
            for (fit, tried), residual in zip(steps, self._computed(steps), strict=True):
                costs = (residual**2).sum(axis=0)
                best = int(costs.argmin())
                if costs[best] < fit.cost * (1.0 - SETTLED):
                    going.append(fit)
                if costs[best] < fit.cost:
                    fit.x, fit.cost, fit.residual = tried[best], float(costs[best]), residual[:, best]
            moving = going
            if not moving:
                break

    def _slopes(self, fits: Sequence[_ServoFit]) -> list[Array]:
        """Derivatives of each fit's residuals by its numbers, (kept, d)."""
        aside = self._computed([(fit, [fit.x + STEP * side for side in np.eye(len(fit.x))]) for fit in fits])
        return [(each - fit.residual[:, None]) / STEP for fit, each in zip(fits, aside, strict=True)]

    def _computed(self, cases: Sequence[tuple[_ServoFit, list[Array]]]) -> list[Array]:
        """Residuals at the kept rows for given numbers of each fit, (kept, m)."""
        joint = np.array([fit.joint for fit, tried in cases for _ in tried], dtype=np.int64)
        numbers = [fit.servo(x) for fit, tried in cases for x in tried]
        if not numbers:
            return [np.empty((0, 0)) for _ in cases]
        out, m, found = self._runs.simulate(joint, numbers), 0, []
        for fit, tried in cases:
            at, s, run = self._kept[fit.joint]
            left = out[at, s, m : m + len(tried)] - self._q[fit.joint, at, s][:, None]
            found.append(less_means(left, run) if self.log.offset_per_series else left)
            m += len(tried)
        return found

    def errors_of(self, at: At, sizes: Array) -> list[Array]:
        """Residuals of a joint, (n,), by a servo with one effect, for sizes of its first number; others are zero."""
        usual = np.array([number.usual for number in at.effect.numbers])
        first = np.eye(len(usual))[0] / usual[0]
        (found,) = self._computed([(_ServoFit(at.joint, (at,), first), [size * first for size in sizes])])
        return list(found.T)

    def lateness(self, models: Sequence[Fitted]) -> list[Lateness]:
        """Evidence for delays in each joint's readings, by its fitted model."""
        fits = self._fits(models)
        servos = [fit.servo(fit.x) for fit in fits]
        moved = [{**servo, "delay": servo.get("delay", 0.0) + DELAY_STEP_S} for servo in servos]
        paths = self._runs.simulate(self.joints, moved)
        found = []
        for m, (fit, servo) in enumerate(zip(fits, servos, strict=True)):
            at, s, run = self._kept[fit.joint]
            slope = (paths[at, s, m] - self._q[fit.joint, at, s] - fit.residual) / DELAY_STEP_S
            late = servo.get("delay", 0.0) + servo.get("time", 0.0)
            found.append(Lateness(fit.residual, slope, run, float(self.independent[fit.joint]), late))
        return found

    def _as_fitted(self, fit: _ServoFit) -> Fitted:
        squares, rows = np.zeros(len(self.independent)), np.zeros(len(self.independent))
        squares[fit.joint], rows[fit.joint] = fit.cost, len(fit.residual)
        score = score_of(squares, rows, np.where(rows > 0, self.independent, 0.0), self._form, len(fit.x))
        score += sum(one.effect.rarity for one in fit.effects)
        numbers = of_each(fit.effects, fit.x * fit.usual)
        return Fitted(fit.effects, numbers, (0,) * len(fit.effects), score, squares)

    def deviations(self, fitted: Fitted, joint: int) -> tuple[Array, ...]:
        """Standard deviations of a model's numbers, by the effective sample size."""
        fit = self._found[joint, fitted.names]
        if not fit.effects:
            return ()
        (slopes,) = self._slopes([fit])
        weight = self.independent[joint] / max(fit.cost, 1e-24)
        H = weight * slopes.T @ slopes + 1e-8 * np.eye(len(fit.x))
        with np.errstate(invalid="ignore"):  # NaN: the rows do not show the number
            std = np.sqrt(np.diag(np.linalg.pinv(H))) * fit.usual
        return of_each(fit.effects, std)

    def predicted(self, models: Sequence[Fitted]) -> Array:
        """Predicted angles, (n, j) in the rows of the log; the commands of joints without a model."""
        out = np.where(np.isfinite(self.log.command), self.log.command, np.nan)
        fits = self._fits(models)
        paths = self._runs.simulate(self.joints, [fit.servo(fit.x) for fit in fits])
        for m, fit in enumerate(fits):
            for s, part in enumerate(self._pieces):
                out[part, fit.joint] = paths[: part.stop - part.start, s, m]
        return out


def _rate(values: Array) -> Array:
    """Change of values (j, n, k) per row at the first, by the parabola through three, (j, k)."""
    first = np.nan_to_num(values[:, [0, 1, 2] if values.shape[1] > 2 else [0, 0, 0]])
    return np.asarray(0.5 * (4.0 * first[:, 1] - 3.0 * first[:, 0] - first[:, 2]))


def _named(candidates: Sequence[At], names: Sequence[str]) -> tuple[At, ...]:
    return tuple(one for one in candidates if one.effect.name in names)


def _steps(slopes: Array, residual: Array) -> list[Array]:
    """Gauss-Newton steps, damped less and more."""
    H, g = slopes.T @ slopes, slopes.T @ residual
    diagonal = np.diag(np.diag(H) + 1e-12 * max(1e-12, float(np.trace(H))))
    return [np.asarray(-np.linalg.solve(H + damping * diagonal, g), np.float64) for damping in DAMPINGS]
