"""Residual blocks: the rows of every sensor in every session, one after the other in one problem."""

from robolaser.model.blocks.block import Block, blocks_of
from robolaser.model.blocks.blocks import Blocks

__all__ = ["Block", "Blocks", "blocks_of"]
