"""A sensor that a user wrote, whose rows are pixels and no points in space, has a page too."""

from dataclasses import replace

import numpy as np
import pytest
from calibrated import finished, poses
from diagnosed import of, with_effects
from page_claims import is_closed_and_its_ids_are_its_own, scenes, sound_charts

from robolaser.data.dataset import Dataset, Points
from robolaser.data.sensor_format import SensorFormat
from robolaser.model.error_source import ErrorSource, along_each_axis
from robolaser.model.forward_model import Model
from robolaser.model.sensors.sensor import REGISTERED, Sensor, SensorParameters
from robolaser.report.calibration.page import document
from robolaser.report.diagnosis.page import document as diagnosis_document
from robolaser.report.error_analysis import ErrorAnalysis, lengths_mm
from robolaser.report.page import render

FOCAL_PX, DEPTH_M = 800.0, 0.5


@pytest.fixture
def calibration():
    class Pinhole(Sensor):
        format = SensorFormat(kind="pinhole", title="pinhole camera", task="the camera sees the mark",
                              columns={"pixel": ("u_px", "v_px")}, numbers=2,
                              unit="px", units={"tool.x": "m", "tool.y": "m", "tool.z": "m"})  # fmt: skip
        parameters = SensorParameters(derived=("tool.x", "tool.y", "tool.z"))

        def initialize(self, values, T_base_flange, perturb):
            return dict.fromkeys(self.parameters.derived, np.zeros(1))

        def residuals(self, values, T_base_flange, perturb):
            tool = np.stack([values[name] for name in self.parameters.derived], axis=-1)
            seen = np.einsum("cnij,cj->cni", T_base_flange[..., :3, :3], tool) + T_base_flange[..., :3, 3]
            pixel = FOCAL_PX * seen[..., :2] / (seen[..., 2:] + 3.0)
            return self.dataset.points.pixel - pixel[:, self.dataset.points.pose]

        def row_errors(self, values, T_base_flange, perturb):
            rows = len(self.dataset.points)
            return [ErrorSource("pixel", along_each_axis(rows, 2), np.arange(rows), "px", stated=0.2)]

        def in_metres(self, residuals, values, T_base_flange, perturb):
            return residuals * DEPTH_M / FOCAL_PX

    rng = np.random.default_rng(0)
    where = poses(rng, None)
    points = Points(np.arange(len(where)), ("mark",) * len(where), pixel=rng.normal(size=(len(where), 2)))
    yield finished(Model(Dataset("seen", where, points, kind="pinhole")), np.zeros(3))
    del REGISTERED["pinhole"]


def test_its_errors_are_lengths_and_its_words_its_own(calibration):
    calibration = replace(calibration, noise={"pixel": 0.2})
    text = render(document(calibration))
    is_closed_and_its_ids_are_its_own(text)
    assert "pinhole camera" in text
    assert "the camera sees the mark" in text
    assert not [shape for shape in scenes(text)[0]["shapes"] if shape["kind"] == "arrows"]
    assert sound_charts(text)
    analysis = ErrorAnalysis(calibration)
    pixels = np.linalg.norm(calibration.residuals, axis=1)
    np.testing.assert_allclose(lengths_mm(calibration.errors_m), 1e3 * pixels * DEPTH_M / FOCAL_PX)
    assert analysis.noise_m == pytest.approx(np.sqrt(2) * 0.2 * DEPTH_M / FOCAL_PX, rel=1e-3)


def test_it_is_drawn_in_a_diagnosis(calibration):
    assert len(scenes(render(diagnosis_document(of(with_effects(calibration, ()), "unexplained"))))) == 1
