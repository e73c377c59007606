"""robolaser export: a result in a copy of the user's own robot or calibration."""

from collections.abc import Mapping
from math import degrees, isfinite
from pathlib import Path
from typing import Annotated, Any

from cyclopts import Parameter

from robolaser.commands.terminal import RESULT, Force, Terminal, say
from robolaser.errors import DataError


def export(
    result: Path,
    /,
    *,
    into: Annotated[Path, Parameter(metavar="FILE")],
    output: Annotated[Path, Parameter(metavar="FILE", group=RESULT)],
    replay: Annotated[Path | None, Parameter(metavar="LOG")] = None,
    force: Force = False,
    terminal: Terminal = Terminal(),
) -> None:
    """Write a result into a copy of your own URDF, MJCF or LeRobot calibration; all other elements are unchanged.

    For example:

        robolaser export result --into cell.urdf --output cell-corrected.urdf
        robolaser export why --into so101.xml --output so101-real.xml --replay other-motions
        robolaser export why --into my_arm.json --output my_arm-corrected.json

    Args:
        result: Folder of a calibration or a diagnosis.
        into: Your URDF or MJCF; or, for the zeros, LeRobot's calibration of the arm, .json.
        output: File for the copy.
        replay: Drive your MJCF and the copy in MuJoCo with this log's commands, and compare both with its readings.
    """
    from robolaser.bounded_reading import ROBOT_BYTES, read_text
    from robolaser.calibration.saved import read_result, robot_in
    from robolaser.data.result_folder import results_in, write_results
    from robolaser.export.into import motion_into, placements_into, zeros_into
    from robolaser.export.into_mjcf import placements_into_mjcf
    from robolaser.export.servo_table import less_hold
    from robolaser.motion.reading import load_motion
    from robolaser.motion.replay import replay as replayed
    from robolaser.robot.urdf import markup

    log = None if replay is None else load_motion(replay)
    before = None if log is None else replayed(into, log)
    contents, _, folder = read_result(result)
    text = read_text(into, ROBOT_BYTES)
    if into.suffix == ".json":
        written = zeros_into(text, contents["effects"], into.name)
    elif contents.get("kind") == "motion":
        written = motion_into(text, less_hold(contents["effects"], contents.get("step_s", 0.0)), into.name)
    else:
        corrected = folder and folder / "robot_corrected.urdf"
        if corrected is None or not corrected.is_file():
            raise DataError(
                f"{result} has no robot_corrected.urdf: it has neither joint_offset nor link_geometry, or its errors"
                " are so large that no file was written."
            )
        if markup.read(text, into.name, ROBOT_BYTES).tag == "mujoco":
            nominal, calibrated = robot_in(folder, nominal=True), robot_in(folder)
            if nominal is None or calibrated is None:
                raise DataError(f"{result} lacks robot.urdf or calibration.json, by which an MJCF is changed.")
            written = placements_into_mjcf(into, text, nominal, calibrated, contents["effects"])
        else:
            written = placements_into(text, read_text(corrected, ROBOT_BYTES), contents["effects"], into.name)
    inputs = [result, into, *filter(None, [replay])]
    with results_in(output.parent, command="export", files=[output.name], inputs=inputs, force=force):
        write_results(output.parent, {output.name: written.text})
    compared = None
    if log is not None and before is not None:
        after, promised = replayed(output, log), _promised(contents)
        compared = {
            joint: {"before_rad": was, "after_rad": after[joint], "promised_rad": promised.get(joint)}
            for joint, was in before.items()
            if isfinite(was)
        }
    found = {"replay": compared, "file": str(output), "contains": written.contains, "lacks": written.lacks}

    def print_rows() -> None:
        for remark in written.remarks:
            say(remark)
        for effect, where in written.contains:
            say(f"contains {effect} at {where}")
        for effect, where in written.lacks:
            say(f"lacks {effect} at {where}: it is not written into this kind of file")
        for joint, error in (compared or {}).items():
            was, now = (degrees(error[name] or 0.0) for name in ("before_rad", "after_rad"))
            predicted = error["promised_rad"]
            promise = "" if predicted is None else f"; the diagnosis predicts {degrees(predicted):.3g}°"
            say(f"replayed, {joint} is {now:.3g}° from its readings, {was:.3g}° before{promise}")
        say(f"Wrote {output}")

    terminal.show(found, print_rows)


def _promised(contents: Mapping[str, Any]) -> dict[str, float]:
    """Errors of joints on unseen motions, stated by a diagnosis of a moving arm [rad]."""
    rows = (one["joints"] for one in contents.get("rows", ()) if one.get("kind") == "tracking")
    return {joint: error["after"] for joints in rows for joint, error in joints.items()}
