"""A fresh trial, kind by kind: small blind worlds of several arms, one process, a line in a file for each as it ends.

    python benchmarks/blind/kinds.py --seed 41000 --rounds 10 --output trial.jsonl
    python benchmarks/blind/kinds.py --seed 42000 --rounds 4 --kinds latency,backlash --output trial.jsonl
    python benchmarks/blind/kinds.py --report trial.jsonl

A round has one world of each kind; arm and sensor change from round to round. What is in the file is not done again.
"""

import argparse
import json
import os
import time
from collections import defaultdict
from collections.abc import Mapping, Sequence
from pathlib import Path
from typing import Any

os.environ.setdefault("OMP_NUM_THREADS", "1")

from robolaser.diagnosis import examine
from robolaser.diagnosis.result_json import diagnosis_json
from robolaser.errors import RobolaserError
from robolaser.robot.by_name import find_robot
from robolaser.trials.building import Ranges
from robolaser.trials.kinds import IN_IMAGES
from robolaser.trials.making import make
from robolaser.trials.outcome import Outcome, outcome
from robolaser.trials.score import compile_score, share
from robolaser.trials.synthetic.fault_models import FAULT_MODELS, MODELLED, PHYSICAL, UNMODELLED

CELLS = (("scorbot_er7", False), ("panda", True), ("ur5", False), ("scorbot_er7", True), ("ur5", True))
"""Arm, and whether a tracker sees it."""
RANGES = Ranges(poses=(30, 45), points=(5, 7))
UNKNOWN = (*UNMODELLED, "play_under_weight")
CONDITIONS = (
    "repeatability", "none", "small_errors", "single", "pair", "several", "repeatability", "misstated_noise",
    "shared_noise", "growing_noise", "outliers",
)  # fmt: skip
"""What else may be in a cell, and several effects."""
KINDS = (*CONDITIONS, *UNKNOWN, *MODELLED, *(form for form in PHYSICAL if form not in UNKNOWN))
"""Of one round: each effect alone, too, and in MuJoCo where it moves some."""
KEPT = ("verdict", "effects", "classes", "where", "gap_mm")


def trial(first: int, rounds: int, kinds: Sequence[str], file: Path) -> None:
    """Make and diagnose the worlds that the file does not have yet."""
    done = {line["seed"] for line in lines(file)} if file.exists() else set()
    for i in range(rounds):
        for j, kind in enumerate(kinds):
            seed, (robot, tracked) = first + i * len(kinds) + j, CELLS[(i + j) % len(CELLS)]
            tracked = kind == "tracker_scale" or (tracked and is_tracked(kind))
            if seed in done:
                continue
            line: dict[str, Any] = {"seed": seed, "robot": robot, "tracked": tracked, "kind": kind}
            began = time.process_time()
            try:
                world = make(find_robot(robot), kind, seed=seed, ranges=RANGES, tracked=tracked)
                made = time.process_time()
                found = diagnosis_json(examine(world.dataset, seed=1))
                line |= {"truth": dict(world.truth), "found": {name: found[name] for name in KEPT}}
                line |= {"making_s": made - began, "cpu_s": time.process_time() - made}
            except RobolaserError as e:
                line["error"] = str(e)
            with file.open("a") as out:
                out.write(json.dumps(line) + "\n")


def is_tracked(kind: str) -> bool:
    """Whether there are such worlds with a tracker."""
    fault = FAULT_MODELS.get(kind)
    return kind not in IN_IMAGES and (fault is None or (fault.is_tracked() and fault.location != "hand_eye"))


def lines(file: Path) -> list[dict[str, Any]]:
    """What a file has."""
    return [json.loads(line) for line in file.read_text().splitlines()]


def group_of(line: Mapping[str, Any], seen: Outcome) -> str:
    """The row of the table that a world counts in."""
    if line["kind"] == "repeatability":
        return "repeatability, with one effect" if seen.truth else "repeatability alone"
    return f"unknown: {line['kind']}" if line["kind"] in UNKNOWN else str(line["kind"])


def report(file: Path) -> None:
    """Print a row for each kind, and the reliability tables."""
    rows: dict[str, list[Outcome]] = defaultdict(list)
    for line in lines(file):
        if "truth" not in line:
            continue
        seen = outcome(line["truth"], line["found"])
        if seen.group != "faint":
            rows[group_of(line, seen)].append(seen)
    every = [seen for group in rows.values() for seen in group]
    rows["unknown, all"] = [seen for name, group in rows.items() if name.startswith("unknown:") for seen in group]
    columns = "worlds | name | class | verdict | place first | sure and wrong | 95 % intervals"
    print(f"| kind | {columns} |\n|---|---|---|---|---|---|---|---|")
    for name, group in sorted(rows.items()):
        cells = (
            str(len(group)),
            _cell([seen.right for seen in group]),
            _cell([seen.class_right for seen in group if seen.class_right is not None]),
            _cell([seen.verdict_right for seen in group if seen.verdict_right is not None]),
            _cell([seen.site for seen in group if seen.site is not None]),
            _cell([seen.sure_and_wrong for seen in group]),
            _cell([held for seen in group for _, held in seen.covered]),
        )
        print(f"| {name} | {' | '.join(cells)} |")
    score = compile_score({str(i): seen for i, seen in enumerate(every)})
    print("\n| stated | names, right | classes, right |\n|---|---|---|")
    for name, cause in zip(score["reliability"], score["reliability_of_classes"], strict=True):
        print(f"| {name['from']}-{name['to']} | {name['right']}/{name['of']} | {cause['right']}/{cause['of']} |")
    print("\n| effect | 95 % intervals |\n|---|---|")
    for effect, held in score["coverage_95_by_effect"].items():
        print(f"| `{effect}` | {held['right']}/{held['of']} |")
    seconds = [line["cpu_s"] for line in lines(file) if "cpu_s" in line]
    print(f"\n{len(seconds)} worlds, {sum(seconds) / len(seconds):.1f} s of CPU a diagnosis")


def _cell(hits: Sequence[bool]) -> str:
    counted = share(hits)
    return f"{counted['right']}/{counted['of']}" if counted["of"] else ""


def main() -> None:
    """See above."""
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("--seed", type=int, default=41000, help="of the first world")
    parser.add_argument("--rounds", type=int, default=10)
    parser.add_argument("--kinds", help="of worlds, separated by commas; default: those of the trial")
    parser.add_argument("--output", type=Path, default=Path("trial.jsonl"))
    parser.add_argument("--report", type=Path, help="a file to print the table of")
    args = parser.parse_args()
    if not args.report:
        trial(args.seed, args.rounds, args.kinds.split(",") if args.kinds else KINDS, args.output)
    report(args.report or args.output)


if __name__ == "__main__":
    main()
