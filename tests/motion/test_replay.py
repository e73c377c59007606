"""What was found on a moving arm, written into a model of it, makes MuJoCo move as the arm did on motions not seen."""

import json
from dataclasses import replace

import numpy as np
import pytest
from moved_arms import JOINTS, World, mjcf, record, urdf, written

from robolaser.cli import main
from robolaser.errors import RobotError
from robolaser.motion.log import MotionLog
from robolaser.motion.replay import replay

pytest.importorskip("mujoco", minversion="3.5")  # actuators have no delay before


def test_the_copy_follows_the_real_arm_and_the_original_does_not(tmp_path, capsys):
    world = World(feeds_forward=False, bandwidth=25.0, delay_s=0.03)
    seen = written(record(world, series=8, seconds=2.5, seed=3, rate_hz=50), tmp_path / "seen")
    unseen = written(record(world, series=2, seconds=8.0, seed=9), tmp_path / "unseen")
    stiff = "".join(f'<position joint="{name}" kp="4000" kv="40"/>' for name in JOINTS)
    mine = mjcf(World()).replace("<actuator>", f"<actuator>{stiff}").split("<motor")[0] + "</actuator></mujoco>"
    (tmp_path / "mine.xml").write_text(mine, encoding="utf-8")
    effects = ["--with", "lag", "--with", "dead_time", "--with", "droop"]
    assert main(["calibrate", str(seen), *effects, "--output", str(tmp_path / "numbers"), "--quiet"]) == 0
    asked = ["--into", str(tmp_path / "mine.xml"), "--output", str(tmp_path / "real.xml"), "--replay", str(unseen)]
    assert main(["export", str(tmp_path / "numbers"), *asked, "--json"]) == 0
    errors = json.loads(capsys.readouterr().out)["replay"]
    assert set(errors) == set(JOINTS)
    assert all(0.0 < one["promised_rad"] < one["before_rad"] for one in errors.values())
    assert sum(one["after_rad"] for one in errors.values()) < 0.5 * sum(one["before_rad"] for one in errors.values())


def test_a_copy_that_holds_commands_is_no_later_than_the_arm_that_held_them(tmp_path, capsys):
    driven = mjcf(World()).split("<actuator>")[0] + "<actuator>{}</actuator></mujoco>"
    real, mine = (
        driven.format("".join(f'<position joint="{name}" kp="40000" kv="{kv}"/>' for name in JOINTS))
        for kv in (4000, 1000)
    )
    (tmp_path / "mine.xml").write_text(mine, encoding="utf-8")
    log = written(held(real, record(World(), series=6, seconds=3.0, seed=3)), tmp_path / "log")
    assert main(["diagnose", str(log), "--output", str(tmp_path / "why"), "--quiet"]) == 0
    asked = ["--into", str(tmp_path / "mine.xml"), "--output", str(tmp_path / "real.xml"), "--replay", str(log)]
    assert main(["export", str(tmp_path / "why"), *asked, "--json"]) == 0
    for one in json.loads(capsys.readouterr().out)["replay"].values():
        assert one["after_rad"] < 0.1 * one["before_rad"]


def held(model: str, log: MotionLog) -> MotionLog:
    """A log of an arm in MuJoCo that is read, then told where to go until the fifth row after."""
    import mujoco  # noqa: PLC0415

    arm, readings = mujoco.MjModel.from_xml_string(model), np.empty_like(log.q)
    for rows in log.rows_of_runs:
        data = mujoco.MjData(arm)
        data.qpos[:] = log.command[rows.start]
        for row in range(rows.start, rows.stop):
            readings[row] = data.qpos
            if (row - rows.start) % 5 == 0:
                data.ctrl[:] = log.command[row]
            mujoco.mj_step(arm, data, 10)
    kept = np.concatenate([np.arange(rows.start, rows.stop, 5) for rows in log.rows_of_runs])
    noise = np.random.default_rng(0).normal(0.0, 1e-4, readings.shape)
    none = np.full_like(log.q, np.nan)
    return replace(log, q=readings + noise, tau=none, load=none).of_rows(np.isin(np.arange(len(log)), kept))


def test_a_log_without_a_driven_joint_is_refused(tmp_path, capsys):
    seen = written(record(World(), series=2, seconds=3.0, seed=3), tmp_path / "seen")
    (tmp_path / "arm.urdf").write_text(urdf(), encoding="utf-8")
    (tmp_path / "mine.xml").write_text("<mujoco><worldbody/></mujoco>", encoding="utf-8")
    assert main(["calibrate", str(seen), "--output", str(tmp_path / "numbers"), "--quiet"]) == 0
    asked = ["--into", str(tmp_path / "mine.xml"), "--output", str(tmp_path / "real.xml"), "--replay", str(seen)]
    assert main(["export", str(tmp_path / "numbers"), *asked]) == 1
    assert "no actuator" in capsys.readouterr().err


def test_no_copy_is_written_into_the_log_that_is_replayed(tmp_path, capsys):
    log = written(record(World(), series=1, seconds=1.0, seed=3), tmp_path / "log")
    (tmp_path / "mine.xml").write_text(mjcf(World()), encoding="utf-8")
    found = {"format": "robolaser-diagnosis/1", "kind": "motion", "effects": []}
    (tmp_path / "diagnosis.json").write_text(json.dumps(found), encoding="utf-8")
    asked = ["--into", str(tmp_path / "mine.xml"), "--output", str(log / "real.xml"), "--replay", str(log)]
    assert main(["export", str(tmp_path / "diagnosis.json"), *asked]) == 1
    assert "is an input of this command or is inside one" in capsys.readouterr().err


def test_an_actuator_of_a_tendon_takes_no_joint_s_commands(tmp_path):
    log = record(World(), series=1, seconds=1.0, seed=3)
    driven = "".join(f'<position joint="{name}" kp="4000" kv="40"/>' for name in JOINTS)
    arm = mjcf(World()).split("<actuator>")[0]
    arm += f'<tendon><fixed name="fingers"><joint joint="{JOINTS[-1]}" coef="1"/></fixed></tendon><actuator>{driven}'
    for name, more in (("arm", ""), ("hand", '<general tendon="fingers"/>')):
        (tmp_path / f"{name}.xml").write_text(f"{arm}{more}</actuator></mujoco>", encoding="utf-8")
    assert replay(tmp_path / "hand.xml", log) == replay(tmp_path / "arm.xml", log)


def test_a_driven_joint_that_was_never_read_has_no_error(tmp_path):
    log = record(World(), series=1, seconds=1.0, seed=3)
    driven = "".join(f'<position joint="{name}" kp="4000" kv="40"/>' for name in JOINTS)
    (tmp_path / "arm.xml").write_text(
        f"{mjcf(World()).split('<actuator>')[0]}<actuator>{driven}</actuator></mujoco>", encoding="utf-8"
    )
    q = log.q.copy()
    q[:, 0] = np.nan
    errors = replay(tmp_path / "arm.xml", replace(log, q=q))
    assert np.isnan(errors[JOINTS[0]])
    assert all(np.isfinite(errors[name]) for name in JOINTS[1:])


def test_a_simulation_that_diverges_is_refused(tmp_path, monkeypatch):
    monkeypatch.chdir(tmp_path)  # MuJoCo writes its log there
    driven = "".join(f'<position joint="{name}" kp="1e12"/>' for name in JOINTS)
    (tmp_path / "arm.xml").write_text(
        f"{mjcf(World()).split('<actuator>')[0]}<actuator>{driven}</actuator></mujoco>", encoding="utf-8"
    )
    with pytest.raises(RobotError, match="unstable"):
        replay(tmp_path / "arm.xml", record(World(), series=1, seconds=1.0, seed=3))
