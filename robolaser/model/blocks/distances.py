"""Known distances of all blocks: rows of their own in every fit."""

from robolaser.model.blocks.blocks import Blocks
from robolaser.model.sensors.known_distances import KnownDistances


def known_distances(blocks: Blocks) -> KnownDistances | None:
    """Rows of their own that state distances between named points, each once; None where there are none."""
    rows, noise = {}, blocks.dataset.noise
    for block in blocks:
        own = block.sensor.known_distances
        if own is not None:
            noise = block.sensor.dataset.noise
            for first, second, distance in zip(own.first, own.second, own.known.tolist(), strict=True):
                rows[tuple(block.named[name] for name in first), tuple(block.named[name] for name in second)] = distance
    return KnownDistances.of([(*key, distance) for key, distance in rows.items()], noise) if rows else None
