"""The diagnosis of a running recording: of all poses so far, in a separate process."""

import signal
from collections import defaultdict
from collections.abc import Callable, Mapping
from concurrent.futures import Future, ProcessPoolExecutor
from concurrent.futures.process import BrokenProcessPool
from contextlib import suppress
from functools import partial
from multiprocessing import get_context
from pathlib import Path
from typing import Any, final

import numpy as np

from robolaser.errors import RobolaserError


@final
class RunningDiagnosis:
    """Starts a diagnosis after each pose, once the last one has ended; no pose waits for it.

    Args:
        folder: Of the recording.
        show: Called with each result, once.
    """

    def __init__(self, folder: Path, show: Callable[[str], None]) -> None:
        self._show, self._folder = show, folder
        ctrl_c_is_the_arms = partial(signal.signal, signal.SIGINT, signal.SIG_IGN)
        self._engine = ProcessPoolExecutor(1, get_context("spawn"), initializer=ctrl_c_is_the_arms)
        self._asked: Future[str] | None = None
        self._is_current = True
        self.latest = ""

    def pose_recorded(self) -> None:
        """Show a new result, and start the diagnosis of the poses that are on the disk now."""
        self._is_current = self._asked is None or self._asked.done()
        if self._is_current:
            self._take()
            self._ask()

    def finish(self) -> None:
        """Show the result of all poses."""
        self._take()
        if not self._is_current:
            self._ask()
            self._take()

    def close(self) -> None:
        """Start no more diagnoses."""
        self._engine.shutdown(wait=False, cancel_futures=True)

    def _ask(self) -> None:
        with suppress(BrokenProcessPool):  # the recording continues without it; the last result has the reason
            self._asked = self._engine.submit(answer, self._folder)

    def _take(self) -> None:
        if self._asked is None:
            return
        try:
            text = self._asked.result()
        except Exception as error:  # no error of a diagnosis stops the arm
            text = f"no diagnosis: {type(error).__name__}: {error}"
        if text != self.latest:
            self._show(text)
        self.latest = text


_SHOWN: defaultdict[Path, dict[object, Any]] = defaultdict(dict)  # by recording: detections in its images
_FOUND: dict[Path, Any] = {}  # by recording: the last diagnosis


def answer(folder: Path) -> str:
    """Leading effects of a recording so far, with probabilities and the next pose; or why there is no diagnosis yet.

    Repeated calls for one recording in one process read each image once.
    """
    from robolaser.api import diagnose
    from robolaser.data.loading import load
    from robolaser.vision.recordings import points_of_images

    try:
        _, dataset = points_of_images(load(folder), known=_SHOWN[folder])
        found = _FOUND[folder].with_poses(dataset) if folder in _FOUND else diagnose(dataset, seed=1)
    except RobolaserError as error:
        return f"no diagnosis yet: {error}"
    except np.linalg.LinAlgError:
        return "no diagnosis yet: these poses do not determine the model."
    _FOUND[folder] = found
    return in_a_line(found)


def in_a_line(found: Mapping[str, Any]) -> str:
    """A diagnosis, with the keys of `diagnosis.json`, in a line."""
    gap, poses = found["gap_mm"], found["poses"]["used"]
    leaders = ", ".join(f"{one['effect']} at {one['where']} {one['probability']:.0%}" for one in found["effects"][:2])
    parts = [
        f"{poses} poses: {found['verdict'].replace('_', ' ')}",
        leaders,
        f"error on new poses {gap['after']:.3g} mm, noise alone {gap['noise_floor']:.3g} mm",
    ]
    if found["effects"] and found["next_poses"]:
        decides = ", ".join(f"{joint} {value:.2f}" for joint, value in found["next_poses"][0].items())
        parts.append(f"would decide: {decides} (rad or m)")
    return "; ".join(filter(None, parts))
