"""What a newcomer does, from images or a table to the file that is taken home.

Images of a scanner become a calibration and the cloud of a flat board; a tracker's table becomes a corrected arm;
images and flange poses become a hand-eye calibration and files for ROS.
"""

import csv
import faulthandler
import json
import re
import shutil
import subprocess
import sys
from collections.abc import Iterator
from pathlib import Path
from typing import Any

import numpy as np
import pinocchio
import pytest
from scipy.optimize import least_squares
from scipy.spatial.transform import Rotation

sys.path.insert(0, str(Path(__file__).parents[1] / "docs"))

import run_code_blocks
from run_code_blocks import PAGES, blocks
from typed import run_typed

from robolaser.arrays import Array
from robolaser.cli import main

ROOT = Path(__file__).parents[1]
RUN = [page for page in PAGES if any(block.runs for block in blocks(page.read_text(encoding="utf-8")))]
LONGEST_S = 300.0
"""That a page takes: a command without an end is a failure."""


def defines_a_sensor(page: Path) -> bool:
    """It is registered by its definition, and would be there on all other pages."""
    return re.search(r"^class .*\(Sensor\)", page.read_text(encoding="utf-8"), re.MULTILINE) is not None


@pytest.fixture
def typed(monkeypatch: pytest.MonkeyPatch) -> Iterator[None]:
    """Commands of a page run in this process, and end."""
    monkeypatch.setattr(run_code_blocks, "run_shell", run_typed)
    faulthandler.dump_traceback_later(LONGEST_S, exit=True)
    yield
    faulthandler.cancel_dump_traceback_later()


@pytest.mark.parametrize("page", RUN, ids=lambda page: page.relative_to(ROOT).as_posix())
@pytest.mark.filterwarnings("default")
@pytest.mark.usefixtures("typed")
def test_every_command_of_the_page_prints_what_the_page_shows(page: Path) -> None:
    """Each in an empty folder with the examples beside it, from the first file to the last one."""
    if not defines_a_sensor(page):
        assert run_code_blocks.run_page(page, update=False)
        return
    ran = subprocess.run(
        [sys.executable, str(ROOT / "docs" / "run_code_blocks.py"), str(page)],
        capture_output=True, text=True, check=False, timeout=LONGEST_S,
    )  # fmt: skip
    assert ran.returncode == 0, ran.stdout + ran.stderr


THIRD = 3
"""Every third pose is measured, but not shown to the diagnosis."""


@pytest.fixture(scope="module")
def arm(tmp_path_factory):
    """A diagnosis of most poses of an arm, and the table of all."""
    folder = tmp_path_factory.mktemp("arm")
    effects = ["link_compliance:elbow_joint=2e-5", "joint_offset:wrist_2_joint=0.003"]
    typed = ["simulate", "--robot", "ur5", "--sensor", "point", "--poses", "105", "--unplaced", "--point-m", "3e-5"]
    typed += [word for effect in effects for word in ("--effect", effect)]
    assert main([*typed, "--output", str(folder / "all"), "--quiet"]) == 0
    shutil.copytree(folder / "all", folder / "shown")
    head, *lines = (folder / "all" / "points.csv").read_text().splitlines()
    shown = [line for line in lines if int(line.partition(",")[0]) % THIRD]
    (folder / "shown" / "points.csv").write_text("\n".join([head, *shown]) + "\n")
    assert main(["diagnose", str(folder / "shown"), "--output", str(folder / "why"), "--quiet"]) == 0
    return folder


def found_by(flange: Array, pose: Array, reflector: Array, measured: Array) -> float:
    """Error of flange poses (n, 4, 4) against measured points, base and reflectors fitted: no code of the package."""

    def apart(x: Array) -> Array:
        tool = x[6:].reshape(-1, 3)[reflector]
        seen = np.einsum("nij,nj->ni", flange[pose, :3, :3], tool) + flange[pose, :3, 3]
        return (Rotation.from_rotvec(x[:3]).apply(seen) + x[3:6] - measured).ravel()

    ends = [least_squares(apart, np.r_[turn, np.zeros(3 + 3 * (1 + reflector.max()))], x_scale="jac")
            for turn in ((0.0, 0.0, 0.0), (0.0, 0.0, 3.0))]  # fmt: skip
    best = min(ends, key=lambda end: end.cost)
    return float(np.sqrt(2.0 * best.cost / (len(measured) - len(best.x) / 3)))


def test_each_file_of_the_corrected_arm_delivers_what_is_stated(arm):
    with (arm / "all" / "poses.csv").open() as file:
        poses = list(csv.DictReader(file))
    with (arm / "all" / "points.csv").open() as file:
        rows = [row for row in csv.DictReader(file) if int(row["pose"]) % THIRD == 0]
    joints = [name for name in poses[0] if name.startswith("q_")]
    unseen = {row["pose"]: i for i, row in enumerate(row for row in poses if int(row["pose"]) % THIRD == 0)}
    q = np.array([[float(row[joint]) for joint in joints] for row in poses if row["pose"] in unseen])
    names = sorted({row["point"] for row in rows})
    measured = np.array([[float(row[axis]) for axis in ("x_m", "y_m", "z_m")] for row in rows])
    seen = (
        np.array([unseen[row["pose"]] for row in rows]),
        np.array([names.index(row["point"]) for row in rows]),
        measured,
    )

    def by_urdf(path: Path) -> Array:
        model = pinocchio.buildModelFromUrdf(str(path))
        data, frame = model.createData(), model.getFrameId("tool0")
        flange = []
        for values in q:
            pinocchio.framesForwardKinematics(model, data, values)
            flange.append(data.oMf[frame].homogeneous.copy())
        return np.array(flange)

    module: dict[str, Any] = {}
    exec((arm / "why" / "corrected.py").read_text(), module)
    stated = {
        one["file"]: one["held_out_mm"] for one in json.loads((arm / "why" / "diagnosis.json").read_text())["files"]
    }
    nominal = 1e3 * found_by(by_urdf(arm / "shown" / "robot.urdf"), *seen)
    by_python = 1e3 * found_by(module["forward"](q), *seen)
    assert by_python == pytest.approx(stated["corrected.py"], rel=0.1)
    delivered = 1e3 * found_by(by_urdf(arm / "why" / "robot_corrected.urdf"), *seen)
    assert delivered == pytest.approx(stated["robot_corrected.urdf"], rel=0.1)
    assert by_python < delivered < nominal / 2
