"""Record the answers of `calibrate` and `diagnose` on many data sets, and compare those of a later version.

    python benchmarks/frozen/run.py worlds --output WORLDS
    python benchmarks/frozen/run.py record --data FOLDER --worlds WORLDS --output after.jsonl
    python benchmarks/frozen/run.py compare benchmarks/frozen/before.jsonl after.jsonl
    python benchmarks/frozen/run.py record --set certainty.EVEN=0.3 --data FOLDER --worlds WORLDS --output other.jsonl

A line is appended when each data set is done; data sets in the file are skipped.
"""

import argparse
import ast
import json
import os
import sys
import time
from collections.abc import Callable, Mapping
from pathlib import Path
from typing import Any

os.environ.setdefault("OMP_NUM_THREADS", "1")

import numpy as np
from answers import calibrated, diagnosed
from gate import compare, lines
from worlds import GROUPS, World, made, make_fresh, worlds

import robolaser
from robolaser.calibration.calibrate import calibrate
from robolaser.data.dataset import Dataset
from robolaser.diagnosis import examine
from robolaser.diagnosis.result_json import diagnosis_json

FRESH = 271100  # seed of the first fresh world


def main() -> None:
    """Record, or compare."""
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    commands = parser.add_subparsers(required=True)
    making = commands.add_parser("worlds")
    making.add_argument("--seed", type=int, default=FRESH, help="seed of the first fresh world")
    making.add_argument("--output", type=Path, required=True)
    making.set_defaults(run=lambda a: make_fresh(a.output, a.seed))
    recording = commands.add_parser("record")
    data = os.environ.get("ROBOLASER_DATA")
    recording.add_argument("--data", type=Path, default=data, required=data is None, help="folder of real sets")
    recording.add_argument("--groups", default=",".join(GROUPS), help="separated by commas")
    recording.add_argument("--worlds", type=Path, help="folder of fresh worlds; without it, this group is omitted")
    recording.add_argument("--set", action="append", default=[], metavar="FILE.NAME=VALUE", help="change a constant")
    recording.add_argument("--output", type=Path, required=True)
    recording.set_defaults(run=record)
    comparing = commands.add_parser("compare")
    comparing.add_argument("before", type=Path)
    comparing.add_argument("after", type=Path)
    comparing.set_defaults(run=lambda a: sys.exit(compare(a.before, a.after)))
    arguments = parser.parse_args()
    arguments.run(arguments)


def put(setting: str) -> None:
    """Give a number another value, wherever it was imported, in this process."""
    place, _, value = setting.partition("=")
    file, _, name = place.partition(".")
    modules = [module for key, module in sys.modules.items() if key.startswith("robolaser.")]
    (usual,) = [vars(module)[name] for module in modules if module.__name__.endswith(f".{file}")]
    for module in modules:
        if vars(module).get(name) is usual:
            setattr(module, name, ast.literal_eval(value))


def record(arguments: argparse.Namespace) -> None:
    """Answers of both commands on data sets that are not in the file."""
    data, fresh, output = arguments.data, arguments.worlds, arguments.output
    for setting in arguments.set:
        put(setting)
    done = {line["name"] for line in lines(output)} if output.exists() else set()
    warm = next(worlds("scatter", data, fresh)).load()[0]  # imports and caches, which count for no data set
    _timed(lambda: calibrated(calibrate(warm)))
    _timed(lambda: diagnosed(diagnosis_json(examine(warm, seed=1))))
    for group in arguments.groups.split(","):
        for world in worlds(group, data, fresh):
            if world.name not in done and (found := made(world)):
                line = answers(world, *found)
                with output.open("a", encoding="utf-8") as out:
                    out.write(json.dumps(line, separators=(",", ":"), allow_nan=False) + "\n")


def answers(world: World, dataset: Dataset, truth: Mapping[str, Any] | None) -> dict[str, Any]:
    """A line of the file; with removed effects, only the diagnosis."""
    line: dict[str, Any] = {"name": world.name, "group": world.group, "data": _mark(dataset)}
    if truth is not None:
        line["truth"] = truth
    if world.without:
        line["without"] = world.without
    else:
        line["calibrate"] = _timed(lambda: calibrated(calibrate(dataset, robolaser.Plan(seed=1))))
    line["diagnose"] = _timed(lambda: diagnosed(diagnosis_json(examine(dataset, seed=1, without=world.without))))
    return line


def _mark(dataset: Dataset) -> list[float]:
    """Number of rows and a norm of the measurements, to check that two versions had the same data."""
    given = [dataset.points.xyz, dataset.points.pixel, dataset.poses.q]
    return [
        len(dataset.points),
        float(f"{np.sqrt(sum(np.nansum(np.square(some)) for some in given if some is not None)):.7g}"),
    ]


def _timed(work: Callable[[], dict[str, Any]]) -> dict[str, Any]:
    """An answer, or the error that ended the command, and CPU seconds."""
    began = time.process_time()
    try:
        answer = work()
    except Exception as e:  # a data set that ends a command is an answer too
        answer = {"fails": f"{type(e).__name__}: {e}"[:160]}
    return {**answer, "cpu_s": round(time.process_time() - began, 2)}


if __name__ == "__main__":
    main()
