"""What a comparison costs around runs of 50 ms: CPU time of all its processes over that of the runs, start left out."""

import resource
import tempfile
import time
from pathlib import Path

import numpy as np

from robolaser import RunPlan
from robolaser.benchmark.engines import ThisMachine
from robolaser.benchmark.evaluator import BudgetedEvaluator
from robolaser.benchmark.run_loop import fill
from robolaser.benchmark.table import NAME, RunTable

RUN_S = 0.05
FEW, MANY = 10, 110


def spin(evaluator: BudgetedEvaluator, seed: int) -> None:
    """Search at random for 50 ms of processor time."""
    rng, until = np.random.default_rng(seed), time.process_time() + RUN_S
    while time.process_time() < until:
        evaluator.cost(evaluator.problem.sample_uniform(rng, 100))
    evaluator.record(evaluator.left, np.inf)


def spent() -> float:
    children = resource.getrusage(resource.RUSAGE_CHILDREN)
    return time.process_time() + children.ru_utime + children.ru_stime


def compared(seeds: int) -> np.ndarray:
    """CPU time of all, of this process and of the runs [s]."""
    plan = RunPlan.of(["pymoo:sphere-10"], ["overhead:spin"], seeds=seeds, budget=10**9)
    with tempfile.TemporaryDirectory() as folder, RunTable(Path(folder) / NAME) as table:
        whole, own = spent(), time.process_time()
        with ThisMachine(1) as engine:
            fill(table, plan, engine)
        runs = sum(run.processor_s for run in table.result().runs)
        return np.array([spent() - whole, time.process_time() - own, runs])


if __name__ == "__main__":
    compared(FEW)  # imports, and files that are read for the first time
    whole, own, runs = (compared(MANY) - compared(FEW)) / (MANY - FEW) * 1e3
    print(f"a run: {runs:.1f} ms; with all around it {whole:.1f} ms, {own:.1f} of them in the comparing process")
    print(f"overhead {100 * (whole / runs - 1):.1f} %")
