"""Diagnose blind worlds of several robots, and say how often the diagnosis was right, robot by robot.

    python benchmarks/blind/run.py --seeds 100-140

One world for each robot and seed, of a kind that the seed decides. Worlds are kept between runs; `--fresh` makes
them anew, which they need once the effect library has changed (their rivals are drawn from it).
"""

import argparse
import json
import os
import sys
import tempfile
import time
import traceback
from concurrent.futures import ProcessPoolExecutor, as_completed
from dataclasses import dataclass
from pathlib import Path
from typing import Any

os.environ.setdefault("OMP_NUM_THREADS", "1")

import numpy as np

import robolaser
from robolaser.commands.challenge import summary
from robolaser.diagnosis import examine
from robolaser.diagnosis.result_json import diagnosis_json
from robolaser.robot.by_name import find_robot
from robolaser.trials.kinds import USUAL
from robolaser.trials.making import make
from robolaser.trials.outcome import Outcome, outcome
from robolaser.trials.score import compile_score
from robolaser.trials.synthetic.fault_models import MODELLED

ROBOTS = ("scorbot_er7", "ur5", "panda", "xarm7")


@dataclass(frozen=True)
class Task:
    """One world, and what to do with it."""

    robot: str
    seed: int
    kind: str
    cache: Path
    fresh: bool
    only_make: bool
    withhold: bool

    @property
    def folder(self) -> Path:
        """Where the world is kept."""
        return self.cache / f"{self.robot}-{self.seed}-{self.kind}"


def kind_of(robot: str, seed: int, kinds: list[str]) -> str:
    """A kind by chance."""
    shares = np.array([USUAL.get(kind, 1.0) for kind in kinds])
    return str(np.random.default_rng([seed, *robot.encode()]).choice(kinds, p=shares / shares.sum()))


def world(task: Task) -> dict[str, Any]:
    """Make a world, unless it is there; its truth."""
    file = task.folder / "truth.json"
    if task.fresh or not file.exists():
        made = make(find_robot(task.robot), task.kind, seed=task.seed, name=task.folder.name)
        robolaser.save(made.dataset, task.folder, overwrite=True)
        file.write_text(json.dumps(made.truth))
    truth: dict[str, Any] = json.loads(file.read_text())
    return truth


def run(task: Task) -> tuple[dict[str, Any], dict[str, Any] | str, float]:
    truth = world(task)
    if task.only_make:
        return truth, "", 0.0
    began = time.perf_counter()
    try:
        dataset = robolaser.load(task.folder)
        taken_out = tuple(
            {item["effect"] for item in truth["each"] if item["effect"] in MODELLED} if task.withhold else ()
        )
        for item in truth["each"]:
            item["withheld"] = item["effect"] in taken_out
        found: dict[str, Any] | str = diagnosis_json(examine(dataset, seed=1, without=taken_out))
    except Exception:  # a world that breaks the diagnosis is a result too
        found = traceback.format_exc()
    return truth, found, time.perf_counter() - began


def main() -> None:
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("--seeds", default="100-110", help="A-B, both ends included")
    parser.add_argument("--robots", default=",".join(ROBOTS))
    parser.add_argument("--kinds", default=",".join(USUAL))
    parser.add_argument("--jobs", type=int, default=2)
    parser.add_argument("--cache", type=Path, default=Path(tempfile.gettempdir()) / "robolaser-blind")
    parser.add_argument("--fresh", action="store_true", help="make the worlds anew")
    parser.add_argument("--withhold", action="store_true", help="take the true effects out of the library first")
    parser.add_argument("--only-make", action="store_true", help="make worlds, diagnose nothing")
    parser.add_argument("--output", type=Path, help="a folder for the diagnoses and score.json")
    args = parser.parse_args()
    first, _, last = args.seeds.partition("-")
    kinds = args.kinds.split(",")
    tasks = [
        Task(robot, seed, kind_of(robot, seed, kinds), args.cache, args.fresh, args.only_make, args.withhold)
        for seed in range(int(first), int(last or first) + 1)
        for robot in args.robots.split(",")
    ]
    outcomes: dict[str, dict[str, Outcome]] = {robot: {} for robot in args.robots.split(",")}
    seconds, broken = [], 0
    with ProcessPoolExecutor(args.jobs) as pool:
        futures = {pool.submit(run, task): task for task in tasks}
        for done, future in enumerate(as_completed(futures), 1):
            task = futures[future]
            truth, found, spent = future.result()
            print(f"{done}/{len(tasks)} {task.folder.name} {spent:.1f} s", file=sys.stderr)
            if args.only_make:
                print(f"{task.folder.name:32} {_places(truth['each'])}", flush=True)
                continue
            if isinstance(found, str):
                broken += 1
                print(f"{task.folder.name:32} BROKE\n{found}", flush=True)
                continue
            seconds.append(spent)
            if args.output:
                args.output.mkdir(parents=True, exist_ok=True)
                (args.output / f"{task.folder.name}.json").write_text(json.dumps(found, indent=1))
            seen = outcome(truth, found)
            outcomes[task.robot][task.folder.name] = seen
            if not seen.right:
                said = ", ".join(
                    f"{e['effect']}:{e['where']} {e['probability']:.2f}"
                    + (f" ~{len(e['indistinguishable_from'])}" if e["indistinguishable_from"] else "")
                    for e in found["effects"]
                )
                left = "-" if seen.left is None else f"{seen.left:.2f}"
                print(
                    f"{task.folder.name:32} {seen.group:10} {_places(truth['each'])}\n"
                    f"{'':32} {found['verdict']:10} {said or 'nothing'}; left {left}, {spent:.1f} s",
                    flush=True,
                )
    if args.only_make:
        return
    for robot, of_robot in outcomes.items():
        if of_robot and len(outcomes) > 1:
            groups = compile_score(of_robot)["groups"].items()
            print(f"{robot:14}" + "  ".join(f"{group} {part['right']}/{part['of']}" for group, part in groups))
    scored = compile_score({name: seen for of_robot in outcomes.values() for name, seen in of_robot.items()})
    if args.output:
        (args.output / "score.json").write_text(json.dumps(scored, indent=1))
    print("\n" + "\n".join(summary(scored)))
    if seconds:
        print(f"{np.median(seconds):.1f} s a diagnosis, {max(seconds):.1f} s at most; {broken} broke")


def _places(each: list[dict[str, Any]]) -> str:
    return (
        ", ".join(
            f"{e['effect']}:{e['where']} {abs(e['size']):.2g} ({e['misfit']:.0f}"
            + (f", {len(e['rivals'])} rivals)" if e["rivals"] else ")")
            for e in each
        )
        or "nothing"
    )


if __name__ == "__main__":
    main()
