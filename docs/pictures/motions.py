"""The pictures of the effects on moving arms: what each leaves where an ideal arm is expected.

Run from the repository's root: .venv/bin/python docs/pictures/motions.py [NAME]...
"""

import sys
from collections.abc import Callable
from pathlib import Path

import numpy as np
from effects import BLUE, DOTS, INK, RED, SIZE, key, spoken
from matplotlib.axes import Axes
from matplotlib.figure import Figure

from robolaser import find_robot
from robolaser.motion.log import MotionLog
from robolaser.motion.quantities import Quantities, quantities
from robolaser.motion.simulation import simulate_motion

FOLDER = Path(__file__).parent / "motions"
LIFT, ELBOW = 1, 2  # columns of the joints that are shown
EVERY = 12  # of the rows
RESTS = 1  # a run from rest to rest

Draw = Callable[[Axes, MotionLog], None]


def along_time(joint: int, run: int = RESTS, seconds: tuple[float, float] = (3.6, 7.6)) -> Draw:
    """Command and reading over a few seconds."""

    def draw(ax: Axes, log: MotionLog) -> None:
        rows = log.rows_of_runs[run]
        time = log.time_s[rows]
        shown = (time >= seconds[0]) & (time <= seconds[1])
        for values, colour, word in ((log.command, INK, "command"), (log.q, RED, "reading")):
            ax.plot(time[shown], np.degrees(values[rows, joint][shown]), color=colour, linewidth=1.3, label=word)
        key(ax)
        ax.set_xlabel("time [s]")
        ax.set_ylabel("joint angle [°]")

    return draw


def tracking(joint: int, over: Callable[[MotionLog], np.ndarray], words: str, *, ways: bool = False) -> Draw:
    """Reading less command over something, one colour for each direction of motion where asked."""

    def draw(ax: Axes, log: MotionLog) -> None:
        error, x = np.degrees(log.q - log.command)[::EVERY, joint], over(log)[::EVERY]
        way = np.sign(np.gradient(log.command[:, joint]))[::EVERY]
        dots(ax, x, error, way if ways else None)
        ax.set_xlabel(words)
        ax.set_ylabel("reading less\ncommand [°]")

    return draw


def rows_of(kind: str, joint: int, over: Callable[[Quantities], np.ndarray], words: str, *, ways: bool = False) -> Draw:
    """Torques less inverse dynamics, or one encoder less the other, over something."""

    def draw(ax: Axes, log: MotionLog) -> None:
        of = quantities(log, kind)
        error = (of.measured - of.rigid if kind == "torque" else np.degrees(of.measured))[::3, joint]
        dots(ax, over(of)[::3], error, np.sign(of.speed[::3, joint]) if ways else None)
        ax.set_xlabel(words)
        ax.set_ylabel("torque less inverse\ndynamics [Nm]" if kind == "torque" else "load less motor [°]")

    return draw


def dots(ax: Axes, x: np.ndarray, y: np.ndarray, way: np.ndarray | None) -> None:
    """Zero, and a dot for each row."""
    ax.axhline(0, color=INK, linewidth=0.7)
    if way is None:
        ax.scatter(x, y, color=BLUE, **{**DOTS, "s": 4})
        return
    for sign, colour, word in ((1, BLUE, "upwards"), (-1, RED, "downwards")):
        ax.scatter(x[way == sign], y[way == sign], color=colour, label=word, **{**DOTS, "s": 4})
    key(ax)


def angle(joint: int) -> Callable[[Quantities], np.ndarray]:
    return lambda of: np.degrees(of.q[:, joint])


def speed(joint: int) -> Callable[[Quantities], np.ndarray]:
    return lambda of: np.degrees(of.speed[:, joint])


def torque(joint: int) -> Callable[[Quantities], np.ndarray]:
    return lambda of: of.rigid[:, joint]


COMMAND = "commanded angle [°]"
ANGLE, SPEED, TORQUE = "joint angle [°]", "speed [°/s]", "torque of the rigid arm [Nm]"


def command_of(joint: int) -> Callable[[MotionLog], np.ndarray]:
    return lambda log: np.degrees(log.command[:, joint])


def gravity_on(joint: int) -> Callable[[MotionLog], np.ndarray]:
    return lambda log: log.robot.gravity_torques(log.command)[:, joint]


PICTURES: dict[str, tuple[dict[str, float], Draw]] = {
    "clock_shift": ({"clock_shift:timing": -0.08}, along_time(ELBOW)),
    "dead_time": ({"dead_time:elbow_joint": 0.12}, along_time(ELBOW)),
    "lag": ({"lag:elbow_joint": 0.12}, along_time(ELBOW)),
    "offset": ({"offset:elbow_joint": 0.01}, tracking(ELBOW, command_of(ELBOW), COMMAND)),
    "scale": ({"scale:elbow_joint": 0.02}, tracking(ELBOW, command_of(ELBOW), COMMAND)),
    "range_limit": ({"range_limit:elbow_joint.upper": 0.2}, along_time(ELBOW, seconds=(0.0, 10.0))),
    "droop": (
        {"droop:shoulder_lift_joint": 5e-4},
        tracking(LIFT, gravity_on(LIFT), "gravity torque on the joint [Nm]"),
    ),
    "dead_zone": (
        {"dead_zone:elbow_joint": 0.02, "lag:elbow_joint": 0.03},
        tracking(ELBOW, command_of(ELBOW), COMMAND, ways=True),
    ),
    "play": ({"play:elbow_joint": 0.02}, tracking(ELBOW, command_of(ELBOW), COMMAND, ways=True)),
    "speed_limit": ({"speed_limit:elbow_joint": 0.35}, along_time(ELBOW)),
    "viscous_friction": ({"viscous_friction:elbow_joint": 10.0}, rows_of("torque", ELBOW, speed(ELBOW), SPEED)),
    "coulomb_friction": ({"coulomb_friction:elbow_joint": 4.0}, rows_of("torque", ELBOW, speed(ELBOW), SPEED)),
    "asymmetric_friction": (
        {"asymmetric_friction:elbow_joint": 2.0, "coulomb_friction:elbow_joint": 4.0},
        rows_of("torque", ELBOW, speed(ELBOW), SPEED),
    ),
    "stribeck_friction": (
        {"stribeck_friction:elbow_joint": 4.0, "coulomb_friction:elbow_joint": 3.0},
        rows_of("torque", ELBOW, speed(ELBOW), SPEED),
    ),
    "load_friction": (
        {"load_friction:shoulder_lift_joint": 0.1},
        rows_of("torque", LIFT, torque(LIFT), TORQUE, ways=True),
    ),
    "coupled_friction": (
        {"coupled_friction:elbow_joint": 3.0},
        rows_of("torque", ELBOW, speed(LIFT), "speed of the neighbouring joint [°/s]"),
    ),
    "rotor_inertia": (
        {"rotor_inertia:elbow_joint": 2.0},
        rows_of("torque", ELBOW, lambda of: np.degrees(of.acceleration[:, ELBOW]), "acceleration [°/s²]"),
    ),
    "payload": ({"payload:tool": 1.0}, rows_of("torque", LIFT, torque(LIFT), TORQUE)),
    "torque_constant": ({"torque_constant:shoulder_lift_joint": 0.1}, rows_of("torque", LIFT, torque(LIFT), TORQUE)),
    "link_inertia": ({"link_inertia:elbow_joint.mass_z": 1.0}, rows_of("torque", ELBOW, angle(ELBOW), ANGLE)),
    "gear_spring": ({"gear_spring:shoulder_lift_joint": 2e-5}, rows_of("load", LIFT, torque(LIFT), TORQUE)),
    "lost_motion": (
        {"lost_motion:elbow_joint": 6e-4},
        rows_of("load", ELBOW, angle(ELBOW), ANGLE, ways=True),
    ),
    "gear_ripple": ({"gear_ripple:elbow_joint": 3e-4}, rows_of("load", ELBOW, angle(ELBOW), ANGLE)),
    "gear_ratio": ({"gear_ratio:elbow_joint": 1e-3}, rows_of("load", ELBOW, angle(ELBOW), ANGLE)),
}
"""For each effect what is put into the arm, a little more than usual, and the view in which it shows."""


def main(names: list[str]) -> None:
    FOLDER.mkdir(exist_ok=True)
    for name in names or PICTURES:
        effects, draw = PICTURES[name]
        log = simulate_motion(find_robot("ur5"), series=3, effects=effects, seed=4)
        figure = Figure(figsize=SIZE, dpi=96, layout="constrained", facecolor="white")
        ax = figure.subplots()
        draw(ax, log)
        ax.spines[["top", "right"]].set_visible(False)
        ax.grid(color="#e6e9ed", linewidth=0.7)
        ax.set_axisbelow(True)
        ax.tick_params(colors=INK, length=0, labelsize=7)
        ax.xaxis.label.set(color=INK, fontsize=8)
        ax.yaxis.label.set(color=INK, fontsize=8)
        ax.set_title(spoken(name).capitalize(), fontsize=8, color=INK, loc="left")
        figure.savefig(FOLDER / f"{name}.png")


if __name__ == "__main__":
    main(sys.argv[1:])
