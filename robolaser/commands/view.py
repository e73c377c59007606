"""robolaser view: a cell in the browser."""

import webbrowser
from collections.abc import Callable, Sequence
from functools import partial
from pathlib import Path
from typing import TYPE_CHECKING, Annotated

from cyclopts import Parameter

from robolaser.commands.terminal import Port, Terminal, say
from robolaser.errors import DataError, UsageError

if TYPE_CHECKING:
    from robolaser.arrays import Array
    from robolaser.data.cell_config import Cell
    from robolaser.data.dataset import Dataset
    from robolaser.report.cell_poses import CellPoses
    from robolaser.report.viewer.scene import SceneNode


def view(
    dataset: Path,
    calibration: Path | None = None,
    /,
    *,
    cloud: Annotated[Path | None, Parameter(metavar="CLOUD.ply")] = None,
    cell: Annotated[Path | None, Parameter(metavar="CELL")] = None,
    port: Port | None = None,
    browser: Annotated[bool, Parameter(negative="--no-browser")] = True,
    terminal: Terminal = Terminal(),
) -> None:
    """Show robot, sensor, target and points in the browser.

    For example:

        robolaser view measured result --cloud cloud.ply
        robolaser view poses.csv --cell cell

    Args:
        dataset: Data set or recording; with --cell, also a poses.csv of planned poses.
        calibration: calibration.json or its folder.
        cloud: A cloud of `robolaser scan`.
        cell: Show the boxes of this cell, and collisions in red.
        port: Port to serve at. Default: 8080 or the next free one.
        browser: Open the page in the browser.
    """
    from robolaser.data.cell_config import load_cell
    from robolaser.data.loading import load
    from robolaser.model.sensors.stripe import SCANNER
    from robolaser.report.viewer.cells import nominal_cell
    from robolaser.report.viewer.scene import ShownCell, downsampled
    from robolaser.report.viewer.serving import ViewerApp
    from robolaser.scan.ply import map_ply

    stated = None if cell is None else load_cell(cell)
    data = load(dataset) if stated is None or dataset.is_dir() else _planned(stated, dataset)
    models: list[ShownCell] = []
    doubts: Sequence[str] = ()
    if calibration is None or set(SCANNER) <= set(data.parameters):
        models.append(nominal_cell(data))
    if calibration is not None:
        fitted, doubts = _fitted(data, calibration)
        models.append(fitted)
    points = None if cloud is None else downsampled(map_ply(cloud))
    terminal.warn(*data.warnings, *doubts)
    app = ViewerApp(tuple(models), points, port, None if stated is None else _collisions(stated, data))
    terminal.show({"url": app.url}, lambda: say(f"{data.name} is at {app.url}; stop with Ctrl-C."))
    if browser:
        webbrowser.open(app.url)
    try:
        app.wait()
    except KeyboardInterrupt:
        app.stop()


def _fitted(data: "Dataset", calibration: Path) -> tuple["CellPoses", Sequence[str]]:
    """The cell by the numbers and effects of a saved calibration, and warnings on the effects."""
    from robolaser.calibration.saved import CALIBRATION, numbers_of, read_result
    from robolaser.model.effects import found_effect
    from robolaser.report.viewer.cells import fitted_cell

    contents, found, _ = read_result(calibration, CALIBRATION)
    image = found.model.image
    if image and data.image_px and image != data.image_px:
        of_data, of_calibration = ("{} x {} px".format(*size) for size in (data.image_px, image))
        raise DataError(
            f"{data.name} has images of {of_data}, but the calibration is of a camera with {of_calibration}. Use the"
            " calibration of the camera that took them, or correct [image] in dataset.toml.",
            file=calibration,
        )
    effects = [found_effect(one.effect, one.where, data.robot) for one in found.effects]
    numbers = {name: number["value"] for name, number in numbers_of(contents).items()}
    return fitted_cell(data, effects, numbers, found.run)


def _planned(cell: "Cell", poses: Path) -> "Dataset":
    """The cell's description with poses of a table, without points."""
    from dataclasses import replace

    import numpy as np

    from robolaser.cell.route import from_table
    from robolaser.data.dataset import Poses

    waypoints = from_table(poses, cell.robot)
    q = np.array([waypoint.q for waypoint in waypoints])
    return replace(cell.description, poses=Poses(tuple(waypoint.name for waypoint in waypoints), q=q))


def _collisions(cell: "Cell", data: "Dataset") -> "Callable[[Array], tuple[str, tuple[SceneNode, ...]]]":
    """Collisions of a data set's arm in a cell, by its joint values."""
    from robolaser.cell.plan_validation import RouteCheck
    from robolaser.report.viewer.scene import collision_shapes

    if data.robot is None or data.robot.joints != cell.robot.joints or data.poses.q is None:
        raise UsageError(f"The data set's joints are not those of --cell ({', '.join(cell.robot.joints)}).")
    return partial(collision_shapes, RouteCheck.of(cell).bodies, cell.limits.margin_m)
