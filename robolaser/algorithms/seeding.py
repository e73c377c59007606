"""A seed for all random draws, also where pymoo and pycma draw from global generators."""

import random
import threading
import warnings
from collections.abc import Iterator
from contextlib import contextmanager
from types import SimpleNamespace

import numpy as np
import pymoo.util

_GLOBALS = threading.RLock()  # locked while global generators are replaced


@contextmanager
def seeded(seed: int) -> Iterator[None]:
    """Derive all random draws from a seed, and restore global generators and warning filters at the end.

    pymoo passes its generator from function to function, but its pattern search, its Gaussian mutation and its
    crossover of differential evolution draw from a new, unseeded one. Here they share a seeded one. pycma draws from
    NumPy's global generator. Only one thread at a time can be inside.
    """
    unseeded = np.random.default_rng(seed)

    def generator(given: object = None) -> np.random.Generator:
        return unseeded if given is None else np.random.default_rng(given)  # type: ignore[arg-type]

    with _GLOBALS, warnings.catch_warnings():  # pycma changes the filters
        pymoos, numpys, pythons = pymoo.util.np, np.random.get_state(), random.getstate()  # noqa: NPY002
        pymoo.util.np = SimpleNamespace(random=SimpleNamespace(default_rng=generator))
        random.seed(seed)
        np.random.seed(seed % 2**32)  # noqa: NPY002
        try:
            yield
        finally:
            pymoo.util.np = pymoos
            np.random.set_state(numpys)  # noqa: NPY002
            random.setstate(pythons)
