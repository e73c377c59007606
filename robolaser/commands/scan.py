"""robolaser scan: from a calibration and a recording to a cloud of points."""

import re
from collections.abc import Iterable, Sequence
from dataclasses import dataclass
from pathlib import Path
from typing import TYPE_CHECKING, Annotated, final

from cyclopts import Parameter, validators

from robolaser.commands.terminal import RESULT, Force, PositiveOption, ResultFlag, Terminal, Typed
from robolaser.errors import Interrupted, UsageError

if TYPE_CHECKING:
    from robolaser.arrays import Array, Progress
    from robolaser.scan import Scan
    from robolaser.scan.cloud import Cloud
    from robolaser.scan.cloud_files import Subsample
    from robolaser.scan.ply import Vertices

SIDE = re.compile(r"([^:]*):([^:]*)")
CLOUD = validators.Path(ext=("ply", "pcd", "las", "e57"))
SIZE = validators.Number(gte=1e-3, lte=1.0)  # a few times the tolerance of points on a plane; and no millimetres [m]


def region_of(text: str) -> "Array":
    """Least and largest x, y and z of `X0:X1,Y0:Y1,Z0:Z1`, (3, 2) [m]; empty ones are open.

    Raises:
        UsageError: It is no region.
    """
    import numpy as np

    try:
        sides = [SIDE.fullmatch(side.strip()).groups() for side in text.split(",")]  # type: ignore[union-attr]
        region = np.array([[float(low or "-inf"), float(high or "inf")] for low, high in sides])
        if region.shape == (3, 2) and (region[:, 0] < region[:, 1]).all():
            return region
    except (AttributeError, ValueError):
        pass
    raise UsageError(f"--region {text}: expected X0:X1,Y0:Y1,Z0:Z1 in metres, least first, for example 0.3:0.5,:,0.01:")


@final
@Parameter(name="*")
@dataclass(frozen=True)
class PointOptions:
    """The points of a cloud.

    Attributes:
        region: Keep only the points of this box in the base frame; sides may be left open.
        voxel: Keep the mean of the points in each cube of this size.
        normals: Add normals, towards the camera.
        colour: Add colours: the grey of the stripe.
    """

    region: Annotated[str | None, Parameter(metavar="X0:X1,Y0:Y1,Z0:Z1")] = None
    voxel: Annotated[PositiveOption | None, Parameter(metavar="SIZE_M")] = None
    normals: bool = False
    colour: bool = False

    def of(self, cloud: "Cloud", sample: "Subsample", progress: "Progress") -> "Iterable[Vertices]":
        """The selected points of a cloud, with added columns; a sample keeps some of them."""
        import numpy as np

        from robolaser.scan.cloud_files import one_per_voxel, with_colours, with_normals, within

        pieces: Iterable[Vertices] = cloud.pieces(progress)
        pieces = pieces if self.region is None else within(pieces, region_of(self.region))
        pieces = sample.watch(pieces if self.voxel is None else [one_per_voxel(pieces, self.voxel)])
        if self.normals:
            pieces = [with_normals(np.concatenate(list(pieces)), cloud.cameras)]
        return map(with_colours, pieces) if self.colour else pieces


def scan(
    calibration: Path,
    recording: Path,
    /,
    *more: Path,
    output: Annotated[Path, Parameter(metavar="CLOUD.ply", group=RESULT, validator=CLOUD)],
    nominal: bool = False,
    kept: PointOptions = PointOptions(),
    plane: bool = False,
    step: Annotated[float | None, Parameter(metavar="HEIGHT_M", validator=SIZE)] = None,
    sphere: Annotated[float | None, Parameter(metavar="RADIUS_M", validator=SIZE)] = None,
    report: ResultFlag = False,
    force: Force = False,
    terminal: Terminal = Terminal(),
    typed: Typed = "",
) -> None:
    """Convert a recording to a point cloud with a calibrated scanner.

    For example:

        robolaser scan result recording --output cloud.ply
        robolaser scan result recording --output cloud.ply --plane --step 0.01 --report
        robolaser scan result front back --output part.las --region 0.3:0.6,:,0.005: --voxel 0.0005

    Args:
        calibration: calibration.json or its folder; without its robot.urdf, the recording's arm is used.
        recording: Folder with dataset.toml, poses.csv and stripes.npy, points.csv or images.
        more: Further recordings with the same scanner and base: all become one cloud.
        output: The cloud: binary .ply or .pcd, .las or .e57.
        nominal: Use the nominal parameters, from before the fit.
        plane: Measure the scatter of the points about the largest plane.
        step: Measure a step of about this height, 0.001 to 1 metres, on the largest plane.
        sphere: Measure a sphere of about this radius, likewise.
        report: Write CLOUD.html beside it, with charts.
    """
    from robolaser.data.result_folder import STAGED, results_in, write_results
    from robolaser.report.cloud import document
    from robolaser.report.console import print_document
    from robolaser.report.page import render
    from robolaser.scan.cloud_files import Subsample, write_cloud
    from robolaser.scan.quality import measure

    page, is_replaced, inputs = output.with_suffix(".html"), output.exists(), [calibration, recording, *more]
    if kept.region is not None:
        region_of(kept.region)
    made = _prepared(calibration, [recording, *more], terminal, nominal=nominal)
    files = [output, page] if report else [output]
    names = [file.name for file in files]
    with results_in(output.parent, command="scan", files=names, inputs=inputs, force=force) as claim:
        if is_replaced and page.name in claim(()):
            names.append(page.name)  # of the earlier cloud
        sample, cloud = Subsample(), output.with_name(f"{STAGED}{output.name}")
        with terminal.progress() as progress:
            count = write_cloud(cloud, kept.of(made.cloud, sample, progress), made.comments())
        if kept.region is not None or kept.voxel is not None:
            terminal.print(f"{count} of {made.cloud.counts.points} points are kept.")
        try:
            quality = measure(sample.vertices, plane=plane, step_m=step, sphere_m=sphere)
            shown = {page.name: render(document(made, quality), typed)} if report else {}
            write_results(output.parent, {**dict.fromkeys(names), output.name: cloud, **shown})
        except KeyboardInterrupt:
            write_results(output.parent, {**dict.fromkeys(names), output.name: cloud})
            raise Interrupted(
                f"Stopped. {output} was written, but not what is measured on it: run the command again with --force."
            ) from None
    bodies = [
        {"body": body.what, "size_m": body.size_m, "std_m": body.std_m, "known_m": body.known_m, "rms_m": body.rms_m}
        for body in quality.primitives
    ]
    result = {"cloud": str(output), "points": count, "bodies": bodies, "missing": [str(one) for one in quality.missing]}
    terminal.show(result, lambda: print_document(document(made, quality, brief=True)))
    terminal.print(f"Wrote {' and '.join(map(str, files))}")
    terminal.warn(*quality.doubts, *map(str, quality.missing[1:]))
    for missing in quality.missing[:1]:
        raise missing


def _prepared(calibration: Path, folders: "Sequence[Path]", terminal: Terminal, *, nominal: bool) -> "Scan":
    """The scan of all recordings as one, with their warnings."""
    from robolaser.data.loading import load
    from robolaser.scan import merged, prepare, read_calibration

    recordings = [load(folder) for folder in folders]
    calibrated = read_calibration(calibration, recordings[0].robot)
    scans = [prepare(calibrated.as_drawn() if nominal else calibrated, one) for one in recordings]
    made = merged(scans)
    terminal.warn(*dict.fromkeys(sentence for one in scans for sentence in one.recording.warnings), *made.warnings)
    if made.calibrated.setup_warning is not None:
        terminal.warn(made.calibrated.setup_warning)
    return made
