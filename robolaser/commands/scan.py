"""robolaser scan: from a calibration and a recording to a cloud of points."""

from pathlib import Path
from typing import Annotated, Any

from cyclopts import Parameter
from cyclopts.validators import Number

from robolaser.commands.options import RESULT, Force, Positive, Typed
from robolaser.commands.terminal import TERMINAL, Terminal
from robolaser.errors import Interrupted

ENDING = ".ply"
LEAST_STEP_M = 1e-3  # a few times the distance at which points still count as on a plane


def cloud_file(_: Any, path: Path) -> None:
    """Check the name of a cloud.

    Raises:
        ValueError: It is no name of a PLY file.
    """
    if path.suffix.lower() != ENDING:
        raise ValueError(f"Expected a name that ends with {ENDING}.")


def scan(
    calibration: Path,
    recording: Path,
    /,
    *,
    output: Annotated[Path, Parameter(metavar="CLOUD.ply", group=RESULT, validator=cloud_file)],
    nominal: bool = False,
    plane: bool = False,
    step: Annotated[float | None, Parameter(metavar="HEIGHT_M", validator=Number(gte=LEAST_STEP_M))] = None,
    sphere: Annotated[Positive | None, Parameter(metavar="RADIUS_M")] = None,
    report: Annotated[bool, Parameter(group=RESULT)] = False,
    force: Force = False,
    terminal: Terminal = TERMINAL,
    typed: Typed = "",
) -> None:
    """Turn a recording into a point cloud with a calibrated scanner.

    For example:

        robolaser scan result recording --output cloud.ply
        robolaser scan result recording --output cloud.ply --plane --step 0.01 --report

    Args:
        calibration: calibration.json or its folder, with robot.urdf.
        recording: Folder with dataset.toml, poses.csv and stripes.npy, points.csv or images.
        output: The cloud, as binary PLY.
        nominal: Use the nominal parameters, from before the fit.
        plane: Measure the scatter of the points about the largest plane.
        step: Measure a step of about this height, at least 0.001, on the largest plane.
        sphere: Measure a sphere of about this radius.
        report: Write CLOUD.html beside it, with charts.
        force: Overwrite an earlier cloud.
    """
    from robolaser.data.loading import load
    from robolaser.data.result_folder import results_in, write_results
    from robolaser.report.cloud import page, print_cloud
    from robolaser.scan import prepare, read_calibration
    from robolaser.scan.ply import write_ply
    from robolaser.scan.quality import measure
    from robolaser.scan.subsample import Subsample

    files = [output, *([output.with_suffix(".html")] if report else [])]
    calibrated = read_calibration(calibration)
    made = prepare(calibrated.as_drawn() if nominal else calibrated, load(recording))
    for warning in (*made.recording.warnings, *made.warnings):
        terminal.warn(warning)
    names = [file.name for file in files]
    with results_in(output.parent, command="scan", files=names, inputs=[calibration], force=force):
        subsample = Subsample()
        cloud = output.with_name(f".{output.name}")
        with terminal.progress() as progress:
            pieces = subsample.watch(made.cloud.pieces(progress))
            write_ply(cloud, pieces, made.comments())
        wanted = [what for what, size in (("plane", plane), ("step", step), ("sphere", sphere)) if size]
        try:
            quality = measure(subsample.vertices, wanted=wanted, step_m=step or 0.0, sphere_m=sphere or 0.0)
            shown = {files[1].name: page(made, quality, command=typed)} if report else {}
            write_results(output.parent, {output.name: cloud, **shown})
        except KeyboardInterrupt:
            write_results(output.parent, {output.name: cloud})
            raise Interrupted(
                f"Stopped. {output} was written, but not what is measured on it: run the command again with --force."
            ) from None
    bodies = [
        {"body": body.what, "size_m": body.size_m, "std_m": body.std_m, "known_m": body.known_m, "rms_m": body.rms_m}
        for body in quality.primitives
    ]
    result = {"cloud": str(output), "bodies": bodies, "missing": [str(one) for one in quality.missing]}
    terminal.show(result, lambda: print_cloud(made, quality, *files))
    for doubt in quality.doubts:
        terminal.warn(doubt)
    for missing in quality.missing[1:]:
        terminal.warn(str(missing))
    for missing in quality.missing[:1]:
        raise missing
