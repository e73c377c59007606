"""`corrected.py`, without robolaser, must move as the model does."""

import subprocess
import sys
from dataclasses import replace
from functools import cache
from importlib.util import module_from_spec, spec_from_file_location
from types import SimpleNamespace

import numpy as np
import pytest
from calibrated import finished, stripe

import robolaser
from robolaser import find_robot
from robolaser.export.python_module import OF_THE_ARM, corrected_module
from robolaser.model.effects.effect import CandidateEffect
from robolaser.model.forward_model import Model
from robolaser.simulation import CellOptions, simulate

OF_ARMS = [effect for effect in robolaser.EFFECTS if effect.stage in OF_THE_ARM]
AT_REST = [effect for effect in OF_ARMS if effect.name != "latency"]
ASKED = """
poses = {"T": corrected.forward(given.pop("q"), **given)}
q = [0.3, -0.9, 1.1, 0.4, -0.7, 0.2][: len(corrected.JOINTS)]
poses["back"] = corrected.forward(corrected.joints_for(corrected.forward(q), start=np.array(q) + 0.1))
poses["there"] = corrected.forward(q)
poses["commanded"] = corrected.forward(corrected.corrected_targets(q))
poses["nominal"] = corrected.nominal(q)
"""
ALONE = f"""
import sys
sys.modules["robolaser"] = None  # importing it fails
import numpy as np
import corrected
given = dict(np.load("given.npz"))
{ASKED}
np.savez("poses.npz", **poses)
"""

TYPED = """
from dataclasses import dataclass
from robolaser.model.effects.effect import Effect, parameter
from robolaser.model.stages import Stage
@dataclass(frozen=True)
class Stuck(Effect):
    name, title, reference, stage = "stuck", "stuck", "nowhere", Stage.JOINTS
    share: object = parameter(unit="", bound=1.0, prior_scale=1e-3)
    def apply(self, q, run, /):
        return q * (1 + self.share[:, None, None])
"""


@cache
def made(warm=False):
    dataset = simulate(find_robot("ur5"), kind="point", poses=8, options=CellOptions(speed=0.1), seed=3).dataset
    if not warm:
        return dataset
    return replace(dataset, poses=replace(dataset.poses, temperature_c=np.linspace(21.0, 34.0, 8) ** 1.1))


def found(effects, dataset):
    """A calibration with each effect in the middle of the arm, its parameters anywhere."""
    chosen = []
    for effect in effects:
        places = effect.locations(dataset)
        chosen.append(CandidateEffect(effect, places[len(places) // 2]))
    model, rng = Model(dataset, tuple(chosen)), np.random.default_rng(5)
    x = model.parameters.nominal.copy()
    for one in chosen:
        for each in one.effect.amplitudes():
            sign = 1 if each.lower >= 0 else rng.choice([-1, 1])
            x[model.parameters.names.index(one.key(each.name))] = sign * rng.uniform(0.5, 2) * each.prior_scale
        for name, value in zip(one.effect.nonlinear_parameters(), one.effect.grid(dataset, one.where)[-1], strict=True):
            x[model.parameters.names.index(one.key(name.name))] = value
    return finished(model, x)


def alone(calibration, folder, given):
    """What `corrected.py` says where there is no robolaser."""
    (folder / "corrected.py").write_text(corrected_module(calibration), encoding="utf-8")
    np.savez(folder / "given.npz", **given)
    subprocess.run([sys.executable, "-W", "error", "-c", ALONE], cwd=folder, check=True)
    return np.load(folder / "poses.npz")


def here(calibration, folder, given):
    """The same without a process of its own."""
    names = {"np": np, "corrected": SimpleNamespace(**loaded(calibration)), "given": given.copy()}
    exec(ASKED, names)
    return names["poses"]


@pytest.mark.parametrize(
    ("effects", "warm", "where"),
    [
        *(pytest.param([one], False, here, id=one.name) for one in OF_ARMS),
        pytest.param(AT_REST, False, alone, id="all by time"),
        pytest.param(AT_REST, True, here, id="all by temperature"),
    ],
)
def test_corrected_py_has_every_effect_of_the_arm_as_the_model_has_it(effects, warm, where, tmp_path):
    calibration = found(effects, made(warm))
    model, run = calibration.model, calibration.model.run
    wanted = model.flange(model.parameters.values(calibration.x[None]))[0]
    *before, last = np.concatenate(run.paths)
    given = {"q": run.q[last][None], "before": run.q[before][:, None], "velocity": run.qd[last][None],
             "time_s": run.time_s[last] - run.time_s.min()}  # fmt: skip
    if warm:
        given["temperature_c"] = run.poses.temperature_c[last]
    poses = where(calibration, tmp_path, given)
    np.testing.assert_allclose(poses["T"][0], wanted[last], rtol=0, atol=1e-9)
    assert np.abs(wanted - run.flange).max() > 1e-6
    np.testing.assert_allclose(poses["back"], poses["there"], rtol=0, atol=1e-9)
    np.testing.assert_allclose(poses["commanded"], poses["nominal"], rtol=0, atol=1e-9)


def test_poses_in_a_batch_are_those_of_one_after_the_other(tmp_path):
    module, q = loaded(found(AT_REST, made())), made().poses.q
    one_by_one = [module["forward"](q[i], before=q[i - 1], time_s=made().poses.time_s[i]) for i in range(1, len(q))]
    batch = module["forward"](q[1:], before=q[:-1], time_s=made().poses.time_s[1:])
    np.testing.assert_allclose(batch, one_by_one, rtol=0, atol=1e-12)


def test_corrected_py_is_loaded_from_its_path_without_being_registered(tmp_path):
    (tmp_path / "corrected.py").write_text(corrected_module(found(AT_REST[:3], made())), encoding="utf-8")
    spec = spec_from_file_location("arm_of_a_path", tmp_path / "corrected.py")
    module = module_from_spec(spec)
    spec.loader.exec_module(module)
    np.testing.assert_allclose(module.corrected_targets([0.1] * 6), [0.1] * 6, atol=0.1)


def test_what_is_left_out_of_a_pose_is_said():
    text = corrected_module(found(OF_ARMS, made(warm=True)))
    module = {}
    exec(text, module)
    needs = {name.partition(" ")[0]: needed for name, needed in module["LEAVES_OUT"].items()}
    assert needs == {
        "backlash": "before",
        "settling": "before",
        "latency": "velocity",
        **dict.fromkeys(("base_shift", "base_drift", "mount_shift", "tool_drift"), "time_s"),
        "thermal_drift": "temperature_c",
    }
    assert "Left out of a pose without temperature_c: thermal_drift" in module["__doc__"]


def test_an_effect_whose_source_nobody_has_is_said_to_be_missing():
    names = {}
    exec(TYPED, names)
    text = corrected_module(found([names["Stuck"]], made()))
    assert "Not contained: " in text
    assert "Stuck" not in text


def test_corrected_py_has_the_sensor():
    calibration = found([], made())
    module = loaded(calibration)
    tool = [calibration.value(f"tool.0.{part}") for part in "xyz"]
    q = [0.1] * 6
    np.testing.assert_allclose(module["sensor"](q)["tool_0"][:3, 3], (module["forward"](q) @ [*tool, 1.0])[:3])


def test_every_pose_that_the_arm_reaches_is_found_without_a_start():
    (drifts,) = (effect for effect in OF_ARMS if effect.name == "thermal_drift")
    module = loaded(found((drifts,), made()))
    q, time_s = np.random.default_rng(2).uniform(-2.0, 2.0, (12, 6)), np.linspace(0.0, 7.0, 12)
    T = module["forward"](q, time_s=time_s)
    np.testing.assert_allclose(module["forward"](module["joints_for"](T, time_s=time_s), time_s=time_s), T, atol=1e-6)


def test_without_a_robot_there_is_no_corrected_arm():
    assert corrected_module(stripe()) is None


def loaded(calibration):
    module = {}
    exec(corrected_module(calibration), module)
    return module
