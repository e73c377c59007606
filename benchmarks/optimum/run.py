"""Who finds the lowest J, how surely and how soon? robolaser and its peers on eleven calibrations.

Every run is a line of build/optimum.jsonl; what stands there is not run again. The best known J of an experiment is the
lowest of a polish from the true parameters and of all runs, whosever.
"""

import os

os.environ.setdefault("OMP_NUM_THREADS", "1")

import argparse
import json
import time
from dataclasses import asdict, dataclass
from functools import cache
from pathlib import Path
from typing import final

import numpy as np
from experiments import EXPERIMENTS
from peers import PEERS, race

from robolaser.calibration.initialization import find_start
from robolaser.calibration.plan import Plan
from robolaser.estimation.problem import Problem
from robolaser.estimation.robust_reweighting import fit
from robolaser.estimation.solver import solve
from robolaser.model.forward_model import Model

OURS = "robolaser"
RELATIVE, ABSOLUTE_M2 = 1e-6, 1e-18
STORE = Path("build/optimum.jsonl")


@final
@dataclass(frozen=True)
class Run:
    """One run of one way on one experiment: the lowest J [m²] and its processor time [s]."""

    experiment: str
    way: str
    seed: int
    J: float
    seconds: float


def main() -> None:
    options = argparse.ArgumentParser(description=__doc__)
    options.add_argument("--seeds", type=int, default=5, help="of robolaser")
    options.add_argument("--repeats", type=int, default=1, help="of each peer")
    options.add_argument("--cap", type=float, default=20, help="a peer's time, in medians of robolaser's")
    options.add_argument("--full", action="store_true", help="200 seeds, 3 repeats, cap 100: the README's table; hours")
    options.add_argument("--ours-only", action="store_true")
    options.add_argument("--only", default="", help="experiments whose name has this in it")
    options.add_argument("--fresh", action="store_true", help="forget earlier runs")
    args = options.parse_args()
    if args.full:
        args.seeds, args.repeats, args.cap = 200, 3, 100.0
    names = [name for name in EXPERIMENTS if args.only in name]
    if args.fresh:
        STORE.unlink(missing_ok=True)
    for name in names:
        known = {(run.way, run.seed): run for run in stored() if run.experiment == name}
        for seed in range(args.seeds):
            if (OURS, seed) not in known:
                known[OURS, seed] = keep(ours(name, seed))
        middle = float(np.median([run.seconds for (way, _), run in known.items() if way == OURS]))
        for seed in range(0 if args.ours_only else args.repeats):
            for peer in PEERS:
                if (peer, seed) not in known and suits(peer, name):
                    goal = limit(best_known(name, list(known.values())))
                    seconds, J = race(peer, model(name), goal, args.cap * middle, seed)
                    known[peer, seed] = keep(Run(name, peer, seed, J, seconds))
        print(f"{name}: done", flush=True)
    tables(names, [run for run in stored() if run.experiment in names and (run.way != OURS or run.seed < args.seeds)])


def tables(names: list[str], runs: list[Run]) -> None:
    of = {name: [run for run in runs if run.experiment == name] for name in names}
    best = {name: best_known(name, of[name]) for name in names}
    print("\n| experiment | best known J [m²] | seeds that reach it | median [s] | slowest [s] |")
    print("|---|---|---|---|---|")
    for name in names:
        mine = [run for run in of[name] if run.way == OURS]
        seconds = [run.seconds for run in mine]
        reached = sum(reaches(run, best[name]) for run in mine)
        print(
            f"| {name} | {best[name]:.6e} | {reached} of {len(mine)} | {np.median(seconds):.3f} | {max(seconds):.3f} |"
        )
    ways = [way for way in PEERS if any(run.way == way for run in runs)]
    if not ways:
        return
    print("\n| experiment | " + " | ".join(ways) + " |")
    print("|---" * (1 + len(ways)) + "|")
    for name in names:
        middle = float(np.median([run.seconds for run in of[name] if run.way == OURS]))
        cells = [ratios([run for run in of[name] if run.way == way], best[name], middle) for way in ways]
        print(f"| {name} | " + " | ".join(cells) + " |")


def ratios(runs: list[Run], best: float, middle: float) -> str:
    """Times of success over ours: median, least and greatest; ≥ where the time was up."""
    if not runs:
        return ""
    found = sorted((run.seconds / middle, reaches(run, best)) for run in runs)

    def said(i: int) -> str:
        times, reached = found[i]
        return f"{'' if reached else '≥ '}{times:.3g}"

    if len(found) == 1 or not any(reached for _, reached in found):
        return said(0)
    return f"{said(len(found) // 2)} ({said(0)} to {said(-1)})"


def ours(name: str, seed: int) -> Run:
    """What `calibrate` does before it asks how well the result is known."""
    warm(name)
    began = time.process_time()
    J = found(model(name), seed)
    return Run(name, OURS, seed, J, time.process_time() - began)


def found(seen: Model, seed: int) -> float:
    _, x, _ = fit(seen, find_start(seen, Plan(seed=seed)).x)
    return float(seen.cost(x[None])[0])


@cache
def warm(name: str) -> None:
    """Compile and import what the first run would else be timed with."""
    found(model(name), 0)


@cache
def model(name: str) -> Model:
    return Model(EXPERIMENTS[name]().dataset)


@cache
def truth(name: str) -> float:
    """J of the optimum next to the true parameters [m²]."""
    made, seen = EXPERIMENTS[name](), model(name)
    x = seen.fix_gauge(np.array([made.truth[key] for key in seen.parameters.names]))
    return float(solve(Problem.of(seen), x[None]).cost[0])


def best_known(name: str, runs: list[Run]) -> float:
    """The lowest J of all that anybody found [m²]."""
    return min([truth(name), *(run.J for run in runs)])


def reaches(run: Run, best: float) -> bool:
    """Whether a run found the optimum."""
    return limit(best) >= run.J


def limit(best: float) -> float:
    """J that counts as the best known [m²]."""
    return best * (1 + RELATIVE) + ABSOLUTE_M2


def suits(peer: str, name: str) -> bool:
    """Whether a peer can be asked: the plain NumPy residuals know placed targets whose stripe runs along u."""
    dataset = model(name).dataset
    return "NumPy" not in peer or (dataset.placed and dataset.stripe_axis == "u")


def stored() -> list[Run]:
    if not STORE.exists():
        return []
    return [Run(**json.loads(line)) for line in STORE.read_text().splitlines()]


def keep(run: Run) -> Run:
    STORE.parent.mkdir(exist_ok=True)
    with STORE.open("a") as file:
        file.write(json.dumps(asdict(run)) + "\n")
    return run


if __name__ == "__main__":
    main()
