"""Where no scripts run, a scene is a picture that has all of it in view."""

import re
from xml.etree import ElementTree as ET

import numpy as np

from robolaser.report.scene import Scene, arrows, dots, labels, path
from robolaser.report.still_scene import MOST_DOTS, SIZE, still

CUBE = np.array(np.meshgrid([0.0, 1.0], [0.0, 1.0], [0.0, 1.0])).reshape(3, -1).T
SHAPES = [
    path(np.stack([CUBE, CUBE + 1.0]), "red", width=2),
    path(np.vstack([CUBE, [[np.nan] * 3]]), "blue", width=1, closed=True, opacity=0.2),
    dots(np.random.default_rng(1).random((5 * MOST_DOTS, 3)), "grey"),
    dots(CUBE[:2], ["green", "pink"]),
    arrows(CUBE, 0.01 * CUBE, "blue", [""] * 8, series="errors"),
    labels(CUBE[:1], ["<joint_1> & co"], "black"),
    labels(np.empty((0, 0, 3)), [], "black"),
]


def test_a_still_scene_shows_each_shape_within_the_picture() -> None:
    picture = str(still(Scene("", "", "", SHAPES, ["a", "b"], start=1, magnification=10.0)))
    marks = list(ET.fromstring(picture))
    assert len(marks) == 8
    ends = [re.findall(r"(-?[\d.]+) (-?[\d.]+)", mark.get("d", "")) for mark in marks]
    drawn = np.array([pair for of_mark in ends for pair in of_mark], np.float64)
    assert np.all((drawn >= 0.0) & (drawn <= SIZE))
    assert len(ends[2]) <= MOST_DOTS
    assert marks[-1].text == "<joint_1> & co"
