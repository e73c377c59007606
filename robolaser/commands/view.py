"""robolaser view: a cell in the browser."""

import webbrowser
from pathlib import Path
from typing import TYPE_CHECKING, Annotated

from cyclopts import Parameter

from robolaser.commands.options import Port
from robolaser.commands.terminal import TERMINAL, Terminal, say
from robolaser.errors import UsageError

if TYPE_CHECKING:
    from robolaser.data.cell_config import Cell
    from robolaser.data.dataset import Dataset
    from robolaser.report.viewer.collision_scene import CollisionScene


def view(
    dataset: Path,
    calibration: Path | None = None,
    /,
    *,
    cloud: Annotated[Path | None, Parameter(metavar="CLOUD.ply")] = None,
    cell: Annotated[Path | None, Parameter(metavar="CELL")] = None,
    port: Port | None = None,
    browser: Annotated[bool, Parameter(negative="--no-browser")] = True,
    terminal: Terminal = TERMINAL,
) -> None:
    """Show robot, scanner, laser plane, target and points in the browser.

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
    from robolaser.report.viewer.cell_model import CellModel, calibrated, has_nominal, nominal
    from robolaser.report.viewer.downsampling import downsampled
    from robolaser.report.viewer.serving import ViewerApp
    from robolaser.scan import read_calibration
    from robolaser.scan.ply import map_ply

    stated = None if cell is None else load_cell(cell)
    data = load(dataset) if stated is None or dataset.is_dir() else _planned(stated, dataset)
    found = None if calibration is None else read_calibration(calibration, data.robot)
    models: tuple[CellModel, ...] = () if found is not None and not has_nominal(data) else (nominal(data),)
    if found is not None:
        models = (*models, calibrated(found, data))
    points = None if cloud is None else downsampled(map_ply(cloud))
    for warning in (*data.warnings, *(note for model in models for note in model.notes)):
        terminal.warn(warning)
    app = ViewerApp(models, points, port, None if stated is None else _collisions(stated, data))
    terminal.show({"url": app.url}, lambda: say(f"{data.name} is at {app.url}; stop with Ctrl-C."))
    if browser:
        webbrowser.open(app.url)
    try:
        app.wait()
    except KeyboardInterrupt:
        app.stop()


def _planned(cell: "Cell", poses: Path) -> "Dataset":
    """The cell's description with poses of a table, without points."""
    from dataclasses import replace

    import numpy as np

    from robolaser.cell.route import from_table
    from robolaser.data.dataset import Poses

    waypoints = from_table(poses, cell.robot)
    q = np.array([waypoint.q for waypoint in waypoints])
    return replace(cell.description, poses=Poses(tuple(waypoint.name for waypoint in waypoints), q=q))


def _collisions(cell: "Cell", data: "Dataset") -> "CollisionScene":
    """What the poses of a data set would hit in a cell."""
    from robolaser.cell.cell_collisions import collision_model
    from robolaser.cell.plan_validation import cell_violations
    from robolaser.report.viewer.collision_scene import CollisionScene

    if data.robot is None or data.robot.joints != cell.robot.joints or data.poses.q is None:
        raise UsageError(f"The data set's joints are not those of --cell ({', '.join(cell.robot.joints)}).")
    bodies = collision_model(cell.description, cell.limits, cell.boxes)
    broken = cell_violations(cell, None, data.poses.names, data.poses.q)
    return CollisionScene(bodies, cell.limits.margin_m, tuple(broken))
