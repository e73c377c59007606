"""CPU time of whole commands, each in a separate process.

    python benchmarks/whole/run.py [--rounds 5]

CPU time is user and system time of the process and of the children that it waited for.
"""

import argparse
import os
import statistics
import subprocess
import sys
import tempfile
from pathlib import Path

EXAMPLE = Path(__file__).resolve().parents[2] / "examples" / "etna-s2"
SIMULATED = ["simulate", "--robot", "scorbot_er7", "--poses", "60", "--points", "10", "--repeats", "2", "--seed", "1"]
EFFECT = ["--effect", "joint_offset:joint_2=0.003"]


def commands(folder: Path) -> dict[str, list[str]]:
    """The measured commands; later ones may read the output of earlier ones."""
    demo, nothing, one = (str(folder / name) for name in ("demo", "nothing", "one"))
    out = ["--force", "--output"]
    return {
        "--help": ["--help"],
        "list effects": ["list", "effects"],
        "simulate, 60 poses": [*SIMULATED, *out, nothing],
        "simulate, one effect": [*SIMULATED, *EFFECT, *out, one],
        "extract the demo": ["extract", str(EXAMPLE), *out, demo],
        "calibrate the demo": ["calibrate", demo, "--with", "laser_roll", *out, str(folder / "calibration")],
        "diagnose, nothing wrong": ["diagnose", nothing, *out, str(folder / "why-nothing")],
        "diagnose, one effect": ["diagnose", one, *out, str(folder / "why-one")],
    }


def cpu_s(command: list[str], environment: dict[str, str]) -> float:
    """User and system time of a process [s]."""
    with subprocess.Popen(command, env=environment, stdout=subprocess.DEVNULL, stderr=subprocess.PIPE) as process:
        assert process.stderr is not None
        errors = process.stderr.read()
        _, status, used = os.wait4(process.pid, 0)
        process.returncode = os.waitstatus_to_exitcode(status)
    if process.returncode:
        raise SystemExit(f"{' '.join(command)} exits with {process.returncode}:\n{errors.decode()}")
    return used.ru_utime + used.ru_stime


def main() -> None:
    """Measure, and print a table."""
    parser = argparse.ArgumentParser(description="CPU time of whole commands.")
    parser.add_argument("--rounds", type=int, default=5, help="runs of each command; default: 5")
    args = parser.parse_args()
    environment = os.environ | {"OMP_NUM_THREADS": "1"}
    idle = statistics.median(cpu_s([sys.executable, "-c", "pass"], environment) for _ in range(args.rounds))
    print(f"Python alone: {idle:.3f} s\n")
    print("| command | CPU [s] | spread [s] |\n|---|---|---|")
    with tempfile.TemporaryDirectory() as scratch:
        for title, words in commands(Path(scratch)).items():
            command = [sys.executable, "-m", "robolaser", *words]
            cpu_s(command, environment)
            warm = [cpu_s(command, environment) for _ in range(args.rounds)]
            print(f"| {title} | {statistics.median(warm):.2f} | {min(warm):.2f} .. {max(warm):.2f} |", flush=True)


if __name__ == "__main__":
    main()
