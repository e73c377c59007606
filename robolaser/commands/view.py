"""robolaser view: a cell in the browser."""

import webbrowser
from pathlib import Path
from typing import Annotated

from cyclopts import Parameter

from robolaser.commands.options import Port
from robolaser.commands.terminal import TERMINAL, Terminal, say


def view(
    dataset: Path,
    calibration: Path | None = None,
    /,
    *,
    cloud: Annotated[Path | None, Parameter(metavar="CLOUD.ply")] = None,
    port: Port | None = None,
    browser: Annotated[bool, Parameter(negative="--no-browser")] = True,
    terminal: Terminal = TERMINAL,
) -> None:
    """Show robot, scanner, laser plane, target and points in the browser.

    For example:

        robolaser view measured result --cloud cloud.ply

    Args:
        dataset: Data set or recording.
        calibration: calibration.json or its folder.
        cloud: A cloud of `robolaser scan`.
        port: Port to serve at. Default: 8080 or the next free one.
        browser: Open the page in the browser.
    """
    from robolaser.data.loading import load
    from robolaser.report.viewer.cell_model import CellModel, calibrated, nominal
    from robolaser.report.viewer.downsampling import downsampled
    from robolaser.report.viewer.serving import ViewerApp
    from robolaser.scan import read_calibration
    from robolaser.scan.ply import map_ply

    data = load(dataset)
    models: tuple[CellModel, ...] = (nominal(data),)
    if calibration is not None:
        models = (*models, calibrated(read_calibration(calibration), data))
    points = None if cloud is None else downsampled(map_ply(cloud))
    for warning in (*data.warnings, *(note for model in models for note in model.notes)):
        terminal.warn(warning)
    app = ViewerApp(models, points, port)
    terminal.show({"url": app.url}, lambda: say(f"{data.name} is at {app.url}; stop with Ctrl-C."))
    if browser:
        webbrowser.open(app.url)
    try:
        app.wait()
    except KeyboardInterrupt:
        app.stop()
