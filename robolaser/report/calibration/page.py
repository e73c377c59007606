"""The report of a calibration: a page with a chart of errors over the image, and a few lines on the terminal."""

from collections.abc import Mapping, Sequence
from pathlib import Path
from typing import Any

import numpy as np

from robolaser.arrays import Array
from robolaser.calibration.result import Calibration
from robolaser.report.calibration.rows import effect_rows, parameter_rows
from robolaser.report.cell_poses import CellPoses
from robolaser.report.chart import MUTED, Chart, chart, equal_axes, hover, layer, records
from robolaser.report.digits import SIGNIFICANT, millimetres, plain
from robolaser.report.document import Column, Content, Document, Figure, Figures, Notes, Section, Table, Text, charts
from robolaser.report.error_analysis import ErrorAnalysis, lengths_mm, point_names, some_rows
from robolaser.report.error_groups import group_blocks, pose_errors
from robolaser.report.model_scene import cell_scene
from robolaser.report.scene import magnification
from robolaser.report.setting import disturbed, files_section, noise_table, origin

ESTIMATED = "estimated from the residuals, including what is unmodelled"
MANY = 24  # rows of closed-form parameters above which they are collapsed
MOST_PRINTED = 16
PARAMETER = Column("Parameter", "name", 34, "parameter")
VALUE = Column("Value ± standard deviation", "number", 25, "value")
REMARK = Column("Remark", "wide", brief="")


def figures(analysis: ErrorAnalysis) -> list[Figure]:
    """Error on new poses, by noise alone, and on fitted poses; then the same for rotations."""
    calibration = analysis.calibration
    sources = ", ".join(map(disturbed, analysis.known_noise))
    rows, weighting = calibration.row_errors[0], "plain: " if calibration.weights == "plain" else ""
    shown = (
        ("held-out", "on new poses", calibration.held_out_rms_m,
         f"{weighting}predicted with each pose held out of the fit{_in_unit(rows.held_out_rms, rows.unit)}"),
        ("noise", "known noise", analysis.noise_m, f"by {sources} alone" if sources else "no noise is known"),
        ("fitted", "on fitted poses", calibration.rms_m,
         f"{weighting}training error, optimistic{_in_unit(rows.rms, rows.unit)}"),
    )  # fmt: skip
    angles = [each for each in calibration.row_errors if each.unit == "rad"]
    turn = "rotation of bodies about three axes together"
    turns = [
        Figure(kind, label, plain(error, "rad", SIGNIFICANT), f"{each.sensor}: {turn}" if angles[1:] else turn)
        for each in angles
        for kind, label, error in (
            ("held-out", "new poses, rotation", each.held_out_rms),
            ("fitted", "fitted, rotation", each.rms),
        )
        if error is not None
    ]
    largest = max(error for _, _, error, _ in shown if error is not None) or 1.0
    lengths = [
        Figure(kind, label, millimetres(error), remark, None if error is None else 100 * error / largest)
        for kind, label, error, remark in shown
    ]
    return lengths + turns


def _in_unit(rms: float | None, unit: str) -> str:
    """The error in the rows' own unit, if that is not the metre; a row's two pixels are one length."""
    return "" if rms is None or unit == "m" else f"; {rms:.3g} {unit}"


def document(
    calibration: Calibration,
    *,
    brief: bool = False,
    files: Sequence[Mapping[str, Any]] = (),
    folder: Path | None = None,
) -> Document:
    """The report, given `files` of calibration.json; in brief without the parts that only a page shows.

    The terminal lists the files for ROS in the folder of the result.
    """
    analysis = ErrorAnalysis(calibration)
    dataset = calibration.model.dataset
    return Document(
        dataset.name,
        "calibrated",
        dataset.summary,
        analysis.headline,
        analysis.judgement,
        [
            Figures(figures(analysis)),
            Text(f"Root mean square of three-dimensional errors. Found by {analysis.method}.", "quiet"),
        ],
        [
            Section("Warnings", [Notes(calibration.warnings, "warnings")]),
            Section("What these data cannot determine", _undetermined(calibration)),
            Section("Parameters", _parameters(calibration)),
            files_section(files),
            *([Section("Remarks", _remarks(calibration, folder))] if brief else _evidence(analysis)),
        ],
        footer=origin(dataset.source, dataset.licence),
    )


def _evidence(analysis: ErrorAnalysis) -> list[Section]:
    calibration = analysis.calibration
    errors, (of_fit, compared) = {"errors of the fit": calibration.errors_m}, analysis.compared
    reading = "Dots: a pose when it was fitted; rings: when it was held out." if len(compared) > 1 else ""
    cell = cell_scene(calibration.model, calibration.x, errors, title="Each pose, and its errors")
    units, known = {source.name: source.unit for source in analysis.sources}, analysis.known_noise
    sizes = calibration.noise.items()
    noise = [(name, sigma, units.get(name, ""), known.get(name, ESTIMATED)) for name, sigma in sizes]
    return [
        Section("Which errors stand out", group_blocks(of_fit, compared)),
        Section("The cell", [cell]),
        Section("Charts", charts([image_errors(analysis), pose_errors(of_fit, compared, reading=reading)])),
        Section("Noise", [noise_table(noise)]),
    ]


def _undetermined(calibration: Calibration) -> list[Content]:
    found: list[Content] = [Text(sentence) for sentence in _exported(calibration)]
    if not calibration.unidentifiable:
        return found
    remedy = (
        "Where a standard error is stated, more poses that differ, above all in tilt and distance, would reduce it."
    )
    return [Notes([one.reason for one in calibration.unidentifiable]), Text(remedy, "quiet"), *found]


def _exported(calibration: Calibration) -> list[str]:
    """A sentence on what exported files have for effects that the data do not determine, if any."""
    unclear, every = len(calibration.undetermined_effects), len(calibration.model.effect_parameters)
    sentence = (
        f"These data do not determine {unclear} of {every} parameters of effects by themselves. Exported files have the"
        " values nearest to nominal that fit nearly as well; `calibration.json` has those that fit best."
    )
    return [sentence] if unclear else []


def _parameters(calibration: Calibration) -> list[Content]:
    given, placed = parameter_rows(calibration)
    within = Column("Bounds", "wide", brief="")
    closed_form = "Initialized from the data" if given else ""
    nominal = Column("Nominal", "text", 13, "nominal")
    why = "These need no nominal values" if given else "There is no nominal model: no nominal values are given"
    start = f"{why}; they start from a closed-form estimate."
    columns = [Column("Effect", "name", 34, "effect"), VALUE, Column("Standard deviations from zero"), REMARK]
    return [
        Table([PARAMETER, VALUE, nominal, within], given, printed=MOST_PRINTED),
        Table([PARAMETER, VALUE, REMARK], placed, closed_form, start, MANY, 0 if given else MOST_PRINTED),
        Table(columns, effect_rows(calibration), "Effects in the model", printed=MOST_PRINTED),
    ]


def _remarks(calibration: Calibration, folder: Path | None) -> list[Content]:
    """Undetermined parameters and the files for ROS, for the terminal."""
    groups = [one.parameters for one in calibration.unidentifiable]
    together = list(dict.fromkeys(", ".join(names) for names in groups if len(names) > 1))
    alone = [names[0] for names in groups if len(names) == 1]
    more = f"; and {len(together) - GROUPS} more groups, in the report" if len(together) > GROUPS else ""
    lines = [f"These data cannot separate: {'; '.join(together[:GROUPS])}{more}"] if together else []
    lines += [f"These data hardly determine: {', '.join(alone)}"] if alone else []
    lines += _exported(calibration)
    if folder is not None and (folder / "static_transform.sh").exists():
        *others, last = (name for name in FOR_ROS if (folder / name).exists())
        lines.append(f"For ROS: {', '.join(others)} and {last} in {folder}")
    return [Text(line, "quiet", printed=True) for line in lines]


GROUPS = 3  # most groups of parameters that the terminal shows
FOR_ROS = ("camera.yaml", "robot.urdf", "static_transform.sh", "easy_handeye2.calib")
MOST_DOTS = 600  # points that a chart carries
DIVERGING = ("#2f6fbb", "#a9b1b9", "#cf4a2e")  # from too near to too far; visible on light and dark paper


def image_errors(analysis: ErrorAnalysis) -> Chart | None:
    """Errors over the pixel plane: lines across the view, colour along it where a row places a point in space."""
    calibration = analysis.calibration
    dataset, pixel = calibration.model.dataset, calibration.model.dataset.points.pixel
    cell = CellPoses(calibration.model, calibration.x)
    misses, errors_mm = cell.misses(calibration.errors_m), lengths_mm(calibration.errors_m)
    if misses is None or pixel is None or dataset.image_px is None:
        return None
    width, height = dataset.image_px
    depth_mm = _along_view(analysis, cell)
    rows = some_rows(errors_mm, MOST_DOTS)
    pose, point = point_names(dataset, rows)
    factor = magnification(float(np.percentile(np.linalg.norm(misses, axis=-1), 95)), float(width))
    end = pixel + factor * misses
    error = {"error": "error [mm]"} | ({} if depth_mm is None else {"depth": "error along the view [mm]"})
    data = records(
        pose=pose, point=point, x=pixel[rows, 0], y=pixel[rows, 1], x2=end[rows, 0], y2=end[rows, 1],
        error=errors_mm[rows], **({} if depth_mm is None else {"depth": depth_mm[rows]}),
    )  # fmt: skip
    corners = np.array([[-0.5, -0.5], [width - 0.5, height - 0.5]])
    x, y, tall = equal_axes(corners, ("u [px]", "v [px]"), margin=0.01)
    y["scale"]["reverse"] = True
    frame = records(x=-0.5, y=-0.5, x2=width - 0.5, y2=height - 0.5)
    ends = {"x": x, "y": y, "x2": {"field": "x2"}, "y2": {"field": "y2"}}
    dots = {"type": "point", "size": 22, "opacity": 1}
    in_space = depth_mm is not None
    colour: dict[str, Any] = {"value": MUTED}
    if depth_mm is not None:
        limit = float(np.percentile(np.abs(depth_mm), 98)) or 1.0
        scale = {"domain": [-limit, 0, limit], "range": DIVERGING, "clamp": True}
        legend = {"gradientLength": 180, "format": ".2~g"}
        colour = {"field": "depth", "type": "quantitative", "title": error["depth"], "scale": scale, "legend": legend}
    seen = "the stripe" if in_space else "the target"
    of_colour = "its colour is the error along the view (red: estimated too far away), " if in_space else ""
    return chart(
        "Errors over the image",
        f"Each dot is a measured point: {of_colour}its line leads to where the model predicts it, {factor:.3g} times"
        " as long."
        f" {'Colours or lines' if in_space else 'Lines'} that change slowly over the image indicate the lens"
        f"{' or the laser plane' if in_space else ''}; a random mixture is noise.",
        f"The image of {width} × {height} pixels with dots where {seen} was seen.",
        [
            layer(dots, data, tooltip=hover("pose", "point", **error), x=x, y=y, color=colour),
            layer({"type": "rule", "color": MUTED, "strokeWidth": 0.8}, data, **ends),
            layer({"type": "rect", "filled": False, "stroke": MUTED, "strokeWidth": 0.7}, frame, **ends),
        ],
        height=tall,
    )


def _along_view(analysis: ErrorAnalysis, cell: CellPoses) -> Array | None:
    """Errors of estimates along the view, (m,) [mm]; 0 for rows without any, None if all have none."""
    across = cell.across_view(analysis.calibration.errors_m)
    if cell.camera is None or across.all():
        return None
    along = np.einsum(
        "mj,mj->m", cell.camera[analysis.calibration.model.dataset.points.pose, :3, 2], analysis.calibration.errors_m
    )
    return np.where(across, 0.0, -1e3 * along)
