"""Where the disk fills or goes read-only the old result is left, and where a command is killed never parts of two."""

import errno
import functools
import shutil
from concurrent.futures import ThreadPoolExecutor
from contextlib import contextmanager

import cv2
import numpy as np
import pytest
from failing_disk import contents, failing, restore, watched

from robolaser.benchmark.executors import Engine
from robolaser.cli import main
from robolaser.data.result_folder import STAGED
from robolaser.trials.trial import truth_beside, unseal

STATE = ("runs.jsonl", "search.json")  # of what is stopped, to be gone on with
TRUTH = "trial.truth"  # of any trial that was begun


def seen(files):
    """What a reader sees: hidden files do not count."""
    return {
        name: data
        for name, data in files.items()
        if not name.rpartition("/")[2].startswith(".") and name not in STATE and not name.startswith(TRUTH)
    }


def result(folder):
    """What a reader sees; of a trial, that its truth is there."""
    if (folder / "trial" / "seal.txt").exists():
        unseal(folder / "trial", truth_beside(folder / "trial"))
    return seen(contents(folder))


@pytest.fixture(scope="module")
def inputs(tmp_path_factory):
    folder = tmp_path_factory.mktemp("inputs")
    few = ["--poses", "10", "--points", "5", "--quiet"]
    assert main(["simulate", "--robot", "scorbot_er7", "--output", str(folder / "stripe"), *few]) == 0
    assert (
        main(["simulate", "--robot", "scorbot_er7", "--sensor", "point", "--output", str(folder / "point"), *few]) == 0
    )
    assert main(["calibrate", str(folder / "stripe"), "--output", str(folder / "calibration"), "--quiet"]) == 0
    recording = folder / "recording"
    recording.mkdir()
    (recording / "dataset.toml").write_text((folder / "stripe" / "dataset.toml").read_text())
    (recording / "robot.urdf").write_bytes((folder / "stripe" / "robot.urdf").read_bytes())
    header, *rows = (folder / "stripe" / "poses.csv").read_text().splitlines()[:5]
    shown = [f"{row},{number}.png" for number, row in enumerate(rows)]
    (recording / "poses.csv").write_text("\n".join([f"{header},image", *shown]) + "\n")
    image = np.full((480, 640), 20, np.uint8)
    image[240:243] = 200
    for number in range(len(rows)):
        cv2.imwrite(str(recording / f"{number}.png"), image)
    shutil.copytree(recording, folder / "shorter")
    (folder / "shorter" / "poses.csv").write_text("\n".join([f"{header},image", *shown[1:]]) + "\n")
    for table in ("poses", "points"):
        (folder / f"{table}.csv").write_bytes((folder / "point" / f"{table}.csv").read_bytes())
    return folder


def typed(inputs, command, out):
    """What is typed for a result, and what for another one."""
    stripe, recording, calibration = inputs / "stripe", inputs / "recording", inputs / "calibration"
    point = inputs / "point"
    words, more = {
        "simulate": (f"--robot scorbot_er7 --poses 6 --output {out}", "--seed 2"),
        "simulate two": (f"--robot scorbot_er7 --sensor stripe+camera --poses 4 --output {out}", "--seed 2"),
        "import": (
            f"{inputs}/poses.csv {inputs}/points.csv --robot scorbot_er7 --units m,rad --output {out}",
            "--path unknown",
        ),
        "calibrate": (f"{stripe} --output {out}", "--weights noise"),
        "diagnose": (f"{point} --output {out}", "--without backlash"),
        "extract": (f"{recording} --output {out}", ""),
        "scan": (f"{calibration} {stripe} --output {out}/c.ply --report", "--nominal"),
        "scan las": (f"{calibration} {stripe} --output {out}/c.las", "--nominal"),
        "compare": (
            f"pymoo:sphere-2 --algorithms ga --seeds 1 --budget 200 --jobs 1 --iohprofiler --output {out}",
            "--seed 7",
        ),
        "challenge": (f"new {out}/trial --kinds none --count 1 --poses 6 --points 3", "--seed 2"),
    }[command]
    first, again = ([command.split()[0], *said.split()] for said in (words, f"{words} {more}"))
    return first, [word.replace(str(recording), str(inputs / "shorter")) for word in again]


COMMANDS = (
    "simulate", "simulate two", "import", "calibrate", "diagnose", "extract", "scan", "scan las", "compare",
    "challenge",
)  # fmt: skip


COMPUTED = (
    "robolaser.calibration.calibrate.calibrate",
    "robolaser.api.examine",
    "robolaser.diagnosis.corrected_model.corrected",
    "robolaser.simulation.simulate",
    "robolaser.trials.trial.make",
)


@contextmanager
def here(*_, **__):
    """Runs of a comparison in this process: one of their own takes a second to start."""
    with ThreadPoolExecutor(1) as executor:
        yield Engine(executor, "this machine", 1)


@pytest.fixture(autouse=True)
def computed_once(monkeypatch):
    """What is computed is the same each time, and takes long."""
    monkeypatch.setattr("robolaser.benchmark.compare.engine_of", here)
    for place in COMPUTED:
        module, _, name = place.rpartition(".")
        monkeypatch.setattr(place, _once(module, name))


@functools.cache
def _once(module, name):
    compute = getattr(__import__(module, fromlist=[name]), name)
    known = {}

    def remembered(data, *args, **more):
        key = repr([args, {word: value for word, value in more.items() if word not in ("progress", "state", "tell")}])
        if key not in known:
            known[key] = compute(data, *args, **more)
        return known[key]

    return remembered


@pytest.mark.parametrize("command", COMMANDS)
def test_what_is_left_is_of_one_result(inputs, command, tmp_path, capsys):
    if command.endswith("las"):
        pytest.importorskip("laspy")
    folder, left = tmp_path / "out", tmp_path / "left"
    folder.mkdir()
    left.mkdir()
    words, other = typed(inputs, command, folder)
    again = [*other, "--force", "--quiet"]
    assert main([*words, "--quiet"]) == 0
    before, old = contents(folder), result(folder)
    moments = []
    with watched(folder, lambda _: moments.append(contents(folder))):
        assert main(again) == 0
    new = result(folder)
    assert old != new

    for moment in moments:  # killed there
        if "trial/seal.txt" in moment:
            restore(left, moment)
            assert result(left) == seen(moment)
        parts = seen(moment).items()
        assert parts <= old.items() or parts <= new.items()

    for kind, number in ((errno.EROFS, 0), (errno.ENOSPC, len(moments) // 3)):
        restore(folder, before)
        with watched(folder, failing(number, kind)):
            assert main(again) == 1
        assert capsys.readouterr().err.startswith("robolaser: Cannot write")
        assert result(folder) == old
    restore(folder, max(moments, key=lambda moment: sum(STAGED in name for name in moment)))
    assert main(again) == 0  # nothing that was left stands in the way, or stays
    assert result(folder) != old
    assert not [name for name in contents(folder) if STAGED in name]
