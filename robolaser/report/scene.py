"""Scenes in space that a reader can turn and step through pose by pose, with labels."""

from collections.abc import Mapping, Sequence
from dataclasses import dataclass, field
from typing import Any, Final, final

import numpy as np

from robolaser.arrays import Array
from robolaser.report.chart import embedded

DECIMALS: Final = 2  # of millimetres
LONG = 0.08  # of what is shown: a long arrow
Shape = Mapping[str, Any]


@final
@dataclass(frozen=True)
class Scene:
    """Shapes in space."""

    title: str  # a few words
    caption: str  # what it shows and what to look for
    alt: str  # its content in a sentence
    shapes: Sequence[Shape]  # from the functions below
    frames: Sequence[str] = ()  # names of the poses through which the moving shapes go
    magnification: float = 0.0  # of errors, at first; 0 without errors
    in_photos: float = 1.0  # of errors in the photos, at first
    photos: Mapping[str, Shape] = field(default_factory=dict)  # by the name of a pose

    @property
    def json(self) -> str:
        """All of it as text for a script element."""
        return embedded(
            {"alt": self.alt, "shapes": self.shapes, "frames": self.frames,
             "magnification": self.magnification, "inPhotos": self.in_photos, "photos": self.photos}
        )  # fmt: skip


def path(
    places: Array, colour: str, *, width: float = 1.0, radius: float = 0.0, closed: bool = False, opacity: float = 1.0
) -> Shape:
    """A line through points (k, 3), or points of each frame, (n, k, 3) [m]; filled if closed.

    It is `width` pixels wide, with a radius [m] at least as wide as a round bar of it appears.
    """
    of_frames = places if places.ndim == 3 else places[None]
    return {"kind": "path", "at": _listed(of_frames), "colour": colour, "width": width, "closed": closed,
            "opacity": opacity, "radius": 1e3 * radius}  # fmt: skip


def dots(
    places: Array,
    colour: str | Sequence[str],
    names: Sequence[str] = (),
    frames: Sequence[int] = (),
    *,
    size: float = 2.0,
) -> Shape:
    """Dots (m, 3) [m] of one colour, or one each; pale except in their frames, if any."""
    return {"kind": "dots", "at": _listed(places), "colour": colour, "names": names, "of": frames, "size": size}


def arrows(
    places: Array, errors: Array, colour: str, names: Sequence[str], frames: Sequence[int] = (), *, series: str
) -> Shape:
    """Errors (m, 3) [m] at points (m, 3) [m], to be magnified; a series that can be switched."""
    return {"kind": "arrows", "at": _listed(places), "by": _listed(errors, 1e3, 4), "colour": colour, "names": names,
            "of": frames, "series": series}  # fmt: skip


def labels(places: Array, names: Sequence[str], colour: str, *, size: float = 5.0, bold: bool = True) -> Shape:
    """Named marks (k, 3), or others in each frame, (n, k, 3) [m]."""
    of_frames = places if places.ndim == 3 else places[None]
    return {"kind": "labels", "at": _listed(of_frames), "names": names, "colour": colour, "size": size, "bold": bold}


def photo(source: str, size_px: tuple[int, int], points: Array, misses: Array, names: Sequence[str]) -> Shape:
    """The image of a pose as a data URI, small enough for a page, with named points that were extracted from it.

    Points and the way from these to the predicted ones, NaN where there are none, are in pixels of the original image,
    (m, 2) each [px].
    """
    seen, off = _listed(points, 1.0), _listed(misses, 1.0, 3)
    return {"source": source, "size": size_px, "points": seen, "misses": off, "names": names}


def magnification(error: float, extent: float) -> float:
    """The factor, 1, 2 or 5 times a power of ten, that shows an error as a long arrow."""
    if error <= 0 or extent <= 0:
        return 1.0
    wanted = np.log10(LONG * extent / error)
    power = np.floor(wanted)
    step = max((one for one in (1.0, 2.0, 5.0) if np.log10(one) <= wanted - power + 1e-9), default=1.0)
    return float(step * 10.0**power)


def _listed(values: Array, factor: float = 1e3, decimals: int = DECIMALS) -> list[Any]:
    """Numbers in millimetres as lists; null where they are unknown."""
    rounded = np.round(factor * values, decimals).astype(object)
    rounded[~np.isfinite(values)] = None
    return list(rounded.tolist())
