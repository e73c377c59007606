"""GA against GA with one operator exchanged on BBOB: on two processes, and on Dask with a killed worker."""

import argparse
import resource
import shutil
import subprocess
import sys
import threading
import time
from collections.abc import Iterator
from contextlib import contextmanager
from pathlib import Path

import iohinspector
import numpy as np

from robolaser import RunPlan
from robolaser.benchmark.engines import DaskCluster, Engine, ThisMachine
from robolaser.benchmark.result import BenchmarkResult
from robolaser.benchmark.result_files import exported
from robolaser.benchmark.run_loop import fill
from robolaser.benchmark.standings import standings
from robolaser.benchmark.statistics.ranks import outcomes
from robolaser.benchmark.statistics.signed_rank import shares
from robolaser.benchmark.statistics.superiority import wins
from robolaser.benchmark.table import NAME, RunTable
from robolaser.data.result_folder import write_results

FOLDER = Path(__file__).parents[2] / "build" / "bbob"
TWO = ("GA", "GA+crossover=ArithmeticCrossover")
PORT = 8798


def made(name: str, plan: RunPlan, engine: Engine) -> BenchmarkResult:
    """Make all runs, and write them for IOHinspector."""
    out = FOLDER / name
    shutil.rmtree(out, ignore_errors=True)
    out.mkdir(parents=True)
    began = time.perf_counter()
    with engine, RunTable(out / NAME) as table:
        fill(table, plan, engine)
        result = table.result(plan)
    write_results(out, exported(result, iohprofiler=True))
    taken = time.perf_counter() - began
    print(
        f"{name}: {len(result.runs)} runs, {len(result.failures)} failed, {taken:.0f} s, busy {result.effort.busy:.0%}"
    )
    return result


@contextmanager
def cluster(kill_after_s: float) -> Iterator[str]:
    """A Dask scheduler and two workers, one of which is killed after a while."""
    address = f"tcp://127.0.0.1:{PORT}"
    python = [sys.executable, "-m", "distributed.cli.dask_scheduler", "--port", str(PORT), "--no-dashboard"]
    worker = [sys.executable, "-m", "distributed.cli.dask_worker", address, "--nthreads", "1", "--no-dashboard"]
    worker += ["--no-nanny"]
    silent = {"stdout": subprocess.DEVNULL, "stderr": subprocess.DEVNULL}
    started = [subprocess.Popen(line, **silent) for line in (python, worker, worker)]  # type: ignore[call-overload]
    killer = threading.Timer(kill_after_s, started[-1].kill)
    try:
        time.sleep(8)
        killer.start()
        yield address
        print(f"the second worker ended with {started[-1].poll()}, the first with {started[1].poll()}")
    finally:
        killer.cancel()
        for process in reversed(started):
            process.terminate()
            process.wait()


def courses(result: BenchmarkResult) -> dict[tuple[str, str, int], tuple[list[int], list[float]]]:
    """All that does not depend on the clock."""
    return {run.key: (run.trace.evaluations.tolist(), run.trace.costs.tolist()) for run in result.runs}


def read(name: str, result: BenchmarkResult) -> None:
    """Compare what IOHinspector reads with what was run."""
    manager = iohinspector.DataManager()
    manager.add_folder(str(FOLDER / name / "iohprofiler"))
    rows = manager.overview.select("algorithm_name", "function_name", "instance", "evals", "best_y").rows()
    same = sorted(rows) == sorted((r.algorithm, r.problem, r.seed, r.evaluations, r.trace.final) for r in result.runs)
    print(f"{name}: IOHinspector reads {len(rows)} runs, all as they were: {same}")


def main() -> None:
    options = argparse.ArgumentParser(description=__doc__)
    options.add_argument("--functions", type=int, default=24)
    options.add_argument("--instances", type=int, default=15)
    options.add_argument("--budget", type=int, default=1000)
    args = options.parse_args()
    problems = [f"bbob:{f}-10:instance={i}" for f in range(1, args.functions + 1) for i in range(1, args.instances + 1)]
    plan = RunPlan.of(problems, TWO, seeds=1, budget=args.budget)

    here = made("two processes", plan, ThisMachine(2))
    with cluster(kill_after_s=max(2.0, here.effort.seconds / 2)) as address:
        there = made("dask", plan, DaskCluster(address, plan.packages))
    print(f"the same to the last bit: {courses(here) == courses(there)}")
    read("two processes", here)
    read("dask", there)

    for family in here.families:
        print(*standings(here, family).effects, sep="\n")
        arrays = here.arrays(family)
        for tolerance in (1.0, 1e-2):
            reached = np.isfinite(arrays.evaluations[..., arrays.target(tolerance)]).sum(axis=(0, 2))
            print(f"within {tolerance:g}: {dict(zip(arrays.algorithms, reached.tolist(), strict=True))}")
        won = wins(outcomes(arrays.evaluations[..., arrays.target(1e-2)], arrays.final))[:, 1, 0]
        of_functions = won.reshape(args.functions, args.instances).mean(axis=1)
        print("share of instances won by the exchange, by function:", np.round(of_functions, 2).tolist())
        probable = shares(of_functions - 0.5, np.random.default_rng(1)).argmax(axis=1)
        print(
            "Bayesian signed-rank over functions, better, alike, worse:",
            np.bincount(probable, minlength=3) / len(probable),
        )
    used = sum(sum(resource.getrusage(who)[:2]) for who in (resource.RUSAGE_SELF, resource.RUSAGE_CHILDREN))
    print(f"{used:.0f} s of CPU time")


if __name__ == "__main__":
    main()
