"""Every draw from one seed, also where pymoo and pycma draw from elsewhere."""

import random
import warnings
from collections.abc import Iterator
from contextlib import contextmanager
from types import SimpleNamespace

import numpy as np
import pymoo.util


@contextmanager
def seeded(seed: int) -> Iterator[None]:
    """Let all that is drawn within follow from a seed, and leave global generators and warning filters as they were.

    pymoo hands its generator from function to function, and here and there forgets to: its pattern search, its Gaussian
    mutation and its crossover of differential evolution then draw from a generator that nobody seeded. Those draw from
    one generator here. pycma draws from NumPy's global one. Not for two threads at once.
    """
    forgotten = np.random.default_rng(seed)

    def generator(given: object = None) -> np.random.Generator:
        return forgotten if given is None else np.random.default_rng(given)  # type: ignore[arg-type]

    theirs, numpys, pythons = pymoo.util.np, np.random.get_state(), random.getstate()  # noqa: NPY002
    pymoo.util.np = SimpleNamespace(random=SimpleNamespace(default_rng=generator))
    random.seed(seed)
    np.random.seed(seed % 2**32)  # noqa: NPY002
    try:
        with warnings.catch_warnings():  # pycma changes their filters
            yield
    finally:
        pymoo.util.np = theirs
        np.random.set_state(numpys)  # noqa: NPY002
        random.setstate(pythons)
