"""Random blind data sets: a cell, faults of a given kind, the data, and the truth about them."""

from collections.abc import Mapping, Sequence
from dataclasses import asdict, dataclass, replace
from typing import Any, final

import numpy as np

from robolaser.data.dataset import Dataset, Noise, Poses
from robolaser.errors import TrialError
from robolaser.model.effects import EFFECTS
from robolaser.model.effects.effect import CandidateEffect, Effect
from robolaser.robot.kinematics import Robot
from robolaser.trials.building import BlankTrial, Ranges, build
from robolaser.trials.detectability import DETECTABLE, Detectability
from robolaser.trials.imperfections import with_imperfections
from robolaser.trials.kinds import Kind, drawn
from robolaser.trials.reading import read
from robolaser.trials.resampling import ReferenceCell, build_like
from robolaser.trials.sizing import detectability_of, noise_floor_m, sized_fault
from robolaser.trials.synthetic.fault_model import FaultModel
from robolaser.trials.synthetic.fault_models import DRAWN, FAULT_MODELS, OUTLIERS
from robolaser.trials.synthetic.fault_models.links import LinkGrowth
from robolaser.trials.tracking import build_tracked

MOVING = 0.55  # of the worlds have an arm that moves at the exposure, whether or not it matters
UNTIMED = 0.15  # of the worlds lack velocities,
MEASURED = 0.3  # and so many have the arm's temperature, whether or not it matters
ROOM_C, WARMER_C, THERMOMETER_C = 22.0, (3.0, 15.0), 0.1
TAUS = (0.1, 1.0)  # of a warm-up, over the run
STANDING_OUT, TIMES = 1000.0, 2.0  # squared misfit of an effect among small errors, at least, and over all of theirs
WRONGLY = (0.4, 2.5)  # times the true noise is what is stated

_LIBRARY = {effect.name: effect for effect in EFFECTS}


@final
@dataclass(frozen=True)
class BlindDataset:
    """A blind data set and its truth."""

    dataset: Dataset  # as the cell gives it
    truth: Mapping[str, Any]  # what the seal hides, as plain numbers and texts


def make(
    source: Robot | ReferenceCell,
    kind: str,
    *,
    seed: int,
    name: str = "blind",
    ranges: Ranges | None = None,
    tracked: bool = False,
) -> BlindDataset:
    """One world.

    Args:
        source: An arm, or a data set (see `reference_of`) whose arm, scanner, poses, target and noise are kept.
        kind: One of `KINDS`, or the name of a fault.
        seed: Same seed, same world.
        name: Of the data set: it should say nothing.
        ranges: What is left to chance.
        tracked: Whether a tracker sees the arm, whatever the kind.

    Raises:
        UsageError: There is no such kind.
        RobotError: The arm cannot look at a target often enough.
        TrialError: The fault cannot be in such a cell.
        DependencyMissing: MuJoCo is not installed.
    """
    rng = np.random.default_rng(np.random.SeedSequence([seed, *kind.encode(), *_arm(source).encode()]))
    asked = drawn(kind, rng)
    if tracked or (isinstance(source, ReferenceCell) and source.is_tracked):
        asked = replace(asked, tracked=True, outliers=0.0)
    built = with_imperfections(_blank_trial(source, asked, ranges or Ranges(), rng), asked, rng)
    faults: list[FaultModel] = []
    names: list[str] = []
    seen: list[Detectability] = []
    least = _least_misfit(built)
    for fault_name in _fault_names(kind, asked, built, rng):
        locations = _free(built, _locations(built, fault_name), faults)
        fault, detectability = sized_fault(built, fault_name, locations, rng, least_misfit=least)
        faults.append(fault)
        names.append(fault_name)
        seen.append(detectability)
    stated = asked.misstated or bool(rng.random() < 0.5)
    factor = float(rng.choice(WRONGLY)) if asked.misstated else 1.0
    dataset = _recorded(read(built, faults, rng), built, faults, rng, stated=stated, factor=factor)
    truth = {
        "robot": dataset.robot.name if dataset.robot else "",
        "kind": kind,
        "effects": [[d.effect, d.where] for d in faults],
        "noise_floor_mm": round(1e3 * noise_floor_m(built), 4),
        "each": [
            _described(fault, form, one, built, dataset.poses)
            for fault, form, one in zip(faults, names, seen, strict=True)
        ],
        "background": [[small.effect, small.where] for small in built.background],
        "velocities": bool(dataset.poses.qd is not None and np.any(dataset.poses.qd)),
        "temperatures": dataset.poses.temperature_c is not None,
        "noise_stated": factor if stated else None,
        "noise": {
            **{name: sigma for name, sigma in asdict(built.noise).items() if sigma is not None},
            "repeatability_m": built.scatter.size if built.scatter else 0.0,
            "image_px": built.image_px,
            "growth": built.growth,
        },
        "parameters": dict(built.cell.truth),
        "seed": seed,
    }
    return BlindDataset(replace(dataset, name=name), truth)


def _blank_trial(source: Robot | ReferenceCell, asked: Kind, ranges: Ranges, rng: np.random.Generator) -> BlankTrial:
    moving = bool(rng.random() < MOVING)
    if asked.tracked:
        return build_tracked(source, ranges, rng, moving=moving)
    return build(source, ranges, rng, moving=moving) if isinstance(source, Robot) else build_like(source, ranges, rng)


def _locations(built: BlankTrial, fault_name: str) -> tuple[str, ...]:
    """Where a fault can sit in a cell: a fault that the library knows only where the library can name it."""
    fault_model = FAULT_MODELS[fault_name]
    locations = fault_model.locations(built.cell.run)
    if built.blank.kind == "point" and not fault_model.is_tracked():
        return ()
    effect = _LIBRARY.get(fault_model.effect)
    if effect is None or fault_name == OUTLIERS:
        return locations
    known = effect.locations(built.blank)
    return tuple(location for location in locations if location in known)


def _fault_names(kind: str, asked: Kind, built: BlankTrial, rng: np.random.Generator) -> list[str]:
    """Faults of a kind, of those that have a place in this cell."""
    possible = [name for name in asked.among if _locations(built, name)]
    number = int(rng.integers(asked.number[0], asked.number[1] + 1))
    if number and not possible:
        raise TrialError(
            f"No world of the kind '{kind}' can be made with the arm '{built.blank.name}': "
            "none of its faults applies to it. A tracker sees neither images nor targets, "
            "and in a URDF without masses nothing gives way."
        )
    names = [str(name) for name in rng.permutation(possible)[:number]]
    if rng.random() < asked.beside:
        names += [str(name) for name in rng.permutation([name for name in DRAWN if _locations(built, name)])[:1]]
    return names + ([OUTLIERS] if rng.random() < asked.outliers else [])


def _least_misfit(built: BlankTrial) -> float:
    """What a fault should leave to be seen, or to stand out of small errors."""
    if not built.background:
        return DETECTABLE
    return max(STANDING_OUT, TIMES * detectability_of(built, *built.background).misfit)


def _free(built: BlankTrial, locations: tuple[str, ...], taken: Sequence[FaultModel]) -> tuple[str, ...]:
    """Places but for joints that have a fault already, as long as there are others."""
    joints = set(built.cell.run.arm.joints) & {fault.where for fault in taken}
    return tuple(location for location in locations if location not in joints) or locations


def _described(
    fault: FaultModel, name: str, detectability: Detectability, built: BlankTrial, poses: Poses
) -> dict[str, Any]:
    """A fault as the truth has it."""
    effect = _LIBRARY.get(fault.effect)
    known = effect is not None and fault.effect != OUTLIERS
    return {
        **asdict(fault),
        "effect": fault.effect,
        "form": name,
        "where": fault.where,
        "misfit": round(detectability.misfit, 1),
        "rivals": detectability.rivals(fault.effect, fault.where) if known else [],
        "also_right": [list(pair) for pair in fault.also_right],
        "sites": list(fault.sites(built.cell.run)),
        "classes": [effect.cause or effect.name] if effect else list(fault.classes),
        "values": _values(fault, effect, detectability, built, poses) if effect and known else {},
        "units": effect.units() if effect and known else {},
    }


def _values(
    fault: FaultModel, effect: type[Effect], detectability: Detectability, built: BlankTrial, poses: Poses
) -> dict[str, float]:
    """Of the library's parameters, small errors of the same kind and place added.

    Args:
        fault: The fault.
        effect: The library's name for it.
        detectability: The fault alone, without noise.
        built: The cell.
        poses: With velocities and temperatures as they were recorded.
    """
    seen = replace(detectability, dataset=replace(detectability.dataset, poses=poses))
    values = seen.nearest(CandidateEffect(effect, fault.where), fault.values(built.cell.run))
    same = [small for small in built.background if (small.effect, small.where) == (fault.effect, fault.where)]
    return {name: value + sum(s.values(built.cell.run).get(name, 0.0) for s in same) for name, value in values.items()}


def _recorded(
    dataset: Dataset,
    built: BlankTrial,
    faults: Sequence[FaultModel],
    rng: np.random.Generator,
    *,
    stated: bool,
    factor: float,
) -> Dataset:
    """With what the cell's people wrote down: some no velocities, some a temperature, half no noise of their sensor."""
    poses, true = dataset.poses, built.noise
    warming = [fault.tau for fault in faults if isinstance(fault, LinkGrowth)]
    if rng.random() < UNTIMED and not any(fault.effect == "latency" for fault in faults):
        poses = replace(poses, qd=None)
    if rng.random() < MEASURED:
        warmed = built.cell.run.warmed(warming[0] if warming else float(np.exp(rng.uniform(*np.log(TAUS)))))
        celsius = ROOM_C + rng.uniform(*WARMER_C) * warmed + THERMOMETER_C * rng.normal(size=len(warmed))
        poses = replace(poses, temperature_c=celsius.round(2))
    noise = Noise(
        pixel_px=true.pixel_px * factor if stated and true.pixel_px else None,
        point_m=true.point_m * factor if stated and true.point_m else None,
        target_m=true.target_m * factor if true.target_m else None,
    )
    return replace(dataset, poses=poses, noise=noise)


def _arm(source: Robot | ReferenceCell) -> str:
    robot = source.dataset.robot if isinstance(source, ReferenceCell) else source
    return robot.name if robot else ""
