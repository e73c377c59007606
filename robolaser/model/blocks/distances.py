"""Known distances of all blocks: rows of their own in every fit."""

from robolaser.model.blocks.block import Block
from robolaser.model.blocks.blocks import Blocks
from robolaser.model.sensors.known_distances import KnownDistances


def known_distances(blocks: Blocks) -> KnownDistances | None:
    """Rows of their own that state distances between named points, each once; None where there are none."""
    rows, noise = {}, blocks.dataset.noise
    for block in blocks:
        for one, other, distance in block.sensor.dataset.distances_m:
            first, second = _place(block, one), _place(block, other)
            if first and second:
                rows[first, second], noise = distance, block.sensor.dataset.noise
    return KnownDistances.of([(*key, distance) for key, distance in rows.items()], noise) if rows else None


def _place(block: Block, point: str) -> tuple[str, ...]:
    """The problem's names of the parameters that hold a named point's place; none where it has no such point."""
    own = (f"{block.sensor.format.named_points}.{point}.{part}" for part in "xyz")
    return tuple(block.named[name] for name in own if name in block.named)
