"""How well an arm repeats: each pose is reached with an error of its own, which its images share."""

from dataclasses import dataclass
from typing import Any, ClassVar, final

import numpy as np

from robolaser.arrays import Array
from robolaser.trials.synthetic.fault_model import FaultModel
from robolaser.trials.synthetic.run import SyntheticRun


@final
@dataclass(frozen=True)
class PoseScatter(FaultModel):
    """Joints stop beside their goals, some of them more than others, so that the flange is off by `size` [m] (RMS).

    This is noise: no effect explains it.
    """

    effect: ClassVar[str] = "repeatability"
    sizes: ClassVar[tuple[float, float]] = (2e-5, 1e-4)
    location: ClassVar[str | None] = "arm"

    off: Array

    @classmethod
    def sample_form(cls, where: str, run: SyntheticRun, rng: np.random.Generator) -> tuple[Any, ...]:
        """Errors of the joints over their RMS size, in the poses (n, j)."""
        off = np.zeros(run.q.shape)
        columns = list(run.arm.columns)
        off[:, columns] = rng.normal(size=(len(run.q), len(columns))) * rng.uniform(0.3, 1.7, len(columns))
        return (off / np.sqrt(np.square(off[:, columns]).mean()),)

    def sigma(self, run: SyntheticRun) -> float:
        """RMS error of a joint [rad]."""
        levers = run.arm.levers(run.q)
        return self.size / float(np.sqrt(np.square(levers).sum(axis=(1, 2)).mean()))

    def joints(self, q: Array, run: SyntheticRun) -> Array:
        """Where they stopped."""
        return q + self.sigma(run) * self.off
