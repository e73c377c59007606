"""Vary each threshold of the diagnosis by a factor of 0.5 and 2 on a blind trial, and print what changes.

    python benchmarks/thresholds/run.py
    python benchmarks/thresholds/run.py --only CHI2_PER_EFFECT,EVEN --worlds 1,2,3,4
    python benchmarks/thresholds/run.py --numerical

Worlds are made once and kept. Each variation runs in a process of its own, which sets the threshold before anything
reads it. `--numerical` varies all numbers that set accuracy and work together, in a copy of the package.
"""

import argparse
import ast
import importlib.util
import json
import os
import shutil
import subprocess
import sys
import tempfile
from concurrent.futures import ThreadPoolExecutor
from pathlib import Path
from types import ModuleType
from typing import Any

os.environ.setdefault("OMP_NUM_THREADS", "1")

WORLDS = (
    ("scorbot_er7", "dead_zone", 4),
    ("scorbot_er7", "single", 103),
    ("scorbot_er7", "hysteresis", 2),
    ("scorbot_er7", "repeatability", 5),
    ("ur5", "none", 100),
    ("scorbot_er7", "pair", 113),
    ("scorbot_er7", "small_errors", 3),
    ("ur5", "joint_compliance", 6),
    ("scorbot_er7", "hose", 1),
    ("scorbot_er7", "outliers", 2),
    ("scorbot_er7", "base_compliance", 3),
    ("panda", "tracker", 1),
    ("ur5", "misstated_noise", 1),
    ("scorbot_er7", "dented_target", 1),
)
"""Robot, kind and seed."""
FACTORS = (0.5, 2.0)
FROM_ONE = ("GAP_OVER_FLOOR", "ROW_NOISE_CHANGE", "SCATTER_CHANGE", "IMPLAUSIBLE_NOISE")
"""Ratios of which the distance from one is varied. Shares and probabilities of a half and more are varied by their
distance from one, whole numbers are rounded."""
NOT_VARIED = ("SIGMA_OF_95_PERCENT", "INDEPENDENT_SHAPES")
"""What follows from a distribution or from `shapes.py`."""
NUMERICAL = (
    "candidate_sites.DENTS", "fit.CORRELATED", "fit.LEAST_FACTOR", "fit.LEAST_SHARE", "fit.MOST_ROUNDS", "fit.SEEN",
    "fit.SINGULAR", "gaussian_process_basis.KEPT", "gaussian_process_basis.LANDMARKS", "gaussian_process_basis.MOST",
    "held_out_gap.RESAMPLES", "noise_estimate.LEAST_SHOWN", "noise_weighted_fit.FOLD_ENOUGH",
    "noise_weighted_fit.FOLD_SHARE", "outliers.FITS", "outliers.ROUNDS", "pose_coordinates.LEAST_TORQUE_NM",
    "pose_noise.ROUNDS", "pose_scatter.ON_LIMIT", "score_tests.DENSE_GRID", "score_tests.NEGLIGIBLE", "solver.ENOUGH",
    "solver.SHARE", "standard_errors.MOST_LEVERAGE", "stepwise_order.SEEN",
)  # fmt: skip
"""Numbers of the diagnosis that set its accuracy and work, by file."""
SAME_ERROR = 0.1
"""Relative change of a standard error, up to which it counts as the same."""


def thresholds() -> ModuleType:
    """The thresholds, in the place where everything that is imported later looks for them."""
    file = package() / "diagnosis" / "thresholds.py"
    spec = importlib.util.spec_from_file_location("robolaser.diagnosis.thresholds", file)
    assert spec is not None
    assert spec.loader is not None
    module = importlib.util.module_from_spec(spec)
    spec.loader.exec_module(module)
    sys.modules[spec.name] = module
    return module


def varied(name: str, value: Any, factor: float) -> Any:
    """A threshold's value, varied."""
    if isinstance(value, dict):
        return {key: varied(name, one, factor) for key, one in value.items()}
    if isinstance(value, int):
        return max(1, round(value * factor))
    if name in FROM_ONE:
        return 1.0 + (value - 1.0) * factor
    if 0.5 <= value < 1.0:
        return 1.0 - (1.0 - value) / factor if factor > 1.0 else max(value * factor, 1.0 - (1.0 - value) / factor)
    return value * factor


def diagnose_all(cache: Path, numbers: list[int]) -> dict[str, Any]:
    """What is said of each world."""
    # ruff: noqa: PLC0415  # only now: the thresholds are set
    import robolaser
    from robolaser.diagnosis import examine, pipeline
    from robolaser.diagnosis.result_json import diagnosis_json
    from robolaser.robot.by_name import find_robot
    from robolaser.trials.making import make
    from robolaser.trials.outcome import outcome

    said = {}
    pipeline._next_poses = lambda *args: ()  # type: ignore[assignment]
    for robot, kind, seed in (WORLDS[number - 1] for number in numbers):
        name = f"{robot}-{kind}-{seed}"
        folder = cache / name
        if not (folder / "truth.json").exists():
            made = make(find_robot(robot), kind, seed=seed, name=name)
            robolaser.save(made.dataset, folder, overwrite=True)
            (folder / "truth.json").write_text(json.dumps(made.truth))
        found = diagnosis_json(examine(robolaser.load(folder), seed=1))
        truth = outcome(json.loads((folder / "truth.json").read_text()), found)
        said[name] = {
            "verdict": found["verdict"],
            "names": sorted(f"{e['effect']}:{e['where']}" for e in found["effects"]),
            "sure": sorted(f"{e['effect']}:{e['where']}" for e in found["effects"] if e["probability"] >= 0.9),
            "classes": sorted(c["class"] for c in found["classes"] if c["probability"] >= 0.5),
            "site": found["where"][0]["site"] if found["where"] else "",
            "errors": [p["std"] or 0.0 for e in found["effects"] for p in e.get("parameters", {}).values()],
            "right": truth.right,
            "sure_and_wrong": truth.sure_and_wrong,
        }
    return said


def differs(usual: dict[str, Any], other: dict[str, Any], what: str) -> bool:
    """Whether two diagnoses of a world differ in something."""
    if what != "errors" or len(usual[what]) != len(other[what]):
        return bool(usual[what] != other[what])
    return any(abs(a - b) > SAME_ERROR * max(a, b) for a, b in zip(usual[what], other[what], strict=True))


def package() -> Path:
    """The folder of robolaser."""
    spec = importlib.util.find_spec("robolaser")
    assert spec is not None
    assert spec.origin is not None
    return Path(spec.origin).parent


def with_other_numbers(folder: Path, factor: float) -> Path:
    """A copy of the package with all numbers of `NUMERICAL` varied: the folder to import it from."""
    shutil.copytree(package(), folder / "robolaser", ignore=shutil.ignore_patterns("__pycache__"))
    for stem in {name.partition(".")[0] for name in NUMERICAL}:
        files = (folder / "robolaser" / part / f"{stem}.py" for part in ("diagnosis", "estimation"))
        file = next(file for file in files if file.exists())
        lines = file.read_text().splitlines(keepends=True)
        for node in ast.parse("".join(lines)).body:
            if not isinstance(node, ast.Assign | ast.AnnAssign) or node.value is None:
                continue
            target = node.targets[0] if isinstance(node, ast.Assign) else node.target
            pairs = zip(getattr(target, "elts", [target]), getattr(node.value, "elts", [node.value]), strict=False)
            for name, value in reversed([*pairs]):
                if f"{stem}.{getattr(name, 'id', '')}" in NUMERICAL:
                    assert isinstance(value, ast.Constant)
                    line, number = lines[value.lineno - 1], varied(name.id, value.value, factor)
                    lines[value.lineno - 1] = f"{line[: value.col_offset]}{number!r}{line[value.end_col_offset :]}"
        file.write_text("".join(lines))
    return folder


def in_process(cache: Path, worlds: str, name: str, factor: float) -> dict[str, Any]:
    """The diagnoses with one threshold varied, or all numerical ones, by a process of its own."""
    with tempfile.TemporaryDirectory() as folder:
        environment = dict(os.environ)
        if name == "NUMERICAL":
            environment["PYTHONPATH"] = str(with_other_numbers(Path(folder), factor))
        command = [sys.executable, __file__, "--cache", str(cache), "--worlds", worlds, "--vary", name, str(factor)]
        done = subprocess.run(command, capture_output=True, text=True, check=False, env=environment)
    if done.returncode:
        raise SystemExit(f"{name} x {factor}:\n{done.stderr}")
    found: dict[str, Any] = json.loads(done.stdout)
    return found


def main() -> None:
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("--numerical", action="store_true", help="all numbers that set accuracy and work, together")
    parser.add_argument("--only", help="names of thresholds, separated by commas; default: all")
    every = ",".join(str(i + 1) for i in range(len(WORLDS)))
    parser.add_argument("--worlds", default=every, help="which of them, by their numbers in the list")
    parser.add_argument("--jobs", type=int, default=2)
    parser.add_argument("--cache", type=Path, default=Path(tempfile.gettempdir()) / "robolaser-thresholds")
    parser.add_argument("--vary", nargs=2, help=argparse.SUPPRESS)
    args = parser.parse_args()
    module = thresholds()
    names = [name for name in vars(module) if name.isupper() and name not in NOT_VARIED]
    if args.vary:
        name, factor = args.vary[0], float(args.vary[1])
        if name and name != "NUMERICAL":
            setattr(module, name, varied(name, getattr(module, name), factor))
        print(json.dumps(diagnose_all(args.cache, [*map(int, args.worlds.split(","))])))
        return
    args.cache.mkdir(parents=True, exist_ok=True)
    usual = in_process(args.cache, args.worlds, "", 1.0)
    if args.only or args.numerical:
        names = ["NUMERICAL"] if args.numerical else args.only.split(",")
    columns = ("verdict", "names", "sure", "classes", "site", "errors")
    print(
        f"{'':28} {'factor':>6} worlds that change by " + " ".join(f"{what:>8}" for what in columns) + "  right  wrong"
    )
    _print("as it is", 1.0, usual, usual, columns)
    with ThreadPoolExecutor(args.jobs) as pool:
        tasks = [
            (name, factor, pool.submit(in_process, args.cache, args.worlds, name, factor))
            for name in names
            for factor in FACTORS
        ]
        for name, factor, task in tasks:
            _print(name, factor, usual, task.result(), columns)


def _print(name: str, factor: float, usual: dict[str, Any], other: dict[str, Any], columns: tuple[str, ...]) -> None:
    changed = [sum(differs(usual[world], other[world], what) for world in usual) for what in columns]
    right = sum(said["right"] for said in other.values())
    wrong = sum(said["sure_and_wrong"] for said in other.values())
    cells = " ".join(f"{count:8d}" for count in changed)
    print(f"{name:28} {factor:6.1f} {cells} {right:3d}/{len(other)} {wrong:3d}/{len(other)}", flush=True)


if __name__ == "__main__":
    main()
