"""What is compiled and its twin in NumPy see the same stripe."""

from collections.abc import Iterator
from contextlib import contextmanager
from dataclasses import fields

import numpy as np
import pytest
from drawn import WAVY, WIDTH, exposed, profile

from robolaser.compiled.loops import SWITCH, compiles
from robolaser.vision.stripe_detection import find_line_centres

pytestmark = pytest.mark.skipif(compiles() == "0", reason="there is no compiler")
IMAGES = {
    "clean": 20 + profile(WAVY, 2, 150),
    "saturated": 20 + profile(WAVY, 3, 600),
    "glaring": 20 + profile(WAVY, 6, 3000),
    "double": 20 + profile(WAVY, 2, 150) + profile(WAVY + 15, 2, 90),
    "at the border": 20 + profile(WAVY - 320, 2, 150) + profile(WAVY + 290, 5, 300),
    "on a slope": np.linspace(0, 120, WIDTH) + profile(WAVY, 2, 90),
}


@pytest.fixture(autouse=True)
def compiled_at_once(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setenv(SWITCH, "1")


@contextmanager
def without_compiler() -> Iterator[None]:
    with pytest.MonkeyPatch.context() as patch:
        patch.setenv(SWITCH, "0")
        yield


@pytest.mark.parametrize("way", ["gravity", "gauss"])
@pytest.mark.parametrize("name", IMAGES)
def test_compiled_and_numpy_find_the_same_middles(name, way):
    image = exposed(IMAGES[name], 3.0, 1)
    fast = find_line_centres(image, "v", way)
    with without_compiler():
        plain = find_line_centres(image, "v", way)
    for item in fields(fast):
        np.testing.assert_allclose(getattr(fast, item.name), getattr(plain, item.name), rtol=1e-6, atol=1e-8)


def test_without_runs_there_is_nothing_to_measure():
    black = np.zeros((40, 60), np.uint8)
    for way in ("gravity", "gauss", "steger"):
        assert len(find_line_centres(black, "v", way)) == 0
        with without_compiler():
            assert len(find_line_centres(black, "v", way)) == 0
