"""robolaser extract: from images to points, or to the stripe's centres where there is no board."""

from collections.abc import Iterator, Sequence
from dataclasses import dataclass
from functools import partial
from pathlib import Path
from typing import TYPE_CHECKING, Annotated

from cyclopts import Parameter

from robolaser.commands.terminal import RESULT, TERMINAL, Force, Terminal, say

if TYPE_CHECKING:
    from robolaser.data.dataset import Dataset
    from robolaser.data.stripe_file import Stripes

POINTS, STRIPES, SETTINGS = "points.csv", "stripes.npy", "dataset.toml"


def extract(
    recording: Path,
    /,
    *,
    output: Annotated[Path | None, Parameter(metavar="DATASET", group=RESULT)] = None,
    force: Force = False,
    terminal: Terminal = TERMINAL,
) -> None:
    """Detect board and laser stripe, or a camera's target, in a recording's images, and write points.csv.

    A stripe scanner's board also gives corners.csv. A new data set has two
    sensors, stripe and camera, which are fitted together.

    Without [board], a stripe scanner's line centres in all images go to
    stripes.npy. Where poses.csv names an image with the laser off (image_off),
    the board is found there, and the stripe in the difference of both. For
    example:

        robolaser extract recording --output measured

    Args:
        recording: Folder with dataset.toml, poses.csv and images.
        output: Folder for a new data set with images and noise. Default: only add points to RECORDING.
        force: Overwrite earlier points.
    """
    from robolaser.data.image_list import images_of_poses
    from robolaser.data.loading import load
    from robolaser.data.result_folder import results_in
    from robolaser.data.several_sensors import CORNERS
    from robolaser.data.writing import FOLDER
    from robolaser.model.sensors import sensor_class

    dataset = load(recording)
    has_stripe = sensor_class(dataset.kind).has_laser_plane()
    to_scan = has_stripe and dataset.board is None and dataset.poses.image is not None
    if output is not None and output.resolve() == recording.resolve():
        output = None
    both = has_stripe and not to_scan
    files = {STRIPES if to_scan else POINTS, *((CORNERS,) if both else ()), *(() if output is None else FOLDER)}
    shots = [] if output is None else images_of_poses(dataset)
    images = [str(file.relative_to(recording)) for shot in shots for file in shot.files]
    place = _Place(recording, output, images)
    with results_in(place.folder, command="extract", files=[*sorted(files), *images], force=force):
        (_stripes if to_scan else _points)(dataset, place, terminal)


@dataclass(frozen=True)
class _Place:
    """Where the points go: into the recording, or with it into a new data set."""

    recording: Path
    output: Path | None  # folder of the new data set; None: there is none
    images: Sequence[str]  # names of the images that the new data set has, too

    @property
    def folder(self) -> Path:
        return self.output or self.recording

    def write(self, dataset: "Dataset", stripes: Path | None = None) -> None:
        """Write a data set's points, or stripes, and all of it with its images where it is a new one."""
        from robolaser.bounded_reading import IMAGE_BYTES, read_bytes
        from robolaser.data.atomic_write import Contents, written_later
        from robolaser.data.result_folder import write_results
        from robolaser.data.writing import point_texts, texts_of

        copies = {name: written_later(partial(read_bytes, self.recording / name, IMAGE_BYTES)) for name in self.images}
        files: dict[str, str | Contents | None] = {**copies}
        if self.output is not None:
            files |= texts_of(dataset)
        elif stripes is None:
            files |= point_texts(dataset)
        write_results(self.folder, files if stripes is None else {**files, STRIPES: stripes})


def _points(recording: "Dataset", place: _Place, terminal: Terminal) -> None:
    from robolaser.vision.extract import Extraction
    from robolaser.vision.recordings import points_of_images

    with terminal.progress() as progress:
        found, dataset = points_of_images(recording, progress=progress)
    frames = found.frames if isinstance(found, Extraction) else found
    titles = {"board [px]": "corner_rms_px"} | ({"stripe [px]": "line_rms_px"} if isinstance(found, Extraction) else {})
    terminal.print(f"{'image':<16} {'points':>6}  {'  '.join(titles)}")
    for frame in frames:
        figures = "  ".join(f"{getattr(frame, name):>{len(title)}.2f}" for title, name in titles.items())
        said = f"  skipped: {frame.skipped}" if frame.skipped else f"{frame.points:>6}  {figures}"
        terminal.print(f"{frame.pose:<16} {said}")
    skipped = {frame.pose: frame.skipped for frame in frames if frame.skipped}
    file, images, points = place.folder / POINTS, len(frames) - len(skipped), len(dataset.points)
    result: dict[str, object] = {"points": points, "images": images, "skipped": skipped, "file": str(file)}
    said = f"{points} points from {images} images, {len(skipped)} skipped. Wrote {file}"
    if isinstance(found, Extraction):
        if not found.lens.known:
            terminal.warn("the views do not determine the lens distortion: planes were fitted to raw pixels.")
        if found.channel != "grey":
            terminal.print(f"The stripe was detected in the channel {found.channel}.")
        terminal.warn(*found.doubts)
        corners, noise_px = points - len(found), float(found.pixel_noise_px)
        result |= {"points": len(found), "corners": corners, "pixel_noise_px": noise_px}
        said = (
            f"{len(found)} points and {corners} corners from {images} images, {len(skipped)} skipped; stripe noise"
            f" {noise_px:.2f} px. Wrote {file} and corners.csv"
        )
    place.write(dataset)
    terminal.show(result, lambda: say(said))


def _stripes(recording: "Dataset", place: _Place, terminal: Terminal) -> None:
    from robolaser.data.atomic_write import STAGED
    from robolaser.data.stripe_file import write_stripes
    from robolaser.vision.recordings import stripes_from_images

    file = place.folder / STRIPES
    images = blank = 0

    def counted(blocks: "Iterator[Stripes]") -> "Iterator[Stripes]":
        nonlocal images, blank
        for block in blocks:
            images += 1
            blank += not len(block)
            yield block

    staged = file.with_name(f"{STAGED}{STRIPES}")
    with terminal.progress() as progress:
        blocks = stripes_from_images(recording, progress=progress)
        centres = write_stripes(staged, counted(blocks))
    place.write(recording, staged)
    terminal.show(
        {"centres": centres, "images": images - blank, "without_stripe": blank, "file": str(file)},
        lambda: say(f"{centres} centres from {images - blank} images, {blank} without a stripe. Wrote {file}"),
    )
