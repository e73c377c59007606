"""Every kind of sensor goes through the commands: simulated, checked, calibrated and diagnosed, with pages."""

import json
import subprocess
import sys
from dataclasses import replace

import numpy as np
import pytest

from robolaser.cli import main
from robolaser.data.dataset import Poses
from robolaser.data.writing import save
from robolaser.model.sensors import sensors
from robolaser.simulation import simulate

MOUNTED = [("camera", "base"), ("profile", "base")]
OURS = sorted(kind for kind, one in sensors().items() if one.__module__.startswith("robolaser."))
KINDS = [*((kind, None) for kind in OURS), *MOUNTED]


@pytest.fixture(scope="module", params=KINDS, ids=lambda kind: "-".join(filter(None, kind)))
def dataset(request, tmp_path_factory):
    kind, mount = request.param
    folder = tmp_path_factory.mktemp(kind) / "cell"
    typed = ["simulate", "--robot", "ur5e", "--sensor", kind, "--poses", "12", "--output", str(folder), "--quiet"]
    few = ["--points", "12"] if kind == "camera" else []
    assert main([*typed, *few, *(["--mount", mount] if mount else [])]) == 0
    return folder


def test_it_is_checked(dataset, capsys):
    assert main(["check", str(dataset), "--json"]) == 0
    json.loads(capsys.readouterr().out)


@pytest.fixture(scope="module")
def calibrated(dataset, tmp_path_factory):
    folder = tmp_path_factory.mktemp("calibrated") / "result"
    assert main(["calibrate", str(dataset), "--output", str(folder), "--quiet"]) == 0
    return folder


def test_it_is_calibrated_and_the_page_is_whole(calibrated):
    assert json.loads((calibrated / "calibration.json").read_text())["rms_m"] < 1e-6
    assert "</html>" in (calibrated / "report.html").read_text()


def test_a_cell_as_it_should_be_has_no_gap_and_no_noise_that_is_larger_than_what_is_left(dataset, calibrated, tmp_path):
    assert main(["diagnose", str(dataset), "--output", str(tmp_path / "result"), "--quiet"]) == 0
    found = json.loads((tmp_path / "result" / "diagnosis.json").read_text())
    assert found["verdict"] == "no_gap"
    assert found["gap_mm"]["noise_floor"] < 0.05
    written, before = ({file.name for file in folder.iterdir()} for folder in (tmp_path / "result", calibrated))
    assert written - before == {"diagnosis.json"}
    assert before <= written


def test_measured_flange_poses_are_calibrated_without_pinocchio_and_without_a_compiler(tmp_path):
    points, result = tmp_path / "points", tmp_path / "result"
    made = simulate("ur5", poses=8, seed=1).dataset
    poses = Poses(made.poses.names, T_base_flange=np.asarray(made.flange()))
    save(replace(made, robot=None, poses=poses), points)
    program = (
        "import sys; from robolaser.cli import main;"
        f"failed = main(['calibrate', {str(points)!r}, '--output', {str(result)!r}, '--quiet']);"
        "print(failed, {'pinocchio', 'numba'} & set(sys.modules))"
    )
    ended = subprocess.run([sys.executable, "-c", program], check=True, capture_output=True, text=True)
    assert ended.stdout.split("\n")[-2] == "0 set()"
