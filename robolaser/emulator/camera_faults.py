"""Faults of a camera's frames."""

from collections import deque
from collections.abc import Sequence
from typing import final

import cv2
import numpy as np
from numpy.typing import NDArray

from robolaser.emulator.faults import CAMERA, Fault

Frame = NDArray[np.uint8]


@final
class FaultyCamera:
    """Applies the active faults to one frame after the other."""

    def __init__(self, faults: Sequence[Fault]) -> None:
        self._faults = [fault for fault in faults if fault.kind in CAMERA]
        self._frozen: Frame | None = None
        self._late: deque[tuple[float, Frame]] = deque()

    def gone(self, now_s: float, heard: int) -> bool:
        """Whether the camera is unplugged."""
        return any(fault.kind == "camera_gone" and fault.is_active(now_s, heard) for fault in self._faults)

    def frame(self, taken: Frame, now_s: float, heard: int, clock_s: float) -> Frame | None:
        """What is sent in place of a frame, (h, w).

        Args:
            taken: As the camera took it, (h, w).
            now_s: On the controller's clock.
            heard: Commands that the controller heard.
            clock_s: On the wall's clock: the camera does not speed up.

        Returns:
            (h, w); None: nothing now.
        """
        there = {fault.kind: fault.amount for fault in self._faults if fault.is_active(now_s, heard)}
        light = there.get("camera_over", 1.0) * there.get("camera_dark", 1.0)
        if light != 1.0:
            taken = np.clip(taken * light, 0, 255).astype(np.uint8)
        if "camera_size" in there:
            h, w = (max(1, round(length * there["camera_size"])) for length in taken.shape)
            taken = np.asarray(cv2.resize(taken, (w, h)), dtype=np.uint8)
        if "camera_frozen" not in there:
            self._frozen = None
        elif self._frozen is None:
            self._frozen = taken
        return self._delayed(taken if self._frozen is None else self._frozen, there.get("camera_late", 0.0), clock_s)

    def _delayed(self, taken: Frame, late_s: float, clock_s: float) -> Frame | None:
        self._late.append((clock_s + late_s, taken))
        ready = None
        while self._late and self._late[0][0] <= clock_s:
            ready = self._late.popleft()[1]
        return ready
