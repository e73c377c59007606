"""Random blind data sets: a cell, faults of a given kind, the data, and the truth about them."""

from collections.abc import Mapping, Sequence
from dataclasses import asdict, dataclass, replace
from typing import Any, final

import numpy as np

from robolaser.data.dataset import Dataset, Poses
from robolaser.data.stated_noise import Noise
from robolaser.errors import TrialError
from robolaser.model.effects import EFFECTS
from robolaser.model.effects.effect import CandidateEffect
from robolaser.robot.kinematics import Robot
from robolaser.trials.building import Ranges, World, build
from robolaser.trials.detectability import DETECTABLE, Detectability, noise_floor_m, sized_fault
from robolaser.trials.kinds import Kind, drawn
from robolaser.trials.resampling import ReferenceCell, build_like, build_tracked
from robolaser.trials.synthetic.fault_model import FaultModel
from robolaser.trials.synthetic.fault_models import DRAWN, FAULT_MODELS, OUTLIERS
from robolaser.trials.synthetic.fault_models.links import LinkGrowth

MOVING = 0.55  # share of worlds whose arm moves at the exposure, whether or not it matters
UNTIMED = 0.15  # share of worlds without velocities,
MEASURED = 0.3  # and with the arm's temperature, whether or not it matters
ROOM_C, WARMER_C, THERMOMETER_C = 22.0, (3.0, 15.0), 0.1
TAUS = (0.1, 1.0)  # of a warm-up, over the run
STANDING_OUT, TIMES = 1000.0, 2.0  # misfit of an effect among small errors, at least, and over that of all of them
WRONGLY = (0.4, 2.5)  # factors of misstated noise

_LIBRARY = {effect.name: effect for effect in EFFECTS}


@final
@dataclass(frozen=True)
class BlindDataset:
    """A blind data set and its truth."""

    dataset: Dataset  # measured in the cell
    truth: Mapping[str, Any]  # its faults, as plain numbers and texts


def make(
    source: Robot | ReferenceCell,
    kind: str,
    *,
    seed: int,
    name: str = "blind",
    ranges: Ranges | None = None,
    tracked: bool = False,
) -> BlindDataset:
    """Make one world.

    Args:
        source: An arm, or a data set (see `reference_of`) whose arm, scanner, poses, target and noise are kept.
        kind: One of `KINDS`, or the name of a fault.
        seed: Same seed, same world.
        name: Of the data set: it should reveal nothing.
        ranges: Of random quantities.
        tracked: Whether a tracker measures the arm, whatever the kind.

    Raises:
        UsageError: There is no such kind.
        RobotError: The arm cannot look at a target often enough.
        TrialError: The fault cannot be in such a cell, or its poses have too few points.
        DependencyMissing: MuJoCo is not installed.
    """
    rng = np.random.default_rng(np.random.SeedSequence([seed, *kind.encode(), *_robot(source).name.encode()]))
    properties = drawn(kind, rng)
    if tracked or (isinstance(source, ReferenceCell) and source.is_tracked):
        properties = replace(properties, tracked=True, outliers=0.0)
    moving, ranges = bool(rng.random() < MOVING), ranges or Ranges()
    if properties.tracked:
        world = build_tracked(source, ranges, rng, moving=moving)
    elif isinstance(source, Robot):
        world = build(source, ranges, rng, moving=moving)
    else:
        world = build_like(source, ranges, rng)
    if properties.imperfection is not None:
        world = properties.imperfection(world, rng)
    sized = _sized_faults(world, _fault_names(kind, properties, world, rng), rng)
    faults = [fault for fault, _ in sized]
    stated = properties.misstated or bool(rng.random() < 0.5)
    factor = float(rng.choice(WRONGLY)) if properties.misstated else 1.0
    dataset = world.read(faults, rng)
    poses = _recorded(dataset.poses, world, faults, rng)
    true = world.noise
    noise = Noise(
        pixel_px=true.pixel_px * factor if stated and true.pixel_px else None,
        point_m=true.point_m * factor if stated and true.point_m else None,
        target_m=true.target_m * factor if true.target_m else None,
    )
    truth = {
        "robot": _robot(source).name,
        "kind": kind,
        "effects": [[fault.effect, fault.where] for fault in faults],
        "noise_floor_mm": round(1e3 * noise_floor_m(world), 4),
        "each": [_described(world, fault, seen, poses) for fault, seen in sized],
        "background": [[small.effect, small.where] for small in world.background],
        "velocities": bool(poses.qd is not None and np.any(poses.qd)),
        "temperatures": poses.temperature_c is not None,
        "noise_stated": factor if stated else None,
        "noise": {
            **{name: sigma for name, sigma in asdict(world.noise).items() if sigma is not None},
            "repeatability_m": world.scatter.size if world.scatter else 0.0,
            "image_px": world.image_px,
            "growth": world.growth,
        },
        "parameters": dict(world.cell.truth),
        "seed": seed,
    }
    return BlindDataset(replace(dataset, name=name, poses=poses, noise=noise), truth)


def _robot(source: Robot | ReferenceCell) -> Robot:
    return source if isinstance(source, Robot) else source.dataset.arm[0]


def _locations(world: World, fault_name: str) -> tuple[str, ...]:
    """Locations of a fault in a cell: for a fault of the library, those that the library can name."""
    model = FAULT_MODELS[fault_name]
    if world.blank.kind == "point" and not model.is_tracked():
        return ()
    locations, effect = model.locations(world.cell.run), _LIBRARY.get(model.effect)
    known = locations if effect is None else effect.locations(world.blank)
    return tuple(location for location in locations if location in known)


def _fault_names(kind: str, properties: Kind, world: World, rng: np.random.Generator) -> list[str]:
    """Faults of a kind that are possible in this cell."""
    possible = [name for name in properties.among if _locations(world, name)]
    number = int(rng.integers(properties.number[0], properties.number[1] + 1))
    if number and not possible:
        raise TrialError(
            f"No world of the kind '{kind}' can be made with the arm '{world.blank.name}': "
            "none of its faults applies to it. A tracker sees neither images nor targets, "
            "and in a URDF without masses nothing deflects."
        )
    names = [str(name) for name in rng.permutation(possible)[:number]]
    if rng.random() < properties.beside:
        names += [str(name) for name in rng.permutation([name for name in DRAWN if _locations(world, name)])[:1]]
    return names + ([OUTLIERS] if rng.random() < properties.outliers else [])


def _sized_faults(
    world: World, names: Sequence[str], rng: np.random.Generator
) -> list[tuple[FaultModel, Detectability]]:
    """Random faults, at different joints as long as there are any, and the detectability of each."""
    least = DETECTABLE
    if world.background:  # faults exceed small errors
        least = max(STANDING_OUT, TIMES * Detectability.of(world, *world.background).misfit)
    sized: list[tuple[FaultModel, Detectability]] = []
    for name in names:
        taken = {fault.where for fault, _ in sized} & {*world.cell.run.joints}
        places = _locations(world, name)
        free = tuple(place for place in places if place not in taken) or places
        sized.append(sized_fault(world, name, free, rng, least_misfit=least))
    return sized


def _recorded(poses: Poses, world: World, faults: Sequence[FaultModel], rng: np.random.Generator) -> Poses:
    """The recorded columns of the poses: some lack velocities, some have a temperature."""
    run = world.cell.run
    if rng.random() < UNTIMED and not any(fault.effect == "latency" for fault in faults):
        poses = replace(poses, qd=None)
    if rng.random() < MEASURED:
        taus = [fault.tau for fault in faults if isinstance(fault, LinkGrowth)]
        warmed = run.warmed(taus[0] if taus else float(np.exp(rng.uniform(*np.log(TAUS)))))
        celsius = ROOM_C + rng.uniform(*WARMER_C) * warmed + THERMOMETER_C * rng.normal(size=len(warmed))
        poses = replace(poses, temperature_c=celsius.round(2))
    return poses


def _described(world: World, fault: FaultModel, seen: Detectability, poses: Poses) -> dict[str, Any]:
    effect = _LIBRARY.get(fault.effect)
    return {
        **asdict(fault),
        "effect": fault.effect,
        "form": fault.form,
        "where": fault.where,
        "misfit": round(seen.misfit, 1),
        "rivals": seen.rivals(fault.effect, fault.where) if effect else [],
        "also_right": [list(pair) for pair in fault.also_right],
        "sites": list(fault.sites(world.cell.run)),
        "classes": [effect.cause or effect.name] if effect else list(fault.classes),
        "values": _values(world, fault, CandidateEffect(effect, fault.where), seen, poses) if effect else {},
        "units": effect.units() if effect else {},
    }


def _values(
    world: World, fault: FaultModel, effect: CandidateEffect, seen: Detectability, poses: Poses
) -> dict[str, float]:
    """True values of the library's parameters at the recorded poses, with small errors of the same kind and place."""
    recorded = replace(seen, dataset=replace(seen.dataset, poses=poses))
    values, run = recorded.nearest(effect, fault.values(world.cell.run)), world.cell.run
    same = [small for small in world.background if (small.effect, small.where) == (fault.effect, fault.where)]
    return {name: value + sum(s.values(run).get(name, 0.0) for s in same) for name, value in values.items()}
