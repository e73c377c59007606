"""The commands on a log of a moving arm."""

import csv
import json
from contextlib import redirect_stdout
from importlib.resources import files
from io import StringIO
from pathlib import Path
from typing import Any

import jsonschema
import pytest
from moved_arms import urdf

import robolaser
from robolaser.cli import main
from robolaser.errors import UsageError
from robolaser.motion import simulation


@pytest.fixture(scope="module")
def folder(tmp_path_factory: pytest.TempPathFactory) -> Path:
    made = tmp_path_factory.mktemp("motion")
    (made / "arm.urdf").write_text(urdf(), encoding="utf-8")
    asked = ["--sensor", "motion", "--robot", str(made / "arm.urdf"), "--flange", "tool", "--sessions", "8"]
    effects = ["--effect", "lag:lift=0.06", "--effect", "viscous_friction:pan=2"]
    with pytest.MonkeyPatch.context() as patch:
        patch.setattr(simulation, "DURATION_S", 2.5)
        assert main(["simulate", *asked, *effects, "--output", str(made / "log"), "--seed", "2"]) == 0
    return made


@pytest.fixture(scope="module")
def printed(folder: Path) -> dict[str, Any]:
    """What `diagnose` prints; it writes the folder `why`."""
    with redirect_stdout(StringIO()) as out:
        assert main(["diagnose", str(folder / "log"), "--output", str(folder / "why"), "--seed", "0", "--json"]) == 0
    found: dict[str, Any] = json.loads(out.getvalue())
    return found


def run(capsys: pytest.CaptureFixture[str], *typed: str) -> tuple[int, Any]:
    code = main([*typed, "--json"])
    out = capsys.readouterr().out
    return code, json.loads(out) if out.strip() else None


def test_check_says_which_effects_the_log_can_show(folder, capsys):
    code, found = run(capsys, "check", str(folder / "log"))
    assert code == 0
    assert set(found["row_kinds"]) == {"tracking", "torque", "load"}
    assert {"lag", "viscous_friction", "gear_spring"} <= {one["effect"] for one in found["effects"] if one["where"]}


def test_diagnose_writes_what_the_schema_says_a_page_and_a_table_for_simulators(folder, printed):
    written = json.loads((folder / "why" / "diagnosis.json").read_text(encoding="utf-8"))
    assert printed == written
    jsonschema.validate(written, json.loads(files("robolaser.schemas").joinpath("diagnosis.schema.json").read_text()))
    assert written["verdict"] == "explained"
    assert {one["effect"]: one["where"] for one in written["kinds"]} == {"lag": ["lift"], "viscous_friction": ["pan"]}
    assert (written["objective_m2"], written["rms_m"]) == (None, None)
    assert {row["kind"]: row["unit"] for row in written["rows"]} == {"tracking": "rad", "torque": "Nm", "load": "rad"}
    assert "lift" in (folder / "why" / "report.html").read_text(encoding="utf-8")
    rows = list(csv.DictReader((folder / "why" / "servos.csv").read_text(encoding="utf-8").splitlines()))
    told = {(row["effect"], row["joint"], row["number"]): float(row["value"]) for row in rows}
    assert told == {
        (one["effect"], one["where"], name): number["value"]
        for one in written["effects"]
        for name, number in one["parameters"].items()
    }
    deviations = [number["std"] for one in written["effects"] for number in one["parameters"].values()]
    assert [float(row["std"]) for row in rows] == pytest.approx(deviations, rel=0.01)
    words = {row["effect"]: (row["isaac_lab"], row["ros"]) for row in rows}
    assert words["viscous_friction"][0].startswith("viscous_friction = ")
    assert words["viscous_friction"][1].startswith("URDF: <dynamics damping=")
    assert "stiffness" in words["lag"][0]


def test_files_lists_what_the_folder_holds_for_others(folder, printed):
    (table,) = printed["files"]
    pairs = [[one["effect"], one["where"]] for one in printed["effects"]]
    assert table == {"file": "servos.csv", "held_out_mm": None, "contains": pairs, "lacks": []}
    assert (folder / "why" / table["file"]).exists()


def test_view_says_what_a_motion_is_for(folder, capsys):
    assert main(["view", str(folder / "log")]) != 0
    assert "Traceback" not in capsys.readouterr().err


@pytest.mark.parametrize(
    ("effect", "said"),
    [
        ("lagg:lift=0.06", "'lag'"),
        ("lag:lif=0.06", "'lift'"),
        ("lag:lift.tim=0.06", "'time'"),
        ("lag:lift=-0.1", "time is -0.1 s, but its bounds are 0 and 2 s"),
    ],
)
def test_an_effect_that_cannot_be_is_wrong_usage(folder, effect, said, capsys, tmp_path):
    asked = ["simulate", "--sensor", "motion", "--robot", str(folder / "arm.urdf"), "--flange", "tool"]
    assert main([*asked, "--effect", effect, "--output", str(tmp_path / "log")]) == 2
    assert said in capsys.readouterr().err


def test_calibrate_finds_the_numbers_of_what_is_asked(folder, capsys):
    asked = ["--with", "lag:lift", "--with", "viscous_friction:pan", "--output", str(folder / "numbers")]
    code, printed = run(capsys, "calibrate", str(folder / "log"), *asked)
    assert code == 0
    written = json.loads((folder / "numbers" / "calibration.json").read_text(encoding="utf-8"))
    assert printed == written
    jsonschema.validate(written, json.loads(files("robolaser.schemas").joinpath("calibration.schema.json").read_text()))
    lag = next(one for one in written["effects"] if one["effect"] == "lag")
    assert lag["where"] == "lift"
    assert lag["parameters"]["time"]["value"] == pytest.approx(0.06, rel=0.01)
    assert (written["objective_m2"], written["rms_m"]) == (None, None)
    assert written["held_out_rms_m"] < 1e-4
    assert (folder / "numbers" / "report.html").stat().st_size > 10_000


@pytest.mark.parametrize(
    ("asked", "code", "said"),
    [
        ("lagg", 2, "'lag'"),
        ("lag:lif", 2, "'lift'"),
        ("clock_shift:lift", 2, "no location 'lift'"),
        ("range_limit:pan", 1, "range_limit at pan"),
    ],
)
def test_calibrate_says_why_an_effect_cannot_be_fitted(folder, asked, code, said, capsys, tmp_path):
    assert main(["calibrate", str(folder / "log"), "--with", asked, "--output", str(tmp_path / "out")]) == code
    assert said in capsys.readouterr().err


def test_calibrate_asks_for_effects_where_none_is_named(folder, capsys, tmp_path):
    assert main(["calibrate", str(folder / "log"), "--output", str(tmp_path / "out")]) == 0
    assert "No effect was fitted. Name some with --with" in capsys.readouterr().out


@pytest.mark.parametrize("typed", ["diagnose --validate {log}", "calibrate --weights noise", "calibrate --no-polish"])
def test_an_option_that_only_measured_poses_have_is_refused_not_ignored(folder, typed, capsys, tmp_path):
    command, *options = typed.format(log=folder / "log").split()
    assert main([command, str(folder / "log"), *options, "--output", str(tmp_path / "out")]) != 0
    assert options[0] in capsys.readouterr().err
    assert not (tmp_path / "out").exists()


def test_an_option_of_a_plan_that_only_measured_poses_have_is_refused_not_ignored(folder):
    for options in ({"weights": "noise"}, {"algorithm": "rcga"}, {"polish": False}):
        with pytest.raises(UsageError, match=next(iter(options))):
            robolaser.calibrate(folder / "log", robolaser.Plan(**options), effects=["lag:lift"])


def test_a_calibration_is_read_back_and_held_against_another(folder, tmp_path, capsys):
    made = robolaser.calibrate(folder / "log", robolaser.Plan(effects=("lag:lift",), seed=2))
    made.save(tmp_path / "a")
    back = robolaser.load_calibration(tmp_path / "a")
    assert back.value("lag.lift.time") == made.value("lag.lift.time")
    assert str(back.to_frame()) in str(back)
    code, found = run(capsys, "diff", str(tmp_path / "a"), str(tmp_path / "a"))
    assert code == 0
    assert any(row["name"].startswith("lag.lift.time") for row in found["rows"])
