"""The diagnoses of a trial, in worker processes of this machine or of a Dask cluster."""

import json
from collections.abc import Iterator, Mapping
from concurrent.futures import Executor, as_completed
from pathlib import Path

from robolaser.data.dataset import Dataset
from robolaser.data.loading import load
from robolaser.data.result_folder import write_results
from robolaser.diagnosis import examine
from robolaser.diagnosis.result_json import diagnosis_json
from robolaser.errors import TrialError


def diagnose_all(worlds: Mapping[Path, Path], *, seed: int, executor: Executor | None) -> Iterator[int]:
    """Diagnose data sets, and yield how many are done as each is.

    Args:
        worlds: Where each diagnosis is written, by the folder of its data set.
        seed: Of all diagnoses.
        executor: Where they are made; None: in this process.

    Raises:
        TrialError: One cannot be made.
    """
    if executor is None:
        for i, (world, path) in enumerate(worlds.items()):
            yield i
            write_results(path.parent, {path.name: _diagnosed(load(world), seed)})
        return
    futures = {executor.submit(_diagnosed, load(world), seed): (world, path) for world, path in worlds.items()}
    for i, future in enumerate(as_completed(futures)):
        yield i
        world, path = futures[future]
        try:
            said = future.result()
        except Exception as error:
            raise TrialError(f"{world.name} could not be diagnosed: {error}") from error
        write_results(path.parent, {path.name: said})


def _diagnosed(dataset: Dataset, seed: int) -> str:
    return json.dumps(diagnosis_json(examine(dataset, seed=seed)), indent=1) + "\n"
