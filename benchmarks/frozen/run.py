"""What `calibrate` and `diagnose` answer on many data sets, kept, and a later state held against it.

    python benchmarks/frozen/run.py record FOLDER... --output answers.json
    python benchmarks/frozen/run.py compare answers.json later.json

`record` runs both commands, as a person would, on every data set below the given folders. `compare` lists what differs:
verdicts, names and places exactly, J to 1e-9, gaps to 1 %, CPU time as a ratio.
"""

from __future__ import annotations

import argparse
import json
import resource
import statistics
import subprocess
import sys
import tempfile
from pathlib import Path

ROUNDING = 1e-14  # metres or square metres: what is left of data without noise
SURE = 0.9  # effects named with at least this probability are compared by name


def main() -> None:
    """Record, or compare."""
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    commands = parser.add_subparsers(required=True)
    record = commands.add_parser("record")
    record.add_argument("folders", nargs="+", type=Path)
    record.add_argument("--output", type=Path, required=True)
    record.add_argument("--robolaser", default=str(Path(sys.executable).with_name("robolaser")), help="how to start it")
    record.set_defaults(run=lambda a: _record(a.folders, a.output, a.robolaser.split()))
    compare = commands.add_parser("compare")
    compare.add_argument("before", type=Path)
    compare.add_argument("after", type=Path)
    compare.set_defaults(run=lambda a: _compare(json.loads(a.before.read_text()), json.loads(a.after.read_text())))
    arguments = parser.parse_args()
    arguments.run(arguments)


def _record(folders: list[Path], output: Path, start: list[str]) -> None:
    """Answers of both commands, written after every data set, so that a broken run goes on."""
    answers = json.loads(output.read_text()) if output.exists() else {}
    for dataset in sorted(toml.parent for folder in folders for toml in folder.rglob("dataset.toml")):
        if dataset.name not in answers and (dataset / "points.csv").exists():
            answers[dataset.name] = {
                "calibrate": _answer([*start, "calibrate", str(dataset), "--seed", "1"], "calibration.json"),
                "diagnose": _answer([*start, "diagnose", str(dataset), "--seed", "1"], "diagnosis.json"),
            }
            output.write_text(json.dumps(answers, indent=1) + "\n")
            print(dataset.name, *(answers[dataset.name][c].get("cpu_s") for c in ("calibrate", "diagnose")), flush=True)


def _answer(command: list[str], name: str) -> dict[str, object]:
    """The part of a command's JSON that people act on, and the CPU seconds it took."""
    with tempfile.TemporaryDirectory() as folder:
        before = resource.getrusage(resource.RUSAGE_CHILDREN)
        run = subprocess.run([*command, "--output", folder, "--force"], capture_output=True, text=True, check=False)
        after = resource.getrusage(resource.RUSAGE_CHILDREN)
        cpu_s = after.ru_utime + after.ru_stime - before.ru_utime - before.ru_stime
        if run.returncode:
            return {"exit": run.returncode, "says": run.stderr.strip().splitlines()[-1:], "cpu_s": round(cpu_s, 2)}
        return {**_kept(json.loads((Path(folder) / name).read_text())), "cpu_s": round(cpu_s, 2)}


def _kept(result: dict[str, object]) -> dict[str, object]:
    """Without what changes from run to run, and without the long lists."""
    kept = ("parameters", "objective_m2", "rms_m", "held_out_rms_m", "verdict", "gap_mm", "effects", "unidentifiable")
    out = {key: result[key] for key in kept if key in result}
    if "where" in result:
        out["where"] = [{k: row[k] for k in ("site", "share")} for row in result["where"]]  # type: ignore[attr-defined]
    if isinstance(out.get("parameters"), dict):
        out["parameters"] = {name: row["value"] for name, row in out["parameters"].items()}  # type: ignore[attr-defined]
    return out


def _sure(diagnosis: dict[str, object]) -> list[str]:
    effects: list[dict[str, object]] = diagnosis.get("effects", [])  # type: ignore[assignment]
    return sorted(f"{e['effect']} at {e['where']}" for e in effects if e["probability"] >= SURE)  # type: ignore[operator]


def _compare(before: dict[str, dict], after: dict[str, dict]) -> None:
    """A line for every difference, then the counts and the CPU times' ratios."""
    alike = 0
    ratios: dict[str, list[float]] = {"calibrate": [], "diagnose": []}
    for name in [n for n in before if n in after]:
        lines = []
        for command in ("calibrate", "diagnose"):
            was, now = before[name][command], after[name][command]
            ratios[command].append(now["cpu_s"] / was["cpu_s"])
            if was.get("exit") != now.get("exit"):
                lines.append(
                    f"{command} exits with {now.get('exit', 0)}, was {was.get('exit', 0)}:"
                    f" {now.get('says') or was.get('says')}"
                )
                continue
            if was.get("exit"):
                continue
            lines += _figures(command, was, now)
        alike += not lines
        for line in lines:
            print(f"{name}: {line}")
    print(f"{alike} of {sum(n in after for n in before)} data sets alike")
    for command, values in ratios.items():
        if values:
            print(
                f"CPU time of {command}, after / before: median {statistics.median(values):.2f}, most {max(values):.2f}"
            )


def _figures(command: str, was: dict, now: dict) -> list[str]:
    if command == "calibrate":
        lines = []
        for key, tolerance in (("objective_m2", 1e-9), ("held_out_rms_m", 1e-2)):
            a, b = was.get(key), now.get(key)
            if (a is None) != (b is None) or (a is not None and abs(a - b) > tolerance * abs(a) + ROUNDING):
                lines.append(f"{key} {b}, was {a}" + ("" if a is None or b is None else f" ({b / a - 1:+.2e})"))
        return lines
    lines = [f"verdict {now['verdict']}, was {was['verdict']}"] if was["verdict"] != now["verdict"] else []
    if _sure(was) != _sure(now):
        lines.append(f"sure of {_sure(now)}, was {_sure(was)}")
    named = [sorted(f"{e['effect']} at {e['where']}" for e in d["effects"]) for d in (was, now)]
    if named[0] != named[1]:
        lines.append(f"names {named[1]}, was {named[0]}")
    for key in ("nominal", "calibrated", "after", "noise_floor"):
        a, b = was["gap_mm"].get(key), now["gap_mm"].get(key)
        if (a is None) != (b is None) or (a is not None and abs(a - b) > 1e-2 * abs(a) + 1e3 * ROUNDING):
            lines.append(f"gap {key} {b} mm, was {a} mm")
    return lines


if __name__ == "__main__":
    main()
