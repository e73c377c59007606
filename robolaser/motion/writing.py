"""A log of a moving arm as the files of its folder."""

import json

import numpy as np

from robolaser.data.csv_tables import table_text
from robolaser.data.dataset_file import FORMAT
from robolaser.motion.log import QUANTITIES, MotionLog
from robolaser.motion.reading import MOTION
from robolaser.robot.kinematics import DOWN

MOTION_FOLDER = ("dataset.toml", MOTION, "robot.urdf")


def motion_texts(log: MotionLog) -> dict[str, str]:
    """What its files hold, by name; `load_motion` reads the same log back."""
    columns = {
        f"{quantity}_{joint}": getattr(log, quantity)[:, j]
        for j, joint in enumerate(log.joints)
        for quantity in QUANTITIES
        if log.has(quantity)[j]
    }
    cells = [["" if not np.isfinite(value) else f"{value:.10g}" for value in column] for column in columns.values()]
    names = (log.series[run] for run in log.run)
    rows = zip(names, (f"{time:.9g}" for time in log.time_s), *cells, strict=True)
    return {
        "robot.urdf": log.robot.urdf,
        MOTION: table_text(["series", "time_s", *columns], rows),
        "dataset.toml": "\n".join(_settings(log)) + "\n",
    }


def _settings(log: MotionLog) -> list[str]:
    gravity = [f"gravity = {list(log.robot.gravity)}"] if log.robot.gravity != DOWN else []
    step = [] if log.encoder_step_rad is None else [f"encoder_step_rad = {log.encoder_step_rad!r}"]
    return [
        f"format = {json.dumps(FORMAT)}",
        f"name = {json.dumps(log.name)}",
        *(f"{key} = {json.dumps(text)}" for key, text in (("source", log.source), ("licence", log.licence)) if text),
        "",
        "[robot]",
        'urdf = "robot.urdf"',
        f"flange = {json.dumps(log.robot.flange)}",
        f"joints = {json.dumps(list(log.joints))}",
        *gravity,
        "",
        "[sensor]",
        'kind = "motion"',
        "",
        "[motion]",
        f"torque_unit = {json.dumps(log.torque_unit)}",
        f"torque_signed = {json.dumps(log.torque_signed)}",
        f"offset_per_series = {json.dumps(log.offset_per_series)}",
        *step,
        *(f"payload_kg = {{ {carried} }}" for carried in [_by_series(log)] if carried),
    ]


def _by_series(log: MotionLog) -> str:
    return ", ".join(f"{json.dumps(name)} = {mass!r}" for name, mass in log.payload_kg.items())
