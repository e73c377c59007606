"""CMA-ES by its authors, with their restarts."""

import warnings
from typing import ClassVar, final

import numpy as np

from robolaser.algorithms.settings import Setting, number, switch, whole
from robolaser.arrays import Array
from robolaser.benchmark.evaluator import Watch
from robolaser.benchmark.solvers.solver import Contestant
from robolaser.benchmark.solvers.within import from_unit_box

SILENT = -9
"""pycma's word for: neither prints nor files."""


@final
class Pycma(Contestant):
    """Hansen's pycma: restarts with populations now larger, now smaller (BIPOP, Hansen 2009), in the unit box.

    Args:
        name: As asked for.
        sigma: First step, in the unit box; 0.3 is what the authors advise.
        bipop: Whether restarts take small populations in turn with large ones; else each is larger than the last.
        restarts: Of each start; after them it begins anew.
        tolfun: Stop, and restart, where costs differ by less, in the cost's unit.
    """

    called: ClassVar[str] = "pycma"
    settings: ClassVar[tuple[Setting, ...]] = (
        number("sigma"),
        switch("bipop"),
        whole("restarts", 0),
        number("tolfun"),
    )
    title = "pycma: covariance matrix adaptation with BIPOP restarts"

    def __init__(
        self, name: str = called, *, sigma: float = 0.3, bipop: bool = True, restarts: int = 9, tolfun: float = 1e-11
    ) -> None:
        self.name = name
        self._sigma, self._bipop, self._restarts, self._tolfun = sigma, bipop, restarts, tolfun

    def search(self, watch: Watch, seed: int) -> None:
        """Search until the watch ends it."""
        import cma  # noqa: PLC0415 - half a second to import

        from robolaser.algorithms.seeding import seeded  # noqa: PLC0415

        question, rng = watch.question, np.random.default_rng(seed)

        def costs(y: list[Array]) -> list[float]:
            found: list[float] = watch.cost(from_unit_box(np.array(y), question)).tolist()
            return found

        with seeded(seed):
            warnings.simplefilter("ignore")
            while True:
                cma.fmin2(
                    None,
                    lambda: rng.uniform(size=question.dimension),
                    self._sigma,
                    {
                        "bounds": [0, 1],
                        "seed": int(rng.integers(1, 2**31)),
                        "verbose": SILENT,
                        "tolfun": self._tolfun,
                    },
                    restarts=self._restarts,
                    bipop=self._bipop,
                    parallel_objective=costs,
                )
