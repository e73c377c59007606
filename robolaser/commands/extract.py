"""robolaser extract: from images to points, or to the stripe's centres where there is no board."""

from collections.abc import Iterator
from functools import partial
from pathlib import Path
from typing import TYPE_CHECKING, Annotated, Any

from cyclopts import Parameter

from robolaser.commands.terminal import RESULT, Force, Terminal, say

if TYPE_CHECKING:
    from robolaser.data.dataset import Dataset
    from robolaser.data.stripe_file import Stripes

POINTS, STRIPES = "points.csv", "stripes.npy"


def extract(
    recording: Path,
    /,
    *,
    output: Annotated[Path | None, Parameter(metavar="DATASET", group=RESULT)] = None,
    force: Force = False,
    terminal: Terminal = Terminal(),
) -> None:
    """Detect board and laser stripe, or a camera's target, in a recording's images, and write points.csv.

    A stripe scanner's board also gives corners.csv. With --output, the data set
    has two sensors, stripe and camera, which are fitted together.

    Without [board], a stripe scanner's line centres in all images go to
    stripes.npy. Where poses.csv names an image with the laser off (image_off),
    the board is found there, and the stripe in the difference of both. For
    example:

        robolaser extract recording --output measured

    Args:
        recording: Folder with dataset.toml, poses.csv and images.
        output: Folder for a new data set with images and noise. Default: only add points to RECORDING.
    """
    from robolaser.bounded_reading import IMAGE_BYTES, read_bytes
    from robolaser.data.image_list import images_of_poses
    from robolaser.data.loading import load
    from robolaser.data.result_folder import STAGED, results_in, write_results, written_later
    from robolaser.data.several_sensors import CORNERS
    from robolaser.data.writing import FOLDER, point_texts, texts_of
    from robolaser.model.sensors import sensor_class

    dataset = load(recording)
    has_stripe = sensor_class(dataset.kind).has_laser_plane()
    to_scan = has_stripe and dataset.board is None and dataset.poses.image is not None
    if output is not None and output.resolve() == recording.resolve():
        output = None
    of_sensors = [sensor.file for sensor in dataset.members] or [POINTS, *([CORNERS] if has_stripe else [])]
    folder, (main, *others) = output or recording, [STRIPES] if to_scan else of_sensors
    names = {main, *others, *(() if output is None else FOLDER)}
    shots = [] if output is None else images_of_poses(dataset)
    images = [str(file.relative_to(recording)) for shot in shots for file in shot.files]
    inputs = [] if output is None else [recording]
    with results_in(folder, command="extract", files=[*sorted(names), *images], inputs=inputs, force=force):
        files: dict[str, Any] = {
            name: written_later(partial(read_bytes, recording / name, IMAGE_BYTES)) for name in images
        }
        if to_scan:
            staged = folder / f"{STAGED}{STRIPES}"
            result, summary = _stripes(dataset, staged, terminal)
            files[STRIPES] = staged
        else:
            dataset, result, summary = _points(dataset, terminal)
        if output is not None:
            files |= texts_of(dataset)
        elif not to_scan:
            files |= point_texts(dataset)
        write_results(folder, files)
        wrote = " and ".join([f"Wrote {folder / main}", *others])
        terminal.show(result | {"file": str(folder / main)}, lambda: say(f"{summary}. {wrote}"))


def _points(recording: "Dataset", terminal: Terminal) -> tuple["Dataset", dict[str, Any], str]:
    """The data set with the points of its images, and the result as JSON and in words."""
    from robolaser.vision.extract import Extraction
    from robolaser.vision.recordings import points_of_images

    with terminal.progress() as progress:
        found, dataset = points_of_images(recording, progress=progress)
    if recording.placed:
        terminal.warn(
            "the board's frame is taken for the robot's base frame, since [target] placed is true: state placed = false"
            " in dataset.toml, unless the board defines that frame."
        )
    frames = found.frames if isinstance(found, Extraction) else found
    titles = {"off board [px]": "corner_rms_px"}
    titles |= {"off line [px]": "line_rms_px"} if isinstance(found, Extraction) else {}
    terminal.print(f"{'image':<16} {'points':>6}  {'  '.join(titles)}")
    for frame in frames:
        figures = "  ".join(f"{getattr(frame, name):>{len(title)}.2f}" for title, name in titles.items())
        row = f"  skipped: {frame.skipped}" if frame.skipped else f"{frame.points:>6}  {figures}"
        terminal.print(f"{frame.pose:<16} {row}")
    skipped = {frame.pose: frame.skipped for frame in frames if frame.skipped}
    images, points = len(frames) - len(skipped), len(dataset.points)
    result = {"points": points, "images": images, "skipped": skipped}
    if not isinstance(found, Extraction):
        return dataset, result, f"{points} points from {images} images, {len(skipped)} skipped"
    if not found.lens.known:
        terminal.warn("the views do not determine the lens distortion: planes were fitted to raw pixels.")
    if found.channel != "grey":
        terminal.print(f"The stripe was detected in the channel {found.channel}.")
    terminal.warn(*found.doubts)
    corners, noise_px = points - len(found), float(found.pixel_noise_px)
    result |= {"points": len(found), "corners": corners, "pixel_noise_px": noise_px}
    of_both = f"{len(found)} points and {corners} corners from {images} images, {len(skipped)} skipped"
    return dataset, result, f"{of_both}; stripe noise {noise_px:.2f} px"


def _stripes(recording: "Dataset", file: Path, terminal: Terminal) -> tuple[dict[str, Any], str]:
    """Write the line centres of all images; the result as JSON and in words."""
    from robolaser.data.stripe_file import write_stripes
    from robolaser.vision.recordings import stripes_from_images

    images = blank = 0

    def counted(blocks: "Iterator[Stripes]") -> "Iterator[Stripes]":
        nonlocal images, blank
        for block in blocks:
            images += 1
            blank += not len(block)
            yield block

    with terminal.progress() as progress:
        centres = write_stripes(file, counted(stripes_from_images(recording, progress=progress)))
    result = {"centres": centres, "images": images - blank, "without_stripe": blank}
    return result, f"{centres} centres from {images - blank} images, {blank} without a stripe"
