"""The lowest J of each instance of the suite, by many descents.

Writes robolaser/problems/calibration_suite/instances.toml. Descents are robolaser's bounded Levenberg-Marquardt or,
for reduced instances, SciPy's; the lowest result is refined by SciPy in all variables of the instance. Named instances
are computed again; without names, the missing ones.
"""

import json
import sys
import time
from dataclasses import asdict, replace

import numpy as np
from scipy.optimize import least_squares

from robolaser.estimation.problem import Problem
from robolaser.estimation.solver import solve
from robolaser.parameters import Parameters
from robolaser.problems.calibration_suite import TABLE, TARGET, Instance, SuiteProblem, instances

AT_ONCE = 25
OFFSETS, LINKS = ("joint_offset",), ("link_geometry",)
SCANNER = "a laser scanner on an arm"
INSTANCES = (
    (Instance("lee2004", "the experiment of Lee et al. 2004, simulated: 25 points in 5 poses", "lee2004"), 400),
    (Instance("lee2004-fixed", "the same, its focal length fixed: no gauge", "lee2004", held=("f",)), 400),
    (Instance("lee2004-reduced", "the same without what follows in closed form", "lee2004", reduced=True), 100),
    (Instance("ten-points", f"{SCANNER}, simulated: ten points", "ten-points"), 400),
    (Instance("ur10-pixels", f"{SCANNER}, simulated: noise of pixels", "ur10-pixels", held=("f",)), 200),
    (Instance("level-views", f"{SCANNER}, simulated: tilts that are alike", "level-views"), 400),
    (Instance("like-views", f"{SCANNER}, simulated: turns that are alike", "like-views", held=("f",)), 400),
    (Instance("along-v", f"{SCANNER}, simulated: the stripe along v", "along-v"), 400),
    (Instance("unplaced", f"{SCANNER}, simulated: the target anywhere", "unplaced"), 200),
    (Instance("etna-s2", "a laser head's scanner", "etna-s2", ("laser_roll",)), 200),
    (Instance("etna-s3", "the same head, another session; no gauge", "etna-s3", ("laser_roll",), ("f",)), 200),
    (Instance("camera-in-hand", "a camera on an arm, simulated", "camera-in-hand"), 200),
    (Instance("ur3e-camera", "a camera beside a UR3e", "ur3e-camera"), 200),
    (Instance("ball-profiles", "a profile sensor and three balls, simulated", "ball-profiles"), 200),
    (Instance("ur5-tracker", "a UR5 before a laser tracker", "ur5-tracker"), 200),
    (Instance("ur5-offsets", "the same with the joints' zeros", "ur5-tracker", OFFSETS), 200),
    (Instance("ur5-links", "the same with the links' geometry", "ur5-tracker", LINKS), 100),
    (Instance("ur10-links", "a UR10 before a laser tracker; its links' geometry", "ur10-tracker", LINKS), 60),
    (Instance("panda-1-offsets", "a Panda's ball in sockets; its joints' zeros", "panda-1-sockets", OFFSETS), 200),
    (Instance("dinova-offsets", "a Gen3 lite's ball in sockets; its joints' zeros", "dinova-sockets", OFFSETS), 200),
    (Instance("panda-3-scales", "a Panda's ball in sockets; its joints' zeros and scales", "panda-3-sockets",
              (*OFFSETS, "encoder_scale")), 100),
)  # fmt: skip


def main() -> None:
    """Compute the named or missing instances, and write all known ones."""
    known = dict(instances()) if TABLE.exists() else {}
    for instance, starts in INSTANCES:
        if instance.id in sys.argv[1:] or (not sys.argv[1:] and instance.id not in known):
            began = time.process_time()
            known[instance.id] = proved(instance, starts)
            print(known[instance.id], f"{time.process_time() - began:.0f} s", flush=True)
            TABLE.write_text("\n".join(entry(known[one.id]) for one, _ in INSTANCES if one.id in known))


def proved(instance: Instance, starts: int, seed: int = 1) -> Instance:
    """The instance with the lowest J of many descents from random starts within the bounds."""
    problem = SuiteProblem(instance)
    x = np.random.default_rng(seed).uniform(problem.xl, problem.xu, (starts, problem.dimension))
    ends = _by_scipy(problem, x) if instance.reduced else _by_ours(problem, x)
    costs = problem.evaluate(ends)[:, 0]
    best = polished(problem, ends[int(np.argmin(costs))])
    lowest = problem(best)
    return replace(
        instance,
        best=lowest,
        best_x=tuple(best.tolist()),
        starts=starts,
        reached=int((costs <= TARGET * lowest).sum()),
    )


def _by_ours(problem: SuiteProblem, starts: np.ndarray) -> np.ndarray:
    """Results of descents with the gauge fixed at the start's values, (c, dimension)."""
    whole, model = problem.model.parameters, problem.model
    bounds = [
        replace(item, lower=item.nominal, upper=item.nominal) if item.name not in problem.names else item
        for item in whole.items
    ]
    bounded = Problem.of(model, parameters=Parameters(tuple(bounds)))
    full = np.array([model.fix_gauge(x) for x in problem.completed(starts)])
    chunks = np.array_split(full, -(-len(full) // AT_ONCE))
    ends = np.concatenate([solve(bounded, chunk).x for chunk in chunks])
    return np.clip(ends[:, whole.columns(problem.names)], problem.xl, problem.xu)


def _by_scipy(problem: SuiteProblem, starts: np.ndarray) -> np.ndarray:
    return np.array([_descent(problem, x, 60) if np.isfinite(problem(x)) else x for x in starts])


def polished(problem: SuiteProblem, x: np.ndarray) -> np.ndarray:
    """The result of SciPy's descent from x, or x if that is lower."""
    end = _descent(problem, x, 300)
    return end if problem(end) < problem(x) else x


def _descent(problem: SuiteProblem, x: np.ndarray, steps: int) -> np.ndarray:
    width = problem.xu - problem.xl

    def residuals(u: np.ndarray) -> np.ndarray:
        found = problem.model.residuals(problem.completed((problem.xl + u * width)[None])).ravel()
        return np.where(np.isfinite(found), found, 1e6)

    u = np.clip((x - problem.xl) / width, 1e-12, 1 - 1e-12)
    found = least_squares(residuals, u, bounds=(0, 1), xtol=1e-15, ftol=1e-15, gtol=1e-15, max_nfev=steps)
    return np.clip(problem.xl + found.x * width, problem.xl, problem.xu)


def entry(instance: Instance) -> str:
    """The instance's table in instances.toml."""
    keys = {key: value for key, value in asdict(instance).items() if key != "id" and value not in ((), False)}
    lines = [f"{key} = {json.dumps(value)}" for key, value in keys.items()]
    return "\n".join([f"[{instance.id}]", *lines, ""])


if __name__ == "__main__":
    main()
