"""Diagnoses of real robots: how far the gap shrinks on poses that were not fitted, beside what other scripts reach."""

import argparse
import os
import tempfile
from pathlib import Path

os.environ.setdefault("OMP_NUM_THREADS", "1")

import numpy as np

from robolaser.cli import main as robolaser
from robolaser.data.dataset import Dataset
from robolaser.data.loading import load
from robolaser.diagnosis import examine

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
"""Of other fits of the same files [mm]: the README says whose."""


def dataset_of(folder: Path, beside: Path) -> Dataset:
    """A data set, its points taken from its images first where it is a recording."""
    if (folder / "points.csv").exists():
        return load(folder)
    robolaser(["extract", str(folder), "--output", str(beside / folder.name)])
    return load(beside / folder.name)


def main() -> None:
    options = argparse.ArgumentParser(description=__doc__)
    options.add_argument("data", type=Path, nargs="?", default=Path(__file__).parents[3] / "shared" / "data")
    options.add_argument("--only", nargs="*", default=list(TARGETS))
    asked = options.parse_args()
    print("| data set | verdict | nominal | calibrated | after | mean after | floor | others | effects | seconds |")
    print("|---|---|---|---|---|---|---|---|---|---|")
    with tempfile.TemporaryDirectory() as beside:
        for name in asked.only:
            found = examine(dataset_of(asked.data / name, Path(beside)), seed=0)
            gap = found.gap
            mean = float(np.linalg.norm(found.after_m, axis=1).mean())
            effects = ", ".join(
                f"{one.candidate_effect.effect.name} {one.candidate_effect.where}" for one in found.findings
            )
            print(
                f"| {name} | {found.verdict} | {1e3 * gap.nominal_m:.3f} | {1e3 * gap.calibrated_m:.3f} "
                f"| {1e3 * gap.after_m:.3f} | {1e3 * mean:.3f} | {1e3 * gap.noise_floor_m:.3f} | {TARGETS[name]} "
                f"| {effects} | {found.seconds:.0f} |",
                flush=True,
            )


if __name__ == "__main__":
    main()
