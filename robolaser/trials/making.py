"""Random blind data sets: a cell, faults of a given kind, the data, and the truth about them."""

from collections.abc import Mapping, Sequence
from dataclasses import asdict, dataclass, replace
from typing import Any, final

import numpy as np

from robolaser.data.dataset import Dataset, Noise
from robolaser.geometry.kinematics import Robot
from robolaser.trials.building import BlankTrial, Ranges, build
from robolaser.trials.detectability import DETECTABLE, Detectability
from robolaser.trials.reading import exact, read
from robolaser.trials.resampling import ReferenceCell, build_like
from robolaser.trials.synthetic.fault_model import FaultModel
from robolaser.trials.synthetic.fault_models import FAULT_MODELS, MODELLED, OUTLIERS, UNMODELLED
from robolaser.trials.synthetic.fault_models.links import LinkGrowth

KINDS = ("none", "single", "pair", "triple", "unknown", "outliers")
USUAL = {"none": 0.14, "single": 0.5, "pair": 0.14, "triple": 0.04, "unknown": 0.1, "outliers": 0.08}
"""Share of each kind where none is asked for."""
MOVING = 0.55  # of the worlds have an arm that moves at the exposure, whether or not it matters
ON_TOP = 0.12  # of the worlds with effects have outliers too
UNDETECTABLE = 0.08  # of the effects may stay below what can be seen
ALONE = 0.6  # of the strangers
TRIES = 6
UNTIMED = 0.15  # of the worlds lack velocities,
MEASURED = 0.3  # and so many have the arm's temperature, whether or not it matters
ROOM_C, WARMER_C, THERMOMETER_C = 22.0, (3.0, 15.0), 0.1
TAUS = (0.1, 1.0)  # of a warm-up, over the run
OVERSIZED = 1.5e5  # the squared misfit above which an effect is made smaller: nobody needs help with it
CLEARLY = 2.0  # times detectable, at most, to which a faint effect is grown


@final
@dataclass(frozen=True)
class BlindDataset:
    """A blind data set and its truth.

    Attributes:
        dataset: As the cell gives it.
        truth: What the seal hides, as plain numbers and texts.
    """

    dataset: Dataset
    truth: Mapping[str, Any]


def make(
    source: Robot | ReferenceCell, kind: str, *, seed: int, name: str = "blind", ranges: Ranges | None = None
) -> BlindDataset:
    """One world.

    Args:
        source: An arm, or a data set (see `reference_of`) whose arm, scanner, poses, target and noise are kept.
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
    faults: list[FaultModel] = []
    each = []
    for effect in names:
        fault, detectability = _fault(built, effect, [d.where for d in faults], rng)
        faults.append(fault)
        each.append(
            {
                **asdict(fault),
                "effect": effect,
                "where": fault.where,
                "misfit": round(detectability.misfit, 1),
                "rivals": detectability.rivals(effect, fault.where) if effect in MODELLED else [],
                "sites": _sites(fault, built),
            }
        )
    stated = bool(rng.random() < 0.5)
    dataset = _recorded(read(built, faults, rng), built, faults, rng, stated=stated)
    flat = _detectability(built, ())
    truth = {
        "robot": dataset.robot.name if dataset.robot else "",
        "kind": kind,
        "effects": [[d.effect, d.where] for d in faults],
        "noise_floor_mm": round(1e3 * flat.floor_m, 4),
        "each": each,
        "velocities": bool(dataset.poses.qd is not None and np.any(dataset.poses.qd)),
        "temperatures": dataset.poses.temperature_c is not None,
        "noise_stated": stated,
        "noise": {"pixel_px": built.noise.pixel_px, "target_m": built.noise.target_m},
        "parameters": dict(built.cell.eye.truth),
        "seed": seed,
    }
    return BlindDataset(replace(dataset, name=name), truth)


def _effects(kind: str, built: BlankTrial, rng: np.random.Generator) -> list[str]:
    """Effects of a kind, of those that have a place in this cell."""
    there = [name for name, fault_model in FAULT_MODELS.items() if fault_model.locations(built.cell.run)]
    known = [str(name) for name in rng.permutation([name for name in MODELLED if name in there])]
    on_top = [OUTLIERS] if rng.random() < ON_TOP else []
    if kind == "none":
        return []
    if kind == "outliers":
        return [OUTLIERS]
    if kind == "unknown":
        stranger = str(rng.choice([name for name in UNMODELLED if name in there]))
        return [stranger, *(known[:1] if rng.random() > ALONE else [])]
    return known[: {"single": 1, "pair": 2, "triple": 3}[kind]] + on_top


def _detectability(built: BlankTrial, faults: tuple[FaultModel, ...]) -> Detectability:
    noise = built.noise
    assert noise.pixel_px is not None
    assert noise.target_m is not None
    share = np.sqrt(built.repeats)
    return Detectability(exact(built, faults), dict(built.cell.eye.truth), noise.pixel_px / share, noise.target_m)


def _fault(
    built: BlankTrial, effect: str, taken: list[str], rng: np.random.Generator
) -> tuple[FaultModel, Detectability]:
    """A fault, at a place that no other effect has, nearly always large enough to be seen."""
    fault_model, run = FAULT_MODELS[effect], built.cell.run
    free = [place for place in fault_model.locations(run) if place not in taken or place not in run.arm.joints]
    least, most = fault_model.sizes
    faint = rng.random() < UNDETECTABLE
    for _ in range(TRIES):
        size = float(np.exp(rng.uniform(np.log(least), np.log(most))))
        fault = fault_model.sample(str(rng.choice(free)), size, run, rng)
        detectability = _seen_by(built, fault, rng)
        if (
            effect == OUTLIERS
            or (faint and detectability.misfit < DETECTABLE)
            or DETECTABLE < detectability.misfit < OVERSIZED
        ):
            break
        goal = (
            DETECTABLE * rng.uniform(1.1, CLEARLY)
            if detectability.misfit < DETECTABLE
            else OVERSIZED * rng.uniform(0.1, 1.0)
        )
        fitting = abs(fault.size) * np.sqrt(goal / max(detectability.misfit, 1e-3))
        fault = replace(fault, size=float(np.copysign(min(most, fitting), fault.size)))
        detectability = _seen_by(built, fault, rng)
        if detectability.misfit > DETECTABLE:
            break
    return fault, detectability


def _seen_by(built: BlankTrial, fault: FaultModel, rng: np.random.Generator) -> Detectability:
    if fault.effect != OUTLIERS:
        return _detectability(built, (fault,))
    plain = _detectability(built, ())
    points = plain.dataset.points
    pixel = fault.shots(points["pixel"], np.arange(len(points)), rng)
    return replace(plain, dataset=replace(plain.dataset, points=replace(points, pixel=pixel)))


def _sites(fault: FaultModel, built: BlankTrial) -> list[str]:
    """Where a diagnosis may rightly say that it lies."""
    return list(built.cell.run.arm.joints[-3:]) if fault.effect == "hose" else [fault.where]


def _recorded(
    dataset: Dataset, built: BlankTrial, faults: Sequence[FaultModel], rng: np.random.Generator, *, stated: bool
) -> Dataset:
    """With what the cell's people wrote down: some no velocities, some a temperature, half no pixel noise."""
    poses = dataset.poses
    warming = [fault.tau for fault in faults if isinstance(fault, LinkGrowth)]
    if rng.random() < UNTIMED and not any(fault.effect == "latency" for fault in faults):
        poses = replace(poses, qd=None)
    if rng.random() < MEASURED:
        warmed = built.cell.run.warmed(warming[0] if warming else float(np.exp(rng.uniform(*np.log(TAUS)))))
        celsius = ROOM_C + rng.uniform(*WARMER_C) * warmed + THERMOMETER_C * rng.normal(size=len(warmed))
        poses = replace(poses, temperature_c=celsius.round(2))
    noise = built.noise if stated else Noise(target_m=built.noise.target_m)
    return replace(dataset, poses=poses, noise=noise)


def _arm(source: Robot | ReferenceCell) -> str:
    robot = source.dataset.robot if isinstance(source, ReferenceCell) else source
    return robot.name if robot else ""
