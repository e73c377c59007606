"""What comparing costs: how much of the cores' time goes into runs, and what a second worker gains.

The same comparison on one worker, on two, and on a Dask scheduler with two worker processes; then the whole: twelve
algorithms on three problems with thirty seeds.
"""

import argparse
import json
import shutil
import subprocess
import sys
import time
from collections.abc import Iterator
from contextlib import contextmanager
from pathlib import Path

from robolaser import RunPlan, compare
from robolaser.benchmark import load
from robolaser.benchmark.engines import DaskCluster, Engine, ThisMachine

ROOT = Path(__file__).parents[2]
FOLDER = ROOT / "build" / "compare"
ROBOLASER = Path(sys.executable).with_name("robolaser")
PROBLEMS = ("paper", "reduced:paper", "pymoo:rastrigin")
TWELVE = "rcga,ga,ga:crossover=arithmetic,ga:mutation=non-uniform,de,pso,es,isres,cmaes,pattern-search,pycma,scipy-de"
BUDGET = 10_000
PORT = 8799


def compared(name: str, *more: str, seeds: int) -> tuple[float, dict[str, object]]:
    """Run the command; how long it took altogether [s], and what comparison.json says."""
    out = FOLDER / name
    shutil.rmtree(out, ignore_errors=True)
    began = time.perf_counter()
    terms = ("--algorithms", TWELVE, "--seeds", str(seeds), "--budget", str(BUDGET))
    subprocess.run(
        [ROBOLASER, "compare", *PROBLEMS, *terms, "--output", out, *more], check=True, stdout=subprocess.DEVNULL
    )
    return time.perf_counter() - began, json.loads((out / "comparison.json").read_text())


def outcomes(name: str) -> dict[tuple[str, str, int], tuple[list[int], list[float]]]:
    """All that does not depend on the clock."""
    return {
        (run.problem, run.algorithm, run.seed): (run.trace.evaluations.tolist(), run.trace.costs.tolist())
        for run in load(FOLDER / name).runs
    }


@contextmanager
def cluster() -> Iterator[str]:
    """A Dask scheduler and two worker processes of one thread each."""
    address = f"tcp://127.0.0.1:{PORT}"
    python = [sys.executable, "-m", "distributed.cli.dask_scheduler", "--port", str(PORT), "--no-dashboard"]
    worker = [sys.executable, "-m", "distributed.cli.dask_worker", address, "--nthreads", "1", "--no-dashboard"]
    silent = {"stdout": subprocess.DEVNULL, "stderr": subprocess.DEVNULL}
    started = [subprocess.Popen(line, **silent) for line in (python, worker, worker)]  # type: ignore[call-overload]
    try:
        time.sleep(5)
        yield address
    finally:
        for process in reversed(started):
            process.terminate()
            process.wait()


def between_runs(engine: Engine, runs: int = 1000) -> float:
    """Time that a worker loses from one run to the next [s]: runs of ten evaluations, start of the workers included."""
    effort = compare(RunPlan.of(["pymoo:sphere-2"], ["random"], seeds=runs, budget=10), engine).effort
    return (effort.capacity_s - effort.busy_s) / runs


def main() -> None:
    options = argparse.ArgumentParser(description=__doc__)
    options.add_argument("--seeds", type=int, default=3, help="of the comparison on one worker, two and Dask")
    options.add_argument("--whole", action="store_true", help="twelve algorithms, three problems, thirty seeds, too")
    args = options.parse_args()
    FOLDER.mkdir(parents=True, exist_ok=True)

    took = {}
    with cluster() as address:
        for name, engine in (("one", ThisMachine(1)), ("two", ThisMachine(2)), ("dask", DaskCluster(address))):
            print(f"between two runs, {name}: {1e3 * between_runs(engine):.1f} ms", flush=True)
        for name, more in (("one", ["--jobs", "1"]), ("two", ["--jobs", "2"]), ("dask", ["--scheduler", address])):
            seconds, said = compared(name, *more, seeds=args.seeds)
            took[name] = said["seconds"]
            print(f"{name}: {seconds:.0f} s, of which runs {said['seconds']:.0f} s; {said['engine']}", flush=True)
    same = outcomes("one") == outcomes("two") == outcomes("dask")
    print(f"the same to the last bit: {same}")
    for name in ("two", "dask"):
        print(f"parallel efficiency, {name}: {took['one'] / took[name] / 2:.3f}")
    if args.whole:
        seconds, said = compared("whole", "--jobs", "2", seeds=30)
        print(f"whole: {seconds:.0f} s; {said['runs']}; {said['engine']}")


if __name__ == "__main__":
    main()
