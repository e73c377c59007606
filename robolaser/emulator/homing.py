"""The search for home: one axis after the other passes its home switch and comes back to it."""

from collections.abc import Sequence
from typing import final

import numpy as np

from robolaser.emulator.encoders import Encoders
from robolaser.emulator.joints import Axis, least_seconds

SEARCH_S, RETURN_S = 14.0, 6.0
"""What one axis takes at least."""
PASSED_RAD = 0.05
"""How far an axis overshoots its switch."""
SLOW_RAD_S = 0.3


@final
class Homing:
    """One search, queued into the axes when it begins."""

    def __init__(self, axes: Sequence[Axis], encoders: Encoders, homeless: frozenset[int], now_s: float) -> None:
        self.ends_s = now_s
        self.outcome = "HOMING COMPLETE (ROBOT)"
        self.found = True
        for number, (axis, home) in enumerate(zip(axes, encoders.home, strict=True), 1):
            beyond = float(np.clip(home + PASSED_RAD, encoders.lower[number - 1], encoders.upper[number - 1]))
            search_s = max(SEARCH_S, least_seconds(beyond - axis.goal, SLOW_RAD_S))
            axis.queue(beyond, self.ends_s, search_s)
            self.ends_s += search_s
            if number in homeless or axis.jammed:
                self.outcome, self.found = f"*** HOME FAILURE AXIS {number}", False
                return
            axis.queue(float(home), self.ends_s, RETURN_S)
            self.ends_s += RETURN_S
