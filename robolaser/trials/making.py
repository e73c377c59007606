"""Worlds of chance: a cell, departures of a kind that was asked for, a data set, and the truth about it."""

from collections.abc import Mapping, Sequence
from dataclasses import asdict, dataclass, replace
from typing import Any, final

import numpy as np

from robolaser.data.dataset import Dataset, Noise
from robolaser.geometry.kinematics import Robot
from robolaser.trials.building import Built, Ranges, build
from robolaser.trials.judging import DETECTABLE, Judge
from robolaser.trials.reading import exact, read
from robolaser.trials.resampling import Model, build_like
from robolaser.trials.worlds.departure import Departure
from robolaser.trials.worlds.families import FAMILIES, GROSS, KNOWN, STRANGERS
from robolaser.trials.worlds.families.warming import Warming

KINDS = ("none", "single", "pair", "triple", "unknown", "outliers")
USUAL = {"none": 0.14, "single": 0.5, "pair": 0.14, "triple": 0.04, "unknown": 0.1, "outliers": 0.08}
"""Share of each kind where none is asked for."""
MOVING = 0.55  # of the worlds have an arm that moves at the exposure, whether or not it matters
ON_TOP = 0.12  # of the worlds with effects have outliers too
FAINT = 0.08  # of the effects may stay below what can be seen
ALONE = 0.6  # of the strangers
TRIES = 6
UNTIMED = 0.15  # of the worlds lack velocities,
MEASURED = 0.3  # and so many have the arm's temperature, whether or not it matters
ROOM_C, WARMER_C, THERMOMETER_C = 22.0, (3.0, 15.0), 0.1
TAUS = (0.1, 1.0)  # of a warm-up, over the run
LOUD = 1.5e5  # the squared misfit above which an effect is made smaller: nobody needs help with it
CLEARLY = 2.0  # times detectable, at most, to which a faint effect is grown


@final
@dataclass(frozen=True)
class World:
    """A blind data set and its truth.

    Attributes:
        dataset: As the cell gives it.
        truth: What the seal hides, as plain numbers and texts.
    """

    dataset: Dataset
    truth: Mapping[str, Any]


def make(source: Robot | Model, kind: str, *, seed: int, name: str = "blind", ranges: Ranges | None = None) -> World:
    """One world.

    Args:
        source: An arm, or a data set (see `model_of`) whose arm, scanner, poses, target and noise are kept.
        kind: One of `KINDS`.
        seed: Same seed, same world.
        name: Of the data set: it should say nothing.
        ranges: What is left to chance.

    Raises:
        RobotError: The arm cannot look at a target often enough.
    """
    rng = np.random.default_rng(np.random.SeedSequence([seed, *kind.encode(), *_arm(source).encode()]))
    moving = bool(rng.random() < MOVING)
    ranges = ranges or Ranges()
    built = build(source, ranges, rng, moving=moving) if isinstance(source, Robot) else build_like(source, ranges, rng)
    names = _effects(kind, built, rng)
    departures: list[Departure] = []
    each = []
    for effect in names:
        departure, judge = _departure(built, effect, [d.where for d in departures], rng)
        departures.append(departure)
        each.append(
            {
                **asdict(departure),
                "effect": effect,
                "where": departure.where,
                "misfit": round(judge.misfit, 1),
                "rivals": judge.rivals(effect, departure.where) if effect in KNOWN else [],
                "sites": _sites(departure, built),
            }
        )
    stated = bool(rng.random() < 0.5)
    dataset = _recorded(read(built, departures, rng), built, departures, rng, stated=stated)
    flat = _judge(built, ())
    truth = {
        "robot": dataset.robot.name if dataset.robot else "",
        "kind": kind,
        "effects": [[d.effect, d.where] for d in departures],
        "noise_floor_mm": round(1e3 * flat.floor_m, 4),
        "each": each,
        "velocities": bool(dataset.poses.qd is not None and np.any(dataset.poses.qd)),
        "temperatures": dataset.poses.temperature_c is not None,
        "noise_stated": stated,
        "noise": {"pixel_px": built.noise.pixel_px, "target_m": built.noise.target_m},
        "parameters": dict(built.cell.eye.truth),
        "seed": seed,
    }
    return World(replace(dataset, name=name), truth)


def _effects(kind: str, built: Built, rng: np.random.Generator) -> list[str]:
    """Effects of a kind, of those that have a place in this cell."""
    there = [name for name, family in FAMILIES.items() if family.places(built.cell.run)]
    known = [str(name) for name in rng.permutation([name for name in KNOWN if name in there])]
    on_top = [GROSS] if rng.random() < ON_TOP else []
    if kind == "none":
        return []
    if kind == "outliers":
        return [GROSS]
    if kind == "unknown":
        stranger = str(rng.choice([name for name in STRANGERS if name in there]))
        return [stranger, *(known[:1] if rng.random() > ALONE else [])]
    return known[: {"single": 1, "pair": 2, "triple": 3}[kind]] + on_top


def _judge(built: Built, departures: tuple[Departure, ...]) -> Judge:
    noise = built.noise
    assert noise.pixel_px is not None
    assert noise.target_m is not None
    share = np.sqrt(built.repeats)
    return Judge(exact(built, departures), dict(built.cell.eye.truth), noise.pixel_px / share, noise.target_m)


def _departure(built: Built, effect: str, taken: list[str], rng: np.random.Generator) -> tuple[Departure, Judge]:
    """One of a family, at a place that no other effect has, nearly always large enough to be seen."""
    family, run = FAMILIES[effect], built.cell.run
    free = [place for place in family.places(run) if place not in taken or place not in run.arm.joints]
    least, most = family.sizes
    faint = rng.random() < FAINT
    for _ in range(TRIES):
        size = float(np.exp(rng.uniform(np.log(least), np.log(most))))
        departure = family.drawn(str(rng.choice(free)), size, run, rng)
        judge = _seen_by(built, departure, rng)
        if effect == GROSS or (faint and judge.misfit < DETECTABLE) or DETECTABLE < judge.misfit < LOUD:
            break
        goal = DETECTABLE * rng.uniform(1.1, CLEARLY) if judge.misfit < DETECTABLE else LOUD * rng.uniform(0.1, 1.0)
        fitting = abs(departure.size) * np.sqrt(goal / max(judge.misfit, 1e-3))
        departure = replace(departure, size=float(np.copysign(min(most, fitting), departure.size)))
        judge = _seen_by(built, departure, rng)
        if judge.misfit > DETECTABLE:
            break
    return departure, judge


def _seen_by(built: Built, departure: Departure, rng: np.random.Generator) -> Judge:
    if departure.effect != GROSS:
        return _judge(built, (departure,))
    plain = _judge(built, ())
    points = plain.dataset.points
    assert points.pixel is not None
    pixel = departure.shots(points.pixel, np.arange(len(points)), rng)
    return replace(plain, dataset=replace(plain.dataset, points=replace(points, pixel=pixel)))


def _sites(departure: Departure, built: Built) -> list[str]:
    """Where a diagnosis may rightly say that it lies."""
    return list(built.cell.run.arm.joints[-3:]) if departure.effect == "hose" else [departure.where]


def _recorded(
    dataset: Dataset, built: Built, departures: Sequence[Departure], rng: np.random.Generator, *, stated: bool
) -> Dataset:
    """With what the cell's people wrote down: some no velocities, some a temperature, half no pixel noise."""
    poses = dataset.poses
    warming = [departure.tau for departure in departures if isinstance(departure, Warming)]
    if rng.random() < UNTIMED and not any(departure.effect == "latency" for departure in departures):
        poses = replace(poses, qd=None)
    if rng.random() < MEASURED:
        warmed = built.cell.run.warmed(warming[0] if warming else float(np.exp(rng.uniform(*np.log(TAUS)))))
        celsius = ROOM_C + rng.uniform(*WARMER_C) * warmed + THERMOMETER_C * rng.normal(size=len(warmed))
        poses = replace(poses, temperature_c=celsius.round(2))
    noise = built.noise if stated else Noise(target_m=built.noise.target_m)
    return replace(dataset, poses=poses, noise=noise)


def _arm(source: Robot | Model) -> str:
    robot = source.dataset.robot if isinstance(source, Model) else source
    return robot.name if robot else ""
