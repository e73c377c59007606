"""Seconds of a diagnosis against the size of its data."""

import os

os.environ.setdefault("OMP_NUM_THREADS", "1")

from robolaser.data.stated_noise import Noise
from robolaser.diagnosis import examine
from robolaser.robot.by_name import find_robot
from robolaser.simulation import simulate

SIZES = ((25, 10), (50, 20), (100, 40), (300, 40), (1000, 100))
EFFECTS = {"joint_compliance:joint_2": 1e-4}
NOISE = Noise(pixel_px=0.1, target_m=3e-5, joint_rad=1e-5)


def main() -> None:
    print("| poses | points a pose | rows | seconds | ms a row | verdict | effects |")
    print("|---|---|---|---|---|---|---|")
    robot = find_robot("scorbot_er7")
    for poses, points in SIZES:
        cell = simulate(robot, poses=poses, points=points, noise=NOISE, effects=EFFECTS, seed=5)
        found = examine(cell.dataset, seed=0)
        rows = len(cell.dataset.points)
        effects = ", ".join(
            f"{one.candidate_effect.effect.name} {one.candidate_effect.where}" for one in found.findings
        )
        print(
            f"| {poses} | {points} | {rows} | {found.seconds:.1f} | {1e3 * found.seconds / rows:.2f} "
            f"| {found.verdict} | {effects} |",
            flush=True,
        )


if __name__ == "__main__":
    main()
