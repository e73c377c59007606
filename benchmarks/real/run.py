"""Diagnoses of real robots: errors on held-out poses before and after, and those of other programs' fits."""

import argparse
import os
import tempfile
import time
from collections.abc import Iterator
from pathlib import Path

os.environ.setdefault("OMP_NUM_THREADS", "1")

import numpy as np

from robolaser.cli import main as robolaser
from robolaser.data.dataset import Dataset
from robolaser.data.loading import load
from robolaser.diagnosis import Diagnosis, examine

TARGETS = {
    "ur10-tracker-a": "0.40 rms",
    "ur10-tracker-b": "0.45 rms",
    "mukca-panda_1": "0.79 mean",
    "mukca-panda_3": "0.196 mean",
    "mukca-dinova_1": "",
    "rosi-two-axis": "",
    "etna-s1": "1.21 rms, in sample",
    "etna-s2": "0.28 rms, in sample",
    "etna-s3": "0.47 rms, in sample",
}
"""Errors of other programs' fits of the same files [mm]; the README describes these fits."""
SAME_ARM = {"ur10-tracker-a": "ur10-tracker-b", "ur10-tracker-b": "ur10-tracker-a"}
"""Another campaign of the same arm."""


def dataset_of(folder: Path, beside: Path) -> Dataset:
    """Load a data set; the points of a recording are first extracted into `beside`."""
    if (folder / "points.csv").exists():
        return load(folder)
    robolaser(["extract", str(folder), "--output", str(beside / folder.name)])
    return load(beside / folder.name)


def socket_distances(found: Diagnosis) -> Iterator[float]:
    """Known distances between sockets, from the ball's mean positions in each by the corrected arm [m]."""
    points = found.model.dataset.points
    values = found.model.parameters.values(found.x[None])
    sockets = {name: np.array([values[f"socket.{name}.{axis}"][0] for axis in "xyz"]) for name in set(points.names)}
    errors = found.model.residuals_at(values)[0]
    mean = {name: place - errors[np.array(points.names) == name].mean(axis=0) for name, place in sockets.items()}
    for one, other, _ in found.dataset.distances_m:
        yield float(np.linalg.norm(mean[one] - mean[other]))


def main() -> None:
    options = argparse.ArgumentParser(description=__doc__)
    options.add_argument("data", type=Path, help="folder of the published data sets")
    options.add_argument("--only", nargs="*", default=list(TARGETS))
    args = options.parse_args()
    print("| data set | verdict | nominal | calibrated | after | mean after | floor | others | CPU [s] |")
    print("|---|---|---|---|---|---|---|---|---|", flush=True)
    with tempfile.TemporaryDirectory() as beside:
        for name in args.only:
            others = [load(args.data / SAME_ARM[name])] if name in SAME_ARM else []
            dataset, began = dataset_of(args.data / name, Path(beside)), time.process_time()
            found = examine(dataset, seed=1, validate=others)
            seconds = time.process_time() - began
            gap, mean = found.gap, float(np.linalg.norm(found.after_m, axis=1).mean())
            nominal = "none" if gap.nominal_m is None else f"{1e3 * gap.nominal_m:.3f}"
            print(
                f"| {name} | {found.verdict} | {nominal} | {1e3 * gap.calibrated_m:.3f} "
                f"| {1e3 * gap.after_m:.3f} | {1e3 * mean:.3f} | {1e3 * gap.noise_floor_m:.3f} | {TARGETS[name]} "
                f"| {seconds:.0f} |",
                flush=True,
            )
            for one in found.classes:
                members = ", ".join(f"{member} {p:.2f}" for member, p in one.members)
                sets = "; ".join("{" + ", ".join(map(str, some)) + "}" for some in one.credible_sets)
                print(f"  {one.name} {one.probability:.3f} {one.site}: {members}. Sets: {sets or 'none'}")
            for other in found.validation:
                print(f"  on {other.dataset}: {1e3 * other.calibrated_m:.3f} -> {1e3 * other.after_m:.3f} mm")
            if dataset.kind == "socket":
                print("  sockets [mm]:", *(f"{1e3 * length:.2f}" for length in socket_distances(found)))


if __name__ == "__main__":
    main()
