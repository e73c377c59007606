"""Time and memory of `robolaser calibrate` on up to a million stripe points."""

import argparse
import resource
import subprocess
import sys
import tempfile
import time
from pathlib import Path

from robolaser.data.stated_noise import Noise
from robolaser.data.writing import save
from robolaser.robot.by_name import find_robot
from robolaser.simulation import simulate

SIZES = ((100, 10), (100, 100), (1000, 100), (1000, 1000))
NOISE = Noise(pixel_px=0.1, target_m=3e-5, joint_rad=1e-5)
PEAK = "VmHWM:"  # in /proc/PID/status; the peak of getrusage starts at that of the parent
COMMAND = (
    "import sys; from robolaser.cli import main; code = main(sys.argv[1:]); "
    "print(open('/proc/self/status').read(), file=sys.stderr); sys.exit(code)"
)


def main() -> None:
    options = argparse.ArgumentParser(description=__doc__)
    options.add_argument("--most", type=int, default=1_000_000, help="points of the largest data set")
    most = options.parse_args().most
    print("| points | wall [s] | CPU [s] | peak memory [MB] |\n|---|---|---|---|")
    for poses, points in SIZES:
        if poses * points <= most:
            with tempfile.TemporaryDirectory() as folder:
                cell = Path(folder) / "cell"
                save(simulate(find_robot("scorbot_er7"), poses=poses, points=points, noise=NOISE, seed=1).dataset, cell)
                whole, cpu, peak = command(cell, Path(folder) / "out")
                print(f"| {poses * points} | {whole:.1f} | {cpu:.1f} | {peak:.0f} |", flush=True)


def command(cell: Path, output: Path) -> tuple[float, float, float]:
    """Wall seconds, CPU seconds and peak memory [MB] of `robolaser calibrate` in a separate process."""
    before = resource.getrusage(resource.RUSAGE_CHILDREN)
    began = time.perf_counter()
    arguments = [sys.executable, "-c", COMMAND, "calibrate", str(cell), "--output", str(output)]
    status = subprocess.run(arguments, check=True, capture_output=True, text=True).stderr
    seconds = time.perf_counter() - began
    after = resource.getrusage(resource.RUSAGE_CHILDREN)
    cpu = after.ru_utime + after.ru_stime - before.ru_utime - before.ru_stime
    peak_kb = int(status.split(PEAK)[1].split()[0])
    return seconds, cpu, peak_kb / 1024


if __name__ == "__main__":
    main()
