"""What is compiled and its twin in NumPy see the same stripe."""

from collections.abc import Iterator
from contextlib import contextmanager
from dataclasses import fields

import numpy as np
import pytest
from drawn import WAVY, WIDTH, exposed, profile

from robolaser import compiled
from robolaser.compiled import SWITCH
from robolaser.vision.stripe import stripe_centres

pytestmark = pytest.mark.skipif(not compiled.available(), reason="there is no compiler")
IMAGES = {
    "clean": 20 + profile(WAVY, 2, 150),
    "saturated": 20 + profile(WAVY, 3, 600),
    "glaring": 20 + profile(WAVY, 6, 3000),
    "double": 20 + profile(WAVY, 2, 150) + profile(WAVY + 15, 2, 90),
    "at the border": 20 + profile(WAVY - 320, 2, 150) + profile(WAVY + 290, 5, 300),
    "on a slope": np.linspace(0, 120, WIDTH) + profile(WAVY, 2, 90),
}


@contextmanager
def without_compiler() -> Iterator[None]:
    with pytest.MonkeyPatch.context() as patch:
        patch.setenv(SWITCH, "0")
        compiled.available.cache_clear()
        yield
    compiled.available.cache_clear()


@pytest.mark.parametrize("way", ["mass", "gauss"])
@pytest.mark.parametrize("name", IMAGES)
def test_compiled_and_numpy_find_the_same_middles(name, way):
    image = exposed(IMAGES[name], 3.0, 1)
    fast = stripe_centres(image, "v", way)
    with without_compiler():
        plain = stripe_centres(image, "v", way)
    for item in fields(fast):
        np.testing.assert_allclose(getattr(fast, item.name), getattr(plain, item.name), rtol=1e-6, atol=1e-8)


def test_without_runs_there_is_nothing_to_measure():
    black = np.zeros((40, 60), np.uint8)
    for way in ("mass", "gauss", "steger"):
        assert len(stripe_centres(black, "v", way)) == 0
        with without_compiler():
            assert len(stripe_centres(black, "v", way)) == 0
