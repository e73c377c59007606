"""The pictures of the page on effects: what each effect leaves once the ordinary parameters were fitted without it.

Run from the repository's root: .venv/bin/python docs/pictures/effects.py [NAME]...
"""

import sys
from collections.abc import Callable
from pathlib import Path

import numpy as np
from matplotlib.axes import Axes
from matplotlib.figure import Figure

from robolaser import Plan, calibrate, find_robot
from robolaser.algorithms.registry import POLISH_ONLY
from robolaser.arrays import Array
from robolaser.data.stated_noise import Noise
from robolaser.model.effects.effect import CandidateEffect
from robolaser.model.effects.joint_offset import JointOffset
from robolaser.model.forward_model import Model
from robolaser.model.sensors.placements import motion
from robolaser.simulation import Simulated, simulate

FOLDER = Path(__file__).parent / "effects"
INK, BLUE, RED = "#3c434a", "#2b6cb1", "#c0492b"
SIZE = (4.6, 2.4)
DOTS = {"s": 9, "linewidths": 0, "alpha": 0.8}
POSES, POINTS = 70, 6
NOISE = Noise(pixel_px=0.02)

Draw = Callable[[Axes, Simulated, Array], None]


def left_over(made: Simulated) -> Array:
    """Target less predicted point after a calibration without the effect, (m, 3) [mm]; of a camera (m, 2)."""
    found = calibrate(made.dataset, Plan(algorithm=POLISH_ONLY, seed=1))
    model = Model(made.dataset)
    x = np.array([[found.value(name) for name in model.parameters.names]])
    return 1e3 * model.in_metres(x[0], model.residuals(x)[0])


def as_angle(made: Simulated, errors: Array, joint: str) -> Array:
    """The turn of one joint that would explain most of each error, (m,) [mrad]."""
    model = Model(made.dataset, (CandidateEffect(JointOffset, joint),))
    x = np.repeat(model.parameters.nominal[None], 2, axis=0)
    x[:, -1] = (-1e-4, 1e-4)
    low, high = model.residuals(x)
    slope = (high - low) / 2e-4
    return -(errors * slope).sum(axis=1) / (slope**2).sum(axis=1)


def per_pose(made: Simulated, values: Array) -> Array:
    """Means over the rows of each pose, (n, ...)."""
    pose = made.dataset.points.pose
    return np.stack([values[pose == i].mean(axis=0) for i in range(len(made.dataset.poses))])


def turns(ax: Axes, made: Simulated, errors: Array, joint: str) -> Array:
    """Errors as turns of a joint, (n,) [mrad], the axis named and zero on it."""
    ax.axhline(0, color=INK, linewidth=0.7)
    ax.set_ylabel(f"error as a turn\nof {spoken(joint)} [mrad]")
    return per_pose(made, as_angle(made, errors, joint))


def spoken(name: str) -> str:
    """A joint's or an effect's name as one says it."""
    return name.replace("_", " ")


def over_angle(joint: str, of: str = "") -> Draw:
    """Errors as turns of a joint, over its angle or that of another one."""

    def draw(ax: Axes, made: Simulated, errors: Array) -> None:
        angle = np.degrees(made.dataset.poses.q[:, made.dataset.robot.joints.index(of or joint)])
        ax.scatter(angle, turns(ax, made, errors, joint), color=BLUE, **DOTS)
        ax.set_xlabel(f"angle of {spoken(of or joint)} [°]")

    return draw


def over_last_move(joint: str) -> Draw:
    """Errors as turns of a joint, over its last move."""

    def draw(ax: Axes, made: Simulated, errors: Array) -> None:
        q, run = made.dataset.poses.q[:, made.dataset.robot.joints.index(joint)], Model(made.dataset).run
        order = np.concatenate(run.paths)
        move = np.empty(len(q))
        move[order] = np.degrees(np.diff(q[order], prepend=q[order][0]))
        ax.scatter(move, turns(ax, made, errors, joint), color=BLUE, **DOTS)
        ax.set_xlabel(f"last move of {spoken(joint)} [°]")

    return draw


def over_torque(joint: str) -> Draw:
    """Errors as turns of a joint, over what it bears."""

    def draw(ax: Axes, made: Simulated, errors: Array) -> None:
        borne = Model(made.dataset).run.loads.gravity_torques[:, made.dataset.robot.joints.index(joint)]
        ax.scatter(borne, turns(ax, made, errors, joint), color=BLUE, **DOTS)
        ax.set_xlabel(f"gravity torque on {spoken(joint)} [Nm]")

    return draw


def by_approach(joint: str) -> Draw:
    """Errors as turns of a joint, over its angle, one colour for each way it came."""

    def draw(ax: Axes, made: Simulated, errors: Array) -> None:
        column = made.dataset.robot.joints.index(joint)
        way = Model(made.dataset).run.approach[:, column]
        angle, turn = np.degrees(made.dataset.poses.q[:, column]), turns(ax, made, errors, joint)
        for sign, colour, word in ((1, BLUE, "from below"), (-1, RED, "from above")):
            ax.scatter(angle[way == sign], turn[way == sign], color=colour, label=word, **DOTS)
        key(ax)
        ax.set_xlabel(f"angle of {spoken(joint)} [°]")

    return draw


def key(ax: Axes) -> None:
    """The legend, above the chart where no mark is."""
    ax.legend(
        fontsize=7, frameon=False, ncols=3, loc="lower right", bbox_to_anchor=(1, 0.96), handletextpad=0, borderpad=0
    )


def over_run(ax: Axes, made: Simulated, errors: Array) -> None:
    """Errors along the base's axes over the run."""
    mean = per_pose(made, errors)
    for i, (name, colour) in enumerate(zip("xyz", (BLUE, RED, INK), strict=True)):
        ax.scatter(made.dataset.poses.time_s / 60, mean[:, i], color=colour, label=name, **DOTS)
    key(ax)
    ax.set_xlabel("time [min]")
    ax.set_ylabel("error, base's\naxes [mm]")


def across_view_over_run(ax: Axes, made: Simulated, errors: Array) -> None:
    """A camera's errors across its view over the run."""
    for name, colour, mean in zip("uv", (BLUE, RED), per_pose(made, errors).T, strict=True):
        ax.scatter(made.dataset.poses.time_s / 60, mean, color=colour, label=name, **DOTS)
    key(ax)
    ax.set_xlabel("time [min]")
    ax.set_ylabel("error along the\nimage's axes [mm]")


def in_base(made: Simulated, vectors: Array) -> Array:
    """A tracker's vectors along the base's axes, (m, 3)."""
    values = {name: np.array([value]) for name, value in made.truth.items()}
    return vectors @ motion(values, "base")[0, :3, :3]


def in_base_over_run(ax: Axes, made: Simulated, errors: Array) -> None:
    """A tracker's errors along the base's axes over the run."""
    over_run(ax, made, in_base(made, errors))


def over_reach(ax: Axes, made: Simulated, errors: Array) -> None:
    """Errors in height over the horizontal reach of the flange."""
    reach = np.linalg.norm(made.dataset.flange()[:, :2, 3], axis=1)
    ax.axhline(0, color=INK, linewidth=0.7)
    ax.scatter(reach, per_pose(made, in_base(made, errors))[:, 2], color=BLUE, **DOTS)
    ax.set_xlabel("horizontal reach [m]")
    ax.set_ylabel("error in height\n[mm]")


def over_twist(joint: str) -> Draw:
    """Errors across the plane of the link before a joint and the flange, over the moment about that link's line."""

    def draw(ax: Axes, made: Simulated, errors: Array) -> None:
        run, robot = Model(made.dataset).run, made.dataset.robot
        load, at = run.loads.of_link(joint), robot.chain.index(robot.joints.index(joint))
        near, far = (run.loads.joint_frames[:, i, :3, 3] for i in (at - 1, at))
        across = np.cross(far - near, made.dataset.flange()[:, :3, 3] - far)
        across /= np.linalg.norm(across, axis=1)[:, None]
        moment = load.moment(np.ones((1, 1, 1)), np.zeros((1, 1, 1)))[0] @ (load.link / np.linalg.norm(load.link))
        ax.axhline(0, color=INK, linewidth=0.7)
        ax.scatter(moment, (per_pose(made, in_base(made, errors)) * across).sum(axis=1), color=BLUE, **DOTS)
        ax.set_xlabel(f"moment about the link before {spoken(joint)} [Nm]")
        ax.set_ylabel("error across\nthe arm [mm]")

    return draw


def in_flange(made: Simulated, errors: Array) -> Array:
    """Errors along the flange's axes, (m, 3)."""
    of_base = in_base(made, errors) if "base.x" in made.truth else errors
    return np.einsum("mba,mb->ma", made.dataset.flange()[made.dataset.points.pose, :3, :3], of_base)


def in_flange_over_run(ax: Axes, made: Simulated, errors: Array) -> None:
    """Errors along the flange's axes over the run."""
    over_run(ax, made, in_flange(made, errors))
    ax.set_ylabel("error, flange's\naxes [mm]")


def over_attitude(ax: Axes, made: Simulated, errors: Array) -> None:
    """Errors along two of the flange's axes, each over gravity along it."""
    run, mean = Model(made.dataset).run, per_pose(made, in_flange(made, errors))
    for i, (name, colour) in enumerate(zip("xy", (BLUE, RED), strict=True)):
        ax.scatter(run.gravity_in_flange[:, i], mean[:, i], color=colour, label=f"along {name}", **DOTS)
    key(ax)
    ax.set_xlabel("direction of gravity in the flange frame, x or y part")
    ax.set_ylabel("error, flange's\naxes [mm]")


def over_distance(ax: Axes, made: Simulated, errors: Array) -> None:
    """Errors away from the middle of all points, over the distance from it."""
    arm = made.dataset.points.xyz - made.dataset.points.xyz.mean(axis=0)
    length = np.linalg.norm(arm, axis=1)
    ax.axhline(0, color=INK, linewidth=0.7)
    ax.scatter(length, (errors * arm).sum(axis=1) / length, color=BLUE, **DOTS)
    ax.set_xlabel("distance from the middle of all points [m]")
    ax.set_ylabel("error away\nfrom it [mm]")


def in_camera_over_run(ax: Axes, made: Simulated, errors: Array) -> None:
    """Errors along the camera's axes over the run."""
    over_run(ax, made, in_camera(made, errors))
    ax.set_ylabel("error, camera's\naxes [mm]")


def in_camera(made: Simulated, errors: Array) -> Array:
    """Errors along the camera's axes, (m, 3)."""
    model = Model(made.dataset, made.effects)
    values = {name: np.array([value]) for name, value in made.truth.items()}
    perturb = model.perturb(values)
    T = (model.flange(values, perturb) @ model.blocks.sensor.in_cell(values, perturb).mount)[0]
    return np.einsum("mba,mb->ma", T[made.dataset.points.pose, :3, :3], errors)


def along_stripe(component: int) -> Draw:
    """Errors along one of the camera's axes, over the place along the stripe."""

    def draw(ax: Axes, made: Simulated, errors: Array) -> None:
        ax.scatter(made.dataset.points.pixel[:, 0], in_camera(made, errors)[:, component], color=BLUE, **DOTS)
        ax.set_xlabel("place along the stripe, image u [px]")
        ax.set_ylabel(f"error, camera's\n{'xyz'[component]} [mm]")

    return draw


def over_tilt(ax: Axes, made: Simulated, errors: Array) -> None:
    """Height errors over the tilt of the surface."""
    ax.scatter(np.degrees(np.arctan(Model(made.dataset).run.tilt)), errors[:, 2], color=BLUE, **DOTS)
    ax.set_xlabel("tilt of the surface across the stripe [°]")
    ax.set_ylabel("error, height [mm]")


def over_speed(ax: Axes, made: Simulated, errors: Array) -> None:
    """Errors along the motion, over the speed of each point."""
    poses, robot = made.dataset.poses, made.dataset.robot
    model = Model(made.dataset)
    x = np.array([made.truth[name] for name in model.parameters.names])[None]
    now = model.residuals(x)[0]
    step = 1e-4
    ahead = robot.forward((poses.q + step * poses.qd)[None]) @ np.linalg.inv(made.dataset.flange())
    shown = (made.dataset.points.xyz - now)[..., None]
    T = ahead[0][made.dataset.points.pose]
    velocity = ((T[:, :3, :3] @ shown)[..., 0] + T[:, :3, 3] - shown[..., 0]) / step
    speed = np.linalg.norm(velocity, axis=1)
    ax.scatter(1e3 * speed, (errors * velocity).sum(axis=1) / speed, color=BLUE, **DOTS)
    ax.set_xlabel("speed of the point at the exposure [mm/s]")
    ax.set_ylabel("error along\nthe motion [mm]")


def as_arrows(ax: Axes, made: Simulated, errors: Array) -> None:
    """Errors in the target's plane as arrows."""
    xyz = made.dataset.points.xyz
    every = slice(None, None, 2)
    ax.quiver(*xyz[every, :2].T, *errors[every, :2].T, color=BLUE, angles="xy", width=0.006, scale=30)
    ax.set_aspect("equal")
    ax.set_xlabel("x on the target [m]")
    ax.set_ylabel("y [m]")


def as_heights(ax: Axes, made: Simulated, errors: Array) -> None:
    """Errors in height over the target."""
    xyz = made.dataset.points.xyz
    most = np.abs(errors[:, 2]).max()
    drawn = ax.scatter(xyz[:, 0], xyz[:, 1], c=errors[:, 2], cmap="coolwarm", vmin=-most, vmax=most, **DOTS)
    bar = ax.figure.colorbar(drawn, ax=ax)
    bar.set_label("height [mm]", size=8, color=INK)
    bar.ax.tick_params(labelsize=7)
    ax.set_aspect("equal")
    ax.set_xlabel("x on the target [m]")
    ax.set_ylabel("y [m]")


def by_row(ax: Axes, made: Simulated, errors: Array) -> None:
    """Sizes of errors, row by row."""
    length = np.linalg.norm(errors, axis=1)
    colours = np.where(np.isin(np.arange(len(length)), made.gross), RED, BLUE)
    ax.scatter(np.arange(len(length)), length, c=colours, **DOTS)
    ax.set_yscale("log")
    ax.set_xlabel("row of points.csv")
    ax.set_ylabel("error [mm]")


PICTURES: dict[str, tuple[dict[str, float], Draw]] = {
    "joint_offset": ({"joint_offset:joint_3": 3e-3}, over_angle("joint_3")),
    "link_geometry": ({"link_geometry:joint_3": 2e-3, "link_geometry:joint_3.turn_x": 2e-3}, over_angle("joint_2")),
    "joint_compliance": ({"joint_compliance:joint_3": 3e-4}, over_torque("joint_3")),
    "backlash": ({"backlash:joint_3": 1.2e-3}, by_approach("joint_3")),
    "transmission_error": ({"transmission_error:joint_2": 6e-4, "transmission_error:joint_2.cycles": 12.0},
                           over_angle("joint_2")),
    "encoder_scale": ({"encoder_scale:joint_3": 2e-3}, over_angle("joint_3")),
    "encoder_eccentricity": ({"encoder_eccentricity:joint_1": 1e-3, "encoder_eccentricity:joint_1.cosine": 1e-3},
                             over_angle("joint_1")),
    "settling": ({"settling:joint_3": 2e-3}, over_last_move("joint_3")),
    "joint_coupling": ({"joint_coupling:joint_4": 2e-3, "joint_coupling:joint_4.other": 2.0},
                       over_angle("joint_4", of="joint_2")),
    "link_compliance": ({"link_compliance:elbow_joint": 2e-5, "link_compliance:elbow_joint.twist": 2e-4},
                        over_twist("elbow_joint")),
    "base_shift": ({"base_shift:base": 1e-3, "base_shift:base.z": -5e-4, "base_shift:base.moment": 0.6}, over_run),
    "base_drift": ({"base_drift:base": 5e-4, "base_drift:base.z": -1e-3, "base_drift:base.settling": 1.5},
                   in_base_over_run),
    "thermal_drift": ({"thermal_drift:joint_3": 2e-3}, over_run),
    "hand_eye_drift": ({"hand_eye_drift:hand_eye": 1e-3, "hand_eye_drift:hand_eye.settling": 3.0}, in_camera_over_run),
    "base_compliance": ({"base_compliance:base": 5e-5}, over_reach),
    "hand_eye_sag": ({"hand_eye_sag:hand_eye": 1e-3, "hand_eye_sag:hand_eye.moment_z": 2e-3}, over_attitude),
    "arm_scale": ({"arm_scale:base": 1e-3}, over_distance),
    "tool_sag": ({"tool_sag:tool": 5e-4}, over_attitude),
    "tool_drift": ({"tool_drift:tool": 5e-4, "tool_drift:tool.z": -1e-3, "tool_drift:tool.settling": 3.0},
                   in_flange_over_run),
    "mount_shift": ({"mount_shift:tool": 5e-4, "mount_shift:tool.z": -1e-3, "mount_shift:tool.moment": 0.6},
                    in_flange_over_run),
    "latency": ({"latency:timing": 0.02}, over_speed),
    "radial_distortion": ({"radial_distortion:camera": 2e8}, along_stripe(1)),
    "tangential_distortion": ({"tangential_distortion:camera.p_2": 1.0}, along_stripe(1)),
    "focus_breathing": ({"focus_breathing:camera": 5e-2}, along_stripe(0)),
    "camera_drift": ({"camera_drift:camera.x": 2.0, "camera_drift:camera.y": -1.0, "camera_drift:camera.settling": 3.0},
                     across_view_over_run),
    "laser_curvature": ({"laser_curvature:laser": 0.08}, along_stripe(0)),
    "laser_roll": ({"laser_roll:laser": 0.02}, along_stripe(0)),
    "laser_drift": ({"laser_drift:laser": 1e-3}, in_camera_over_run),
    "stripe_bias": ({"stripe_bias:laser": 1.0}, over_tilt),
    "target_scale": ({"target_scale:target": 5e-3}, as_arrows),
    "target_stretch": ({"target_stretch:target": 5e-3}, as_arrows),
    "target_warp": ({"target_warp:target": 1e-3, "target_warp:target.yy": -1e-3}, as_heights),
    "tracker_scale": ({"tracker_scale:measuring_system": 1e-3}, over_distance),
    "outliers": ({"outliers": 0.03}, by_row),
}  # fmt: skip
"""For each effect what is put into the cell, a little more than usual, and the view in which it shows."""


TRACKED = {"link_compliance": "ur5", "base_compliance": "ur5", "tracker_scale": "ur5", "arm_scale": "ur5",
           "tool_sag": "ur5", "tool_drift": "ur5", "mount_shift": "ur5", "base_drift": "ur5"}  # fmt: skip
"""Effects that a scanner on the plane arm of a SCORBOT would not show: a tracker before another arm."""


def main(names: list[str]) -> None:
    FOLDER.mkdir(exist_ok=True)
    for name in names or PICTURES:
        effects, draw = PICTURES[name]
        kind = {"kind": "point", "points": 3} if name in TRACKED else {"points": POINTS}
        kind |= {"kind": "camera"} if draw is across_view_over_run else {}
        arm = find_robot(TRACKED.get(name, "scorbot_er7"))
        made = simulate(arm, poses=POSES, noise=NOISE, effects=effects, seed=4, **kind)
        errors = left_over(made)
        figure = Figure(figsize=SIZE, dpi=96, layout="constrained", facecolor="white")
        ax = figure.subplots()
        draw(ax, made, errors)
        ax.spines[["top", "right"]].set_visible(False)
        ax.grid(color="#e6e9ed", linewidth=0.7)
        ax.set_axisbelow(True)
        ax.tick_params(colors=INK, length=0, labelsize=7)
        ax.xaxis.label.set(color=INK, fontsize=8)
        ax.yaxis.label.set(color=INK, fontsize=8)
        rms = np.sqrt((errors**2).sum(axis=1).mean())
        ax.set_title(f"{spoken(name).capitalize()}: {rms:.2f} mm RMS", fontsize=8, color=INK, loc="left")
        figure.savefig(FOLDER / f"{name}.png")


if __name__ == "__main__":
    main(sys.argv[1:])
