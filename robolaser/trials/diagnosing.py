"""The diagnoses of a trial, in worker processes of this machine or of a Dask cluster."""

import json
from collections.abc import Iterator, Mapping
from concurrent.futures import Future, as_completed
from dataclasses import dataclass
from pathlib import Path
from typing import final

from robolaser.benchmark.engines import Engine, Job
from robolaser.data.dataset import Dataset
from robolaser.data.loading import load
from robolaser.data.result_folder import write_results
from robolaser.diagnosis import examine
from robolaser.diagnosis.result_json import diagnosis_json
from robolaser.errors import TrialError

TIME_LIMIT_S, MEMORY_LIMIT_B = 3600.0, 16_000_000_000  # of one diagnosis: only what hangs or runs wild is stopped


@final
@dataclass(frozen=True)
class DiagnosisJob(Job):
    """The diagnosis of one data set, which goes with it to where it is diagnosed."""

    dataset: Dataset
    seed: int
    time_limit_s: float = TIME_LIMIT_S
    memory_limit_b: int = MEMORY_LIMIT_B

    @property
    def kind(self) -> str:
        """All are alike."""
        return "diagnosis"

    def prepared(self, payload: None) -> None:
        """There is nothing to prepare."""

    def done(self, prepared: None) -> "str | TrialError":
        """The diagnosis, as diagnosis.json has it."""
        return _diagnosed(self.dataset, seed=self.seed)

    def failed(self, reason: str, *, seconds: float = 0.0) -> "str | TrialError":
        """What `diagnose_all` raises."""
        return TrialError(f"{self.dataset.name} could not be diagnosed: {reason}.")


def diagnose_all(worlds: Mapping[Path, Path], *, seed: int, engine: Engine | None) -> Iterator[int]:
    """Diagnose data sets, and yield how many are done as each is.

    Args:
        worlds: Where each diagnosis is written, by the folder of its data set.
        seed: Of all diagnoses.
        engine: Where they are made; None: in this process.

    Raises:
        TrialError: One cannot be made.
    """
    if engine is None:
        for i, (world, path) in enumerate(worlds.items()):
            yield i
            write_results(path.parent, {path.name: _diagnosed(load(world), seed=seed)})
        return
    payload = engine.share(b"N.")  # None, pickled
    futures: dict[Future[str | TrialError], Path] = {
        engine.submit(DiagnosisJob(load(world), seed), payload): path for world, path in worlds.items()
    }
    for i, future in enumerate(as_completed(futures)):
        yield i
        said, path = future.result(), futures[future]
        if isinstance(said, TrialError):
            raise said
        write_results(path.parent, {path.name: said})


def _diagnosed(dataset: Dataset, *, seed: int) -> str:
    return json.dumps(diagnosis_json(examine(dataset, seed=seed)), indent=1) + "\n"
