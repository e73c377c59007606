"""Runs one command with timers around its parts: python benchmarks/whole/phases.py RESULT.json COMMAND ..."""

import builtins
import importlib
import json
import sys
import time
from collections.abc import Callable
from pathlib import Path
from typing import Any

READING = {"reading": "robolaser.data.loading:load"}
STEPS = {
    "calibrate": READING
    | {
        "calibration": "robolaser.calibration.calibrate:calibrate",
        "page": "robolaser.report.calibration:page",
        "terminal": "robolaser.report.calibration:print_summary",
    },
    "diagnose": READING
    | {
        "diagnosis": "robolaser.diagnosis:examine",
        "page": "robolaser.report.diagnosis:page",
        "terminal": "robolaser.report.diagnosis:print_diagnosis",
    },
    "extract": READING | {"images": "robolaser.vision.recordings:points_from_images"},
    "simulate": {"simulation": "robolaser.simulation:simulate"},
}
"""The functions of a command that are timed; one that is renamed is left out of the table, in `rest`."""


class Stopwatch:
    """CPU time by part; within a part, what another part takes counts for that one alone."""

    def __init__(self) -> None:
        self._since = time.process_time()
        self.took: dict[str, float] = {"Python": self._since}
        self._running: list[str] = ["rest"]

    def switch(self) -> None:
        """Book the time since the last switch."""
        now = time.process_time()
        name = self._running[-1]
        self.took[name] = self.took.get(name, 0.0) + now - self._since
        self._since = now

    def around(self, name: str, function: Callable[..., Any]) -> Callable[..., Any]:
        """The function, timed."""

        def timed(*args: Any, **kwargs: Any) -> Any:
            self.switch()
            self._running.append(name)
            try:
                return function(*args, **kwargs)
            finally:
                self.switch()
                self._running.pop()

        return timed


def main() -> int:
    """Run the command and write what its parts took."""
    result, *words = sys.argv[1:]
    watch = Stopwatch()
    builtins.__import__ = watch.around("imports", builtins.__import__)
    for step, place in STEPS.get(words[0], {}).items():
        module_name, name = place.split(":")
        module = watch.around("imports", importlib.import_module)(module_name)
        if hasattr(module, name):
            setattr(module, name, watch.around(step, getattr(module, name)))
    from robolaser.cli import main as robolaser  # noqa: PLC0415 - timed

    code = robolaser(words)
    watch.switch()
    Path(result).write_text(json.dumps(watch.took), encoding="utf-8")
    return code


if __name__ == "__main__":
    sys.exit(main())
