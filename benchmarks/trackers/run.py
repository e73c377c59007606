"""Real trackers and sockets: the nominal robot's error with fitted base, tool and sockets, and its known value.

The known values were computed from the same files by separate scripts with Pinocchio and SciPy.
"""

import argparse
from pathlib import Path

import numpy as np

from robolaser.calibration.calibrate import calibrate
from robolaser.data.loading import load

KNOWN_RMS_MM = {
    "ur10-tracker-a": 0.847,
    "ur10-tracker-b": 1.113,
    "rosi-two-axis": 0.461,
    "mukca-panda_1": 8.566,
    "mukca-panda_3": 2.835,
    "mukca-dinova_1": 6.117,
}
CLOSE = 0.05


def main() -> None:
    options = argparse.ArgumentParser(description=__doc__)
    options.add_argument("data", type=Path, help="folder of the published data sets")
    data = options.parse_args().data
    print("| data set | poses | RMS [mm] | known [mm] | ratio | median [mm] | held out [mm] | seconds |")
    print("|---|---|---|---|---|---|---|---|")
    for name, known in KNOWN_RMS_MM.items():
        found = calibrate(load(data / name))
        ratio = 1e3 * found.rms_m / known
        median = 1e3 * np.median(np.linalg.norm(found.residuals, axis=1))
        print(
            f"| {name} | {len(found.model.dataset.poses)} | {1e3 * found.rms_m:.3f} | {known:.3f} | {ratio:.4f} "
            f"| {median:.3f} | {1e3 * found.held_out_rms_m:.3f} | {found.seconds:.1f} |",
            flush=True,
        )
        assert abs(ratio - 1) < CLOSE, name


if __name__ == "__main__":
    main()
