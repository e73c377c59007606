"""robolaser extract: from images to points."""

import argparse
import shutil
from collections.abc import Sequence
from dataclasses import replace
from pathlib import Path
from typing import TYPE_CHECKING, ClassVar, final

from robolaser.commands.command import Command, count, make_folder, progress_bar, warn
from robolaser.errors import FileUnwritable, OutputExists

if TYPE_CHECKING:
    from robolaser.dataset import Dataset

POINTS = "points.csv"


@final
class Extract(Command):
    """Finds board and stripe in every image of a recording."""

    name: ClassVar[str] = "extract"
    summary: ClassVar[str] = "find board and laser stripe in a recording's images and write points.csv"

    def declare(self, parser: argparse.ArgumentParser) -> None:
        """Say what can be given to it."""
        parser.add_argument(
            "recording", metavar="RECORDING", type=Path, help="folder with dataset.toml, poses.csv, images"
        )
        parser.add_argument(
            "--output", metavar="DATASET", type=Path, help="new data set; default: points.csv in RECORDING"
        )
        parser.add_argument("--step", metavar="LINES", type=count, help="lines of pixels from point to point")
        parser.add_argument("--force", action="store_true", help="overwrite points that are there")

    def run(self, args: argparse.Namespace) -> None:
        """Extract, write, and say what became of each image."""
        from robolaser.folder import load  # noqa: PLC0415 - `--help` must not pay for physics
        from robolaser.recording import points_from_images  # noqa: PLC0415
        from robolaser.saving import save, save_points  # noqa: PLC0415

        folder: Path = args.output or args.recording
        if (folder / POINTS).exists() and not args.force:
            raise OutputExists(folder / POINTS)
        recording = load(args.recording)
        with progress_bar() as progress:
            found, dataset = points_from_images(recording, step=args.step, progress=progress)
        print(f"{'image':<16} {'points':>6}  {'board [px]':>10}  {'stripe [px]':>11}")
        for frame in found.frames:
            if frame.skipped:
                print(f"{frame.pose:<16}   skipped: {frame.skipped}")
            else:
                print(f"{frame.pose:<16} {frame.points:>6}  {frame.corner_rms_px:>10.2f}  {frame.line_rms_px:>11.2f}")
        if not found.lens.known:
            warn("the views do not tell the lens's distortion: planes were laid through raw pixels.")
        if args.output is None:
            save_points(dataset, folder)
        else:
            _copy_images(args.recording, folder, dataset.poses.image or ())
            save(_with_noise_stated(dataset, found.pixel_noise_px), folder, overwrite=args.force)
        skipped = sum(bool(frame.skipped) for frame in found.frames)
        print(
            f"{len(found)} points from {len(found.frames) - skipped} images, {skipped} skipped; "
            f"stripe noise {found.pixel_noise_px:.2f} px. Wrote {folder / POINTS}"
        )


def _with_noise_stated(dataset: "Dataset", pixel_px: float) -> "Dataset":
    """The data set with the scatter of the stripe's middle as its pixel noise, unless it states one."""
    if dataset.noise.pixel_px is not None or not pixel_px > 0:
        return dataset
    return replace(dataset, noise=replace(dataset.noise, pixel_px=pixel_px))


def _copy_images(source: Path, folder: Path, images: Sequence[str]) -> None:
    for image in images:
        if image:
            make_folder((folder / image).parent)
            try:
                shutil.copyfile(source / image, folder / image)
            except OSError as error:
                raise FileUnwritable(folder / image, error.strerror or str(error)) from None
