"""What beside the stripe may spoil its middle, and what is no stripe."""

import numpy as np
import pytest
from drawn import HEIGHT, WAVY, WIDTH, exposed, profile

from robolaser.vision.stripe_detection import find_line_centres


def test_a_broad_lamp_beside_a_faint_stripe_does_not_hide_it():
    light = profile(WAVY, 2, 70)
    light[:, 500:620] += 235
    found = find_line_centres(exposed(10 + light), "v")
    nearest = np.full(HEIGHT, np.inf)
    np.minimum.at(nearest, found.line, np.abs(found.pixel[:, 0] - WAVY[found.line]))
    assert np.all(nearest < 0.05)


def test_a_stripe_cut_by_the_border_has_no_middle():
    course = np.linspace(WIDTH - 30, WIDTH + 5, HEIGHT)
    found = find_line_centres(exposed(20 + profile(course, 5, 800)), "v")
    assert len(found) > HEIGHT // 2
    assert np.abs(found.pixel[:, 0] - course[found.line]).max() < 0.1
    assert course[found.line].max() < WIDTH - 5


@pytest.mark.parametrize("grey", [0, 40, 255])
def test_an_even_image_shows_no_stripe(grey):
    assert len(find_line_centres(np.full((HEIGHT, WIDTH), grey, np.uint8), "v")) == 0


def test_an_edge_beside_the_stripe_makes_it_lopsided():
    paper = np.where(np.arange(WIDTH) > WAVY[:, None] + 2, 0.2, 1.0)
    even = find_line_centres(exposed(20 + profile(WAVY, 4, 180)), "v")
    bitten = find_line_centres(exposed(paper * (20 + profile(WAVY, 4, 180))), "v")
    assert np.median(np.abs(bitten.asymmetry)) > 5 * np.median(np.abs(even.asymmetry))
