"""Simulate small blind worlds of several arms and kinds, diagnose them, and count the right diagnoses.

    python benchmarks/blind/run.py --seed 43000 --rounds 10 --output trial.jsonl
    python benchmarks/blind/run.py --seed 42000 --rounds 4 --kinds latency,backlash --output trial.jsonl
    python benchmarks/blind/run.py --seed 44000 --rounds 4 --kinds single --withhold --output removed.jsonl
    python benchmarks/blind/run.py --report trial.jsonl

A round has one world of each kind; arm and sensor change from round to round. A line for each world is appended at the
end of its diagnosis; worlds in the file are skipped.
"""

import argparse
import json
import os
import time
from collections.abc import Iterator, Sequence
from concurrent.futures import ProcessPoolExecutor, as_completed
from dataclasses import dataclass
from pathlib import Path
from typing import Any

os.environ.setdefault("OMP_NUM_THREADS", "1")

from robolaser.commands.challenge import summary
from robolaser.diagnosis import examine
from robolaser.diagnosis.result_json import diagnosis_json
from robolaser.errors import RobolaserError
from robolaser.robot.by_name import find_robot
from robolaser.trials.building import Ranges
from robolaser.trials.kinds import IN_IMAGES
from robolaser.trials.making import make
from robolaser.trials.score import compile_score, outcome
from robolaser.trials.synthetic.fault_models import FAULT_MODELS, MODELLED, PHYSICAL, UNMODELLED

CELLS = (("scorbot_er7", False), ("panda", True), ("ur5", False), ("scorbot_er7", True), ("ur5", True))
"""Arm, and whether a tracker measures it."""
RANGES = Ranges(poses=(30, 45), points=(5, 7))
UNKNOWN = (*UNMODELLED, "play_under_weight")
CONDITIONS = (
    "repeatability", "none", "small_errors", "single", "pair", "several", "repeatability", "misstated_noise",
    "shared_noise", "growing_noise", "outliers",
)  # fmt: skip
"""Kinds other than single effects: noise, gross errors, and several effects."""
KINDS = (*CONDITIONS, *UNKNOWN, *MODELLED, *(form for form in PHYSICAL if form not in UNKNOWN))
"""Kinds of one round, with each effect alone, in MuJoCo too where it has a model."""
KEPT = ("verdict", "effects", "classes", "where", "gap_mm")


@dataclass(frozen=True)
class Task:
    """One world to simulate and diagnose."""

    seed: int
    kind: str
    robot: str
    tracked: bool
    withhold: bool


def tasks(first: int, rounds: int, kinds: Sequence[str], *, withhold: bool) -> Iterator[Task]:
    """The worlds of some rounds."""
    for i in range(rounds):
        for j, kind in enumerate(kinds):
            robot, tracked = CELLS[(i + j) % len(CELLS)]
            tracked = kind == "tracker_scale" or (tracked and is_tracked(kind))
            yield Task(first + i * len(kinds) + j, kind, robot, tracked, withhold)


def is_tracked(kind: str) -> bool:
    """Whether worlds of this kind can have a tracker."""
    fault = FAULT_MODELS.get(kind)
    return kind not in IN_IMAGES and (fault is None or (fault.is_tracked() and fault.location != "hand_eye"))


def line(task: Task) -> dict[str, Any]:
    """Simulate a world and diagnose it; the line of the output file."""
    done: dict[str, Any] = {"seed": task.seed, "robot": task.robot, "tracked": task.tracked, "kind": task.kind}
    began = time.process_time()
    try:
        world = make(find_robot(task.robot), task.kind, seed=task.seed, ranges=RANGES, tracked=task.tracked)
        made = time.process_time()
        truth = dict(world.truth)
        gone = {item["effect"] for item in truth["each"] if task.withhold and item["effect"] in MODELLED}
        truth["each"] = [{**item, "withheld": item["effect"] in gone} for item in truth["each"]]
        found = diagnosis_json(examine(world.dataset, seed=1, without=tuple(sorted(gone))))
        done |= {"truth": truth, "found": {name: found[name] for name in KEPT}}
        done |= {"making_s": made - began, "cpu_s": time.process_time() - made}
    except RobolaserError as e:
        done["error"] = str(e)
    return done


def lines(file: Path) -> list[dict[str, Any]]:
    """The lines of a file, if it exists."""
    return [json.loads(text) for text in file.read_text().splitlines()] if file.exists() else []


def report(file: Path) -> None:
    """Print the score of all worlds with detectable faults."""
    kept = [one for one in lines(file) if "truth" in one]
    seen = {str(one["seed"]): outcome(one["truth"], one["found"]) for one in kept}
    score = compile_score({name: one for name, one in seen.items() if one.group != "faint"})
    print(*summary(score), "", sep="\n")
    seconds = [one["cpu_s"] for one in kept]
    print(f"\n{len(seconds)} worlds, {sum(seconds) / max(1, len(seconds)):.1f} s of CPU a diagnosis")


def main() -> None:
    """See above."""
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("--seed", type=int, default=41000, help="seed of the first world")
    parser.add_argument("--rounds", type=int, default=10)
    parser.add_argument("--kinds", help="kinds of worlds, separated by commas; default: all")
    parser.add_argument("--withhold", action="store_true", help="remove the true effects from the library first")
    parser.add_argument("--jobs", type=int, default=1)
    parser.add_argument("--output", type=Path, default=Path("trial.jsonl"))
    parser.add_argument("--report", type=Path, help="only print the score of this file")
    args = parser.parse_args()
    if not args.report:
        kinds = args.kinds.split(",") if args.kinds else KINDS
        known = {(kept["seed"], kept["kind"]) for kept in lines(args.output)}
        every = tasks(args.seed, args.rounds, kinds, withhold=args.withhold)
        new = [task for task in every if (task.seed, task.kind) not in known]
        with ProcessPoolExecutor(args.jobs) as pool:
            for done in as_completed([pool.submit(line, task) for task in new]):
                with args.output.open("a") as out:
                    out.write(json.dumps(done.result()) + "\n")
    report(args.report or args.output)


if __name__ == "__main__":
    main()
