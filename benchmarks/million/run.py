"""Time and memory of `robolaser calibrate` on up to a million stripe points, by stage."""

import argparse
import json
import resource
import subprocess
import sys
import tempfile
import time
from collections.abc import Callable
from pathlib import Path
from typing import TypeVar

from threadpoolctl import threadpool_limits

from robolaser.calibration.calibrate import calibrate
from robolaser.calibration.initialization import find_start
from robolaser.calibration.plan import Plan
from robolaser.calibration.result import as_json
from robolaser.data.loading import load
from robolaser.data.stated_noise import Noise
from robolaser.data.writing import save
from robolaser.estimation.fisher_information import information
from robolaser.estimation.folds import assign_folds, held_out
from robolaser.estimation.noise_estimate import noise_of
from robolaser.estimation.problem import Problem
from robolaser.estimation.robust_reweighting import fit
from robolaser.model.forward_model import Model
from robolaser.report.calibration import page
from robolaser.robot.by_name import find_robot
from robolaser.simulation import simulate

SIZES = ((100, 10), (100, 100), (1000, 100), (1000, 1000))
NOISE = Noise(pixel_px=0.1, target_m=3e-5, joint_rad=1e-5)
PEAK = "VmHWM:"  # in Linux's account of a process; that of getrusage would begin with its parent's
COMMAND = (
    "import sys; from robolaser.cli import main; code = main(sys.argv[1:]); "
    "print(open('/proc/self/status').read(), file=sys.stderr); sys.exit(code)"
)

Result = TypeVar("Result")


def main() -> None:
    options = argparse.ArgumentParser(description=__doc__)
    options.add_argument("--most", type=int, default=1_000_000, help="points of the largest data set")
    most = options.parse_args().most
    print("| points | wall [s] | CPU [s] | peak memory [MB] | read | search | fit | hold out | precision | report |")
    print("|---|---|---|---|---|---|---|---|---|---|")
    for poses, points in SIZES:
        if poses * points <= most:
            with tempfile.TemporaryDirectory() as folder:
                cell = Path(folder) / "cell"
                save(simulate(find_robot("scorbot_er7"), poses=poses, points=points, noise=NOISE, seed=1).dataset, cell)
                whole, cpu, peak = command(cell, Path(folder) / "out")
                stages = " | ".join(f"{seconds:.2f}" for seconds in stages_of(cell))
                print(f"| {poses * points} | {whole:.1f} | {cpu:.1f} | {peak:.0f} | {stages} |", flush=True)


def command(cell: Path, output: Path) -> tuple[float, float, float]:
    """Seconds of `robolaser calibrate` in a process of its own, those of its processor, and its peak memory [MB]."""
    before = resource.getrusage(resource.RUSAGE_CHILDREN)
    began = time.perf_counter()
    arguments = [sys.executable, "-c", COMMAND, "calibrate", str(cell), "--output", str(output)]
    status = subprocess.run(arguments, check=True, capture_output=True, text=True).stderr
    seconds = time.perf_counter() - began
    after = resource.getrusage(resource.RUSAGE_CHILDREN)
    cpu = after.ru_utime + after.ru_stime - before.ru_utime - before.ru_stime
    peak_kb = int(status.split(PEAK)[1].split()[0])
    return seconds, cpu, peak_kb / 1024


def stages_of(cell: Path) -> list[float]:
    """Processor's seconds of each stage, one after the other in this process, all code compiled and loaded."""
    seconds: list[float] = []

    def timed(stage: Callable[[], Result]) -> Result:
        began = time.process_time()
        result = stage()
        seconds.append(time.process_time() - began)
        return result

    dataset = timed(lambda: load(cell))
    model = Model(dataset)
    start = timed(lambda: find_start(model, Plan()))
    problem, x, _ = timed(lambda: fit(model, start.x))
    folds = assign_folds(model, seed=1)
    assert folds is not None
    timed(lambda: held_out(problem, x, folds))
    timed(lambda: information(problem, x, noise_of(model, x).sigmas))
    found = calibrate(dataset, Plan(algorithm="gauss-newton"))
    timed(lambda: (page(found), json.dumps(as_json(found))))
    return seconds


def warm_up() -> None:
    """Compile, and load what is slow to load."""
    found = calibrate(simulate(find_robot("scorbot_er7"), poses=8, points=8, noise=NOISE, seed=1).dataset)
    page(found)
    Problem.of(found.model).residuals(found.x[None])


if __name__ == "__main__":
    with threadpool_limits(limits=1, user_api="blas"):
        warm_up()
        main()
