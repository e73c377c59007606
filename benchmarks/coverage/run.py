"""Coverage of the standard errors of whole calibrations.

Each trial builds a new scanner, plans new poses, measures with noise, and calibrates from the nominal values, not from
the truth. For every parameter with a standard error, it checks whether value ± 1.96 std contains the true value.
"""

import argparse

import numpy as np

from robolaser.calibration.calibrate import Plan, calibrate
from robolaser.data.stated_noise import Noise
from robolaser.model.forward_model import Model
from robolaser.robot.by_name import find_robot
from robolaser.simulation import CellOptions, simulate

CASES = {
    "stripe, noise stated": ("stripe", Noise(pixel_px=0.1, target_m=5e-5), None, "plain"),
    "stripe, noise not stated": ("stripe", Noise(pixel_px=0.1, target_m=5e-5), Noise(), "plain"),
    "stripe, joint noise too, not stated": ("stripe", Noise(pixel_px=0.1, joint_rad=1e-4), Noise(), "plain"),
    "stripe, weighted by the noise": ("stripe", Noise(pixel_px=0.1, target_m=5e-5), None, "noise"),
    "tracker, joint noise, not stated": ("point", Noise(point_m=2e-5, joint_rad=1e-4), Noise(), "plain"),
    "sockets, joint noise, not stated": ("socket", Noise(joint_rad=1e-4), Noise(), "plain"),
}


def main() -> None:
    options = argparse.ArgumentParser(description=__doc__)
    options.add_argument("--trials", type=int, default=100)
    args = options.parse_args()
    robot = find_robot("scorbot_er7")
    print("| case | intervals | contain the truth | claimed | spread of error / std |")
    print("|---|---|---|---|---|")
    for name, (kind, noise, stated, weights) in CASES.items():
        scores = []
        for seed in range(args.trials):
            made = simulate(robot, kind=kind, poses=30, noise=noise, options=CellOptions(stated=stated), seed=seed)
            found = calibrate(made.dataset, Plan(algorithm="gauss-newton", weights=weights, seed=seed))
            truth = Model(made.dataset).fix_gauge(np.array([made.truth[n] for n in found.model.parameters.names]))
            scores += ((found.x - truth) / found.std)[np.isfinite(found.std)].tolist()
        inside = np.mean(np.abs(scores) < 1.96)
        print(f"| {name} | {len(scores)} | {inside:.1%} | 95 % | {np.std(scores):.2f} |", flush=True)


if __name__ == "__main__":
    main()
