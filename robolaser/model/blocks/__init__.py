"""Residual blocks: the rows of every sensor in every session, one after the other in one problem."""

from robolaser.model.blocks.block import Block
from robolaser.model.blocks.blocks import Blocks
from robolaser.model.blocks.building import blocks_of

__all__ = ["Block", "Blocks", "blocks_of"]
