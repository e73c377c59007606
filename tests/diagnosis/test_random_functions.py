"""Functions at sites: sums over poses give what their columns give."""

from collections.abc import Callable

import numpy as np
import pytest

from robolaser.arrays import Array
from robolaser.data.stated_noise import Noise
from robolaser.diagnosis.candidate_sites import Site, sites
from robolaser.diagnosis.fit import Fit
from robolaser.diagnosis.preparation import Preparation
from robolaser.diagnosis.random_functions import RandomFunctions
from robolaser.robot.by_name import find_robot
from robolaser.simulation import simulate

SIZE = 3.0
"""Of a function, in units of one that just shows among the noise."""


@pytest.fixture(scope="module")
def fitted() -> Fit:
    noise = Noise(pixel_px=0.1, target_m=3e-5)
    dataset = simulate(find_robot("scorbot_er7"), poses=14, points=6, noise=noise, seed=2).dataset
    return Preparation.of(dataset, 1).fit(())


def whitened(columns: Array, believed: Array) -> Array:
    """Columns once a random function with some columns of unit size counts as noise."""
    values, V = np.linalg.eigh(np.eye(len(believed)) + believed @ believed.T)
    return np.asarray((V / np.sqrt(values)) @ V.T @ columns)


def test_normal_equations_are_products_of_columns_before_and_after_a_function_is_believed(fitted: Fit) -> None:
    places = list(sites(fitted))
    functions = RandomFunctions(fitted)
    normal = [functions.normal_equations(site) for site in places]
    believed = fitted.at.project(places[0].columns)
    _compare(fitted, functions, places, normal, lambda columns: columns)
    size = SIZE / float(np.linalg.norm(believed, axis=0).max())
    functions.believe(places[0], size)
    normal = [before - functions.newly_imitated(site) for before, site in zip(normal, places, strict=True)]
    _compare(fitted, functions, places, normal, lambda columns: whitened(columns, size * believed))


def _compare(
    fit: Fit, functions: RandomFunctions, places: list[Site], normal: list[Array], whiten: Callable[[Array], Array]
) -> None:
    residuals = whiten(fit.at.r)
    for site, products in zip(places, normal, strict=True):
        columns = whiten(fit.at.project(site.columns))
        size = float((site.columns**2).sum())
        np.testing.assert_allclose(products, columns.T @ columns, atol=1e-9 * size)
        np.testing.assert_allclose(functions.gradient(site), columns.T @ residuals, atol=1e-7 * np.sqrt(size))


def test_the_largest_square_is_that_of_the_longest_column(fitted: Fit) -> None:
    functions = RandomFunctions(fitted)
    for site in sites(fitted):
        assert functions.largest_square(site) == pytest.approx(np.square(site.columns).sum(axis=0).max())
