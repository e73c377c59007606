"""robolaser extract: from images to points, or to the stripe's middles where there is no board."""

import argparse
import os
import shutil
from collections.abc import Iterator
from contextlib import contextmanager
from dataclasses import replace
from pathlib import Path
from typing import TYPE_CHECKING, ClassVar, final

from robolaser.commands.argument_types import count
from robolaser.commands.command import Command, make_folder, progress_bar, warn
from robolaser.errors import FileUnwritable, OutputExists, StoppedLate

if TYPE_CHECKING:
    from robolaser.data.dataset import Dataset
    from robolaser.data.stripe_file import Stripes

POINTS, STRIPES, SETTINGS = "points.csv", "stripes.npy", "dataset.toml"
CENTRES = ("mass", "gauss", "steger")


@final
class Extract(Command):
    """Finds board and stripe in every image of a recording."""

    name: ClassVar[str] = "extract"
    summary: ClassVar[str] = "find board and laser stripe in a recording's images and write points.csv"

    def declare(self, parser: argparse.ArgumentParser) -> None:
        """Say what can be given to it."""
        parser.description = (
            "Finds checkerboard and laser stripe in each image of a recording and writes points.csv. A recording "
            "without [board] is one to scan: the stripe's middles in every image go to stripes.npy. Images with the "
            "laser off (column image_off of poses.csv) take away what else is bright."
        )
        parser.add_argument(
            "recording", metavar="RECORDING", type=Path, help="folder with dataset.toml, poses.csv, images"
        )
        parser.add_argument(
            "--output",
            metavar="DATASET",
            type=Path,
            help="new data set, images copied, which states the stripe's noise; default: points go into RECORDING, and "
            "nothing else in it changes",
        )
        parser.add_argument("--step", metavar="LINES", type=count, help="lines of pixels from point to point")
        parser.add_argument(
            "--centre",
            choices=CENTRES,
            default="gauss",
            help="the stripe's middle is that of the best Gaussian (default), the centre of mass, or Steger's ridge, "
            "which smooths along the stripe",
        )
        parser.add_argument("--force", action="store_true", help="overwrite points that are there")

    def run(self, args: argparse.Namespace) -> None:
        """Extract, write, and say what became of each image."""
        from robolaser.data.loading import load  # noqa: PLC0415 - `--help` must not pay for physics

        recording = load(args.recording)
        to_scan = recording.board is None and recording.poses.image is not None
        result = STRIPES if to_scan else POINTS
        if args.output is not None and args.output.resolve() == args.recording.resolve():
            args.output = None
        new = () if args.output is None else (SETTINGS,)
        folder: Path = args.output or args.recording
        for file in (result, *new):
            if (folder / file).exists() and not args.force:
                raise OutputExists(folder / file)
        make_folder(folder)
        if to_scan:
            _stripes(recording, args)
        else:
            _points(recording, args)


def _points(recording: "Dataset", args: argparse.Namespace) -> None:
    from robolaser.data.writing import save, save_points  # noqa: PLC0415
    from robolaser.vision.recordings import points_from_images  # noqa: PLC0415

    with progress_bar() as progress:
        found, dataset = points_from_images(recording, step=args.step, centring=args.centre, progress=progress)
    print(f"{'image':<16} {'points':>6}  {'board [px]':>10}  {'stripe [px]':>11}")
    for frame in found.frames:
        if frame.skipped:
            print(f"{frame.pose:<16}   skipped: {frame.skipped}")
        else:
            print(f"{frame.pose:<16} {frame.points:>6}  {frame.corner_rms_px:>10.2f}  {frame.line_rms_px:>11.2f}")
    if not found.lens.known:
        warn("the views do not tell the lens's distortion: planes were laid through raw pixels.")
    if args.output is None:
        save_points(dataset, args.recording)
    else:
        with _told_if_stopped(f"a part of {args.output}", POINTS):
            _copy_images(recording, args.recording, args.output)
            save(_with_noise_stated(dataset, found.pixel_noise_px), args.output, overwrite=args.force)
    skipped = sum(bool(frame.skipped) for frame in found.frames)
    told = found.pixel_noise_px
    noise = f"{told:.2f} px" if told > 0 else "not known: neighbouring lines share it"
    print(
        f"{len(found)} points from {len(found.frames) - skipped} images, {skipped} skipped; "
        f"stripe noise {noise}. Wrote {(args.output or args.recording) / POINTS}"
    )


def _stripes(recording: "Dataset", args: argparse.Namespace) -> None:
    from robolaser.data.stripe_file import write_stripes  # noqa: PLC0415
    from robolaser.data.writing import save  # noqa: PLC0415
    from robolaser.vision.recordings import stripes_from_images  # noqa: PLC0415

    folder: Path = args.output or args.recording
    images = blank = 0

    def counted(blocks: "Iterator[Stripes]") -> "Iterator[Stripes]":
        nonlocal images, blank
        for block in blocks:
            images += 1
            blank += not len(block)
            yield block

    with progress_bar() as progress:
        blocks = stripes_from_images(recording, step=args.step, centring=args.centre, progress=progress)
        middles = write_stripes(folder / STRIPES, counted(blocks), overwrite=args.force)
    if args.output is not None:
        with _told_if_stopped(str(folder / STRIPES), "its poses and images"):
            _copy_images(recording, args.recording, folder)
            save(recording, folder, overwrite=args.force)
    print(f"{middles} middles from {images - blank} images, {blank} without a stripe. Wrote {folder / STRIPES}")


def _with_noise_stated(dataset: "Dataset", pixel_px: float) -> "Dataset":
    """The data set with the scatter of the stripe's middle as its pixel noise, unless it states one."""
    if dataset.noise.pixel_px is not None or not pixel_px > 0:
        return dataset
    return replace(dataset, noise=replace(dataset.noise, pixel_px=pixel_px))


def _copy_images(recording: "Dataset", source: Path, folder: Path) -> None:
    from robolaser.data.image_list import shots_of  # noqa: PLC0415

    for image in (file.relative_to(source) for shots in shots_of(recording) for file in shots.files):
        make_folder((folder / image).parent)
        try:
            shutil.copyfile(source / image, folder / image)
            taken = (source / image).stat()
            os.utime(folder / image, ns=(taken.st_atime_ns, taken.st_mtime_ns))  # not newer than the stripes
        except OSError as error:
            raise FileUnwritable(folder / image, error.strerror or str(error)) from None


@contextmanager
def _told_if_stopped(written: str, missing: str) -> Iterator[None]:
    try:
        yield
    except KeyboardInterrupt:
        raise StoppedLate(written, missing) from None
