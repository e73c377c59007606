"""What it costs to start: `import robolaser` and `robolaser --help`, beside Python itself doing nothing."""

import statistics
import subprocess
import sys
import time
from pathlib import Path

ROUNDS = 15
HELP = str(Path(sys.executable).with_name("robolaser"))
WORK = {
    "python doing nothing": [sys.executable, "-c", "pass"],
    "import robolaser": [sys.executable, "-c", "import robolaser"],
    "import numpy": [sys.executable, "-c", "import numpy"],
    "robolaser --help": [HELP, "--help"],
    "robolaser list robots": [HELP, "list", "robots"],
}


def seconds(command: list[str]) -> float:
    """Wall time of one run."""
    began = time.perf_counter()
    subprocess.run(command, check=True, capture_output=True)
    return time.perf_counter() - began


def main() -> None:
    took: dict[str, list[float]] = {name: [] for name in WORK}
    for _ in range(ROUNDS):
        for name, command in WORK.items():
            took[name].append(seconds(command))
    base = statistics.median(took["python doing nothing"])
    print("| work | median [s] | spread [s] | times Python alone |")
    print("|---|---|---|---|")
    for name, times in took.items():
        middle = statistics.median(times)
        print(f"| {name} | {middle:.3f} | {min(times):.3f} .. {max(times):.3f} | {middle / base:.1f} |")


if __name__ == "__main__":
    main()
