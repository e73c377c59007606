"""A scene as a still picture, for those whose browser runs no scripts: as `scenes.js` shows it at first, as SVG."""

from collections.abc import Callable, Iterator
from typing import Final

import numpy as np
from markupsafe import Markup, escape

from robolaser.arrays import Array
from robolaser.report.scene import Scene, Shape

SIZE: Final = np.array([900.0, 440.0])
TURN, RISE, PERSPECTIVE, FILLED = -0.9, 0.35, 0.35, 0.86
"""Where one looks from, as in `scenes.js`."""
MOST_DOTS: Final = 2000
Seen = Callable[[Array], Array]


def still(scene: Scene) -> Markup:
    """The scene as SVG, in the frame and the magnification that it starts with."""
    shapes = [shape for shape in scene.shapes if len(shape["at"])]
    seen = _view(np.concatenate([_places(shape).reshape(-1, 3) for shape in shapes]))
    marks = "".join(mark for shape in shapes for mark in _marks(shape, seen, scene))
    box = f'viewBox="0 0 {SIZE[0]:.0f} {SIZE[1]:.0f}" role="img" font-size="13" font-family="sans-serif"'
    return Markup(f'<svg {box} width="100%" stroke-linecap="round">{marks}</svg>')


def _places(shape: Shape) -> Array:
    return np.array(shape["at"], np.float64)


def _view(places: Array) -> Seen:
    """What puts places (..., 3) [mm] onto the picture, (..., 2), so that all are in view."""
    low, high = np.nanmin(places, axis=0), np.nanmax(places, axis=0)
    size = float(np.linalg.norm(high - low)) or 1.0
    c, s, up, down = np.cos(TURN), np.sin(TURN), np.cos(RISE), np.sin(RISE)

    def turned(p: Array) -> Array:
        x, y, z = np.moveaxis(p - (low + high) / 2, -1, 0)
        away = c * y - s * x
        near = 1.0 / (1.0 + PERSPECTIVE * (away * up - z * down) / size)
        return np.stack([near * (c * x + s * y), -near * (z * up + away * down)], axis=-1)

    flat = turned(places)
    first, last = np.nanmin(flat, axis=0), np.nanmax(flat, axis=0)
    scale = FILLED * float(np.min(SIZE / np.maximum(last - first, 1e-9)))
    return lambda p: SIZE / 2 + scale * (turned(p) - (first + last) / 2)


def _marks(shape: Shape, seen: Seen, scene: Scene) -> Iterator[str]:
    places, colour = _places(shape), shape["colour"]
    if places.ndim == 3:
        places = places[scene.start if len(places) > 1 else 0]
    at = seen(places)
    there = np.isfinite(at).all(axis=1)
    match shape["kind"]:
        case "path" if there.any():
            line = "L".join(f"{x:.1f} {y:.1f}" for x, y in at[there])
            look = (
                f'fill="{colour}"'
                if shape["closed"]
                else f'fill="none" stroke="{colour}" stroke-width="{shape["width"]}"'
            )
            yield f'<path d="M{line}" {look} opacity="{shape["opacity"]}"/>'
        case "dots":
            rows = np.flatnonzero(there)[:: 1 + len(at) // MOST_DOTS]
            colours = [colour] * len(at) if isinstance(colour, str) else colour
            for shade in dict.fromkeys(colours[row] for row in rows):
                dots = "".join(f"M{x:.1f} {y:.1f}h0" for x, y in at[[row for row in rows if colours[row] == shade]])
                yield f'<path d="{dots}" stroke="{shade}" stroke-width="{shape["size"]}"/>'
        case "arrows":
            ends = seen(places + scene.magnification * np.array(shape["by"], np.float64))
            pairs = np.hstack([at, ends])[there & np.isfinite(ends).all(axis=1)]
            lines = "".join(f"M{x:.1f} {y:.1f}L{to:.1f} {down:.1f}" for x, y, to, down in pairs)
            yield f'<path d="{lines}" stroke="{colour}"/>'
        case "labels":
            for (x, y), name in zip(at[there], np.array(shape["names"])[there], strict=True):
                yield f'<circle cx="{x:.1f}" cy="{y:.1f}" r="{shape["size"]}" fill="{colour}"/>'
                if shape["bold"]:
                    halo = 'stroke="var(--paper)" stroke-width="3" paint-order="stroke"'
                    yield f'<text x="{x + 10:.1f}" y="{y + 4:.1f}" fill="{colour}" {halo}>{escape(name)}</text>'
