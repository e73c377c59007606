"""The gap between MuJoCo and the cell before and after a correction: fitted to half of the poses, tested on the rest.

MuJoCo alone computes the flange poses of `robot_corrected.xml`; base, tools and sockets are re-fitted to them.
"""

import argparse
from collections.abc import Sequence
from dataclasses import replace
from pathlib import Path
from typing import Any

import mujoco
import numpy as np

from robolaser import Plan, calibrate, find_robot, load
from robolaser.arrays import Array
from robolaser.data.dataset import Dataset, Poses
from robolaser.data.stated_noise import Noise
from robolaser.export.mjcf import mjcf
from robolaser.model.forward_model import Model
from robolaser.simulation import simulate

ARM = ("joint_offset", "link_geometry")
REAL = (("ur10-tracker-b", ARM), ("ur10-tracker-b", (*ARM, "joint_compliance")), ("mukca-panda_1", ARM))
SIMULATED = {
    "ur5": {"joint_compliance:shoulder_lift_joint": 5e-5, "joint_offset:elbow_joint": 2e-3},
    "panda": {"joint_coupling:panda_joint6": 3e-3, "joint_offset:panda_joint4": 3e-3},
    "ur10": {"backlash:shoulder_lift_joint": 2e-3, "joint_offset:shoulder_lift_joint": 2e-3},
}
WAY_S, REST_S = 4.0, 0.3


def replayed(text: str, flange: str, joints: Sequence[str], q: Array) -> Array:
    """T_base_flange of an arm at rest in MuJoCo with its drives at given angles, (n, 4, 4)."""
    model = mujoco.MjModel.from_xml_string(text)
    data = mujoco.MjData(model)
    columns = [model.joint(name).qposadr[0] for name in joints]
    model.dof_armature[columns] = 1e6
    way_s = WAY_S if model.ntendon else 0.0  # only backlash depends on the previous pose
    rest = range(round(REST_S / model.opt.timestep) if model.nv > len(columns) else 0)
    out, body, way = np.tile(np.eye(4), (len(q), 1, 1)), model.body(flange).id, round(way_s / model.opt.timestep)
    data.qpos[columns] = q[0]
    for T, before, goal in zip(out, [q[0], *q], q, strict=False):
        shares = (1.0 - np.cos(np.pi * np.arange(1, way + 1) / max(way, 1))) / 2
        for now in [*(before + share * (goal - before) for share in shares), *(goal for _ in rest)]:
            _step(model, data, columns, now, moves=way > 0)
        data.qpos[columns] = goal
        mujoco.mj_forward(model, data)
        T[:3, :3], T[:3, 3] = data.xmat[body].reshape(3, 3), data.xpos[body]
    return out


def _step(model: Any, data: Any, columns: Sequence[int], now: Array, *, moves: bool) -> None:
    if moves:
        data.qvel[columns] = (now - data.qpos[columns]) / model.opt.timestep
    else:
        data.qpos[columns], data.qvel[columns] = now, 0.0
    mujoco.mj_step(model, data)


def gap_mm(dataset: Dataset, flange: Array, chosen: Array) -> float:
    """RMS error of points or sockets with given flange poses, which count as measured [mm]."""
    part = dataset.of_poses(chosen)
    poses = Poses(part.poses.names, T_base_flange=flange[chosen])
    return 1e3 * calibrate(replace(part, robot=None, poses=poses)).rms_m


def row(name: str, dataset: Dataset, effects: Sequence[str]) -> str:
    """A row of the table: agreement of MuJoCo with the model, and its gap to the cell before and after."""
    robot, q = dataset.arm
    number = np.arange(len(q))
    others = number >= len(q) / 2 if "backlash" in str(effects) else number % 2 == 1  # backlash needs contiguous paths
    fitted = calibrate(dataset.of_poses(~others), Plan(effects=tuple(effects)))
    nominal = calibrate(dataset.of_poses(~others))
    order = Model(dataset, fitted.model.effects).run.order if dataset.poses.time_s is not None else np.arange(len(q))
    before, after = np.empty((2, len(q), 4, 4))
    before[order] = replayed(str(mjcf(nominal)), robot.flange, robot.joints, q[order])
    after[order] = replayed(str(mjcf(fitted)), robot.flange, robot.joints, q[order])
    values = fitted.model.parameters.values(fitted.x[None])
    wanted = Model(dataset, fitted.model.effects).flange(values)[0]
    size = 1e3 * np.linalg.norm((wanted - dataset.flange())[:, :3, 3], axis=-1).max()
    away = 1e3 * np.linalg.norm((after - wanted)[order[1:], :3, 3], axis=-1).max()
    gaps = [gap_mm(dataset, flange, others) for flange in (before, after, wanted)]
    named = ", ".join(dict.fromkeys(effect.partition(":")[0] for effect in effects))
    return f"| {name} | {named} | {size:.2f} | {away:.5f} | {gaps[0]:.3f} | {gaps[1]:.3f} | {gaps[2]:.3f} |"


def main() -> None:
    options = argparse.ArgumentParser(description=__doc__)
    options.add_argument("data", type=Path, help="folder of the published data sets")
    data = options.parse_args().data
    print("| arm | effects | displacement [mm] | MuJoCo against model [mm] | before [mm] | after [mm] | model [mm] |")
    print("|---|---|---|---|---|---|---|")
    for robot, effects in SIMULATED.items():
        made = simulate(find_robot(robot), kind="point", poses=60, noise=Noise(point_m=2e-5), effects=effects, seed=1)
        print(row(f"{robot}, simulated", made.dataset, tuple(effects)), flush=True)
    for name, chosen in REAL:
        print(row(name, load(data / name), chosen), flush=True)


if __name__ == "__main__":
    main()
