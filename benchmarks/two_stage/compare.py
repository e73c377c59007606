"""Held-out 3-D errors of robolaser and of the usual two-stage way, on the same points and the same folds."""

import argparse
import json
import time
from collections.abc import Callable, Iterator
from dataclasses import dataclass
from pathlib import Path
from typing import final

import cv2
import numpy as np
from peer import LENSES, View, find_camera, two_stage
from recording import Recording, measure

from robolaser.arrays import Array, Bools, Ints
from robolaser.calibration.calibrate import Plan, calibrate
from robolaser.estimation.folds import assign_folds
from robolaser.estimation.problem import Problem
from robolaser.estimation.solver import solve
from robolaser.model.forward_model import Model

SETS = ("etna-s1", "etna-s2", "etna-s3")
DRAWS = 2000  # of poses with replacement, for the spread of a ratio
OURS = {
    "robolaser, the paper's 14": Plan(),
    "robolaser --with laser_roll": Plan(effects=("laser_roll",)),
    "robolaser --with laser_roll --weights noise": Plan(effects=("laser_roll",), weights="noise"),
}
VARIANTS: dict[str, dict[str, bool]] = {
    "": {},
    ", target by stripe": {"place_by_stripe": True},
    ", robust": {"robust": True},
}
HEADING = """| way | fitted | held out | lowest to highest deal | against laser_roll (90 % over poses) | pose by pose |
|---|---|---|---|---|---|"""

Errors = Callable[[Ints], Array]
"""Held-out errors (m, 3) [m] for the fold of each row."""


@final
@dataclass(frozen=True)
class Way:
    """A way to calibrate: errors on the points it was fitted to, and on those held out."""

    name: str
    fitted: Array
    held_out: Errors


def rms_mm(errors: Array) -> float:
    return float(1e3 * np.sqrt((errors**2).sum(axis=-1).mean()))


def two_stage_way(name: str, recording: Recording, lens: str, others: list[View], **variant: bool) -> Way:
    dataset, points = recording.dataset, recording.dataset.points
    T, image_px = dataset.poses.T_base_flange, dataset.image_px
    assert T is not None
    assert image_px is not None
    assert points.pixel is not None
    assert points.xyz is not None

    def errors(kept: Bools) -> Array:
        views = [view for view, keep in zip(recording.views, kept, strict=True) if keep]
        rows = kept[points.pose]
        found = two_stage(
            views=views,
            T_base_flange=T[kept],
            of_image=(np.cumsum(kept) - 1)[points.pose[rows]],
            pixel=points.pixel[rows],
            place=points.xyz[rows],
            camera=find_camera([*views, *others], image_px, lens),
            **variant,
        )
        return found.residuals(T[points.pose], points.pixel, points.xyz)

    def unseen(fold: Ints) -> Array:
        E = np.full((len(points), 3), np.nan)
        for out in np.unique(fold):
            gone = np.unique(points.pose[fold == out])
            E[fold == out] = errors(~np.isin(np.arange(len(T)), gone))[fold == out]
        return E

    return Way(name, errors(np.ones(len(T), dtype=bool)), unseen)


def our_way(name: str, recording: Recording, plan: Plan) -> Way:
    dataset = recording.dataset
    found = calibrate(dataset, plan)
    problem = Problem.of(found.model, found.weighted.shots if found.weighted else None)

    def unseen(fold: Ints) -> Array:
        E = np.full((len(fold), 3), np.nan)
        for out in np.unique(fold):
            end = solve(problem, found.x[None], tol=1e-9, kept=(fold != out)[None])
            E[fold == out] = found.model.residuals(end.x)[0, fold == out]
        return E

    return Way(name, found.residuals, unseen)


def all_ways(recording: Recording, others: list[View]) -> Iterator[Way]:
    """Ours, then the two-stage way in all its variants; `others` are boards of the same camera in other sets."""
    for name, plan in OURS.items():
        yield our_way(name, recording, plan)
    for lens in LENSES:
        for images, more in (("own images", []), ("images of all sets", others)):
            for label, variant in VARIANTS.items():
                yield two_stage_way(f"two-stage, {lens}, {images}{label}", recording, lens, more, **variant)


def partition(pose: Ints, fold: Ints) -> frozenset[frozenset[int]]:
    """Which poses are left out together."""
    return frozenset(frozenset(pose[fold == out].tolist()) for out in np.unique(fold))


def ratio_interval(pose: Ints, above: Array, below: Array) -> tuple[float, float]:
    """90 % of the ratios of two RMS that poses drawn with replacement give."""
    seen, number = np.unique(pose, return_inverse=True)
    a, b = (np.bincount(number, (E**2).sum(axis=-1)) for E in (above, below))
    drawn = np.random.default_rng(1).integers(len(seen), size=(DRAWS, len(seen)))
    low, high = np.quantile(np.sqrt(a[drawn].sum(axis=1) / b[drawn].sum(axis=1)), (0.05, 0.95))
    return float(low), float(high)


def main() -> None:
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument("data", type=Path, help="folder of the published data sets")
    parser.add_argument("--sets", nargs="+", default=SETS)
    parser.add_argument("--seeds", type=int, default=5, help="deals of the poses into folds")
    parser.add_argument("--json", type=Path)
    args = parser.parse_args()
    cv2.setNumThreads(1)
    recordings = {name: measure(args.data / name) for name in args.sets}
    print(f"OpenCV {cv2.__version__}. 3-D RMS [mm] over all points; held out by pose: mean over {args.seeds} deals.\n")
    record = {}
    for name, recording in recordings.items():
        pose = recording.dataset.points.pose
        others = [view for other, one in recordings.items() if other != name for view in one.views]
        print(f"### {name}: {len(recording.views)} poses, {len(pose)} points\n")
        print(HEADING)
        folds = [assign_folds(Model(recording.dataset), seed).of_row for seed in range(1, args.seeds + 1)]
        measured: dict[str, tuple[Array, list[Array]]] = {}
        for way in all_ways(recording, others):
            done: dict[frozenset[frozenset[int]], Array] = {}
            for fold in folds:
                key = partition(pose, fold)
                if key not in done:
                    done[key] = way.held_out(fold)
            runs = [done[partition(pose, fold)] for fold in folds]
            measured[way.name] = (way.fitted, runs)
            values = [rms_mm(run) for run in runs]
            base = measured.get("robolaser --with laser_roll")
            against = ""
            if base is not None:
                ratio = np.mean([rms_mm(a) / rms_mm(b) for a, b in zip(runs, base[1], strict=True)])
                low, high = ratio_interval(pose, np.concatenate(runs, 1), np.concatenate(base[1], 1))
                against = f"{ratio:.2f} ({low:.2f} to {high:.2f})"
            by_pose = " ".join(f"{rms_mm(runs[0][pose == p]):.2f}" for p in np.unique(pose))
            spread = f"{min(values):.3f} to {max(values):.3f}"
            print(
                f"| {way.name} | {rms_mm(way.fitted):.3f} | {np.mean(values):.3f} | {spread} | {against} | {by_pose} |",
                flush=True,
            )
            record.setdefault(name, {})[way.name] = {"fitted_mm": rms_mm(way.fitted), "held_out_mm": values}
        print()
    if args.json:
        args.json.write_text(json.dumps(record, indent=1) + "\n")


if __name__ == "__main__":
    began = time.perf_counter()
    main()
    print(f"{time.perf_counter() - began:.0f} s")
