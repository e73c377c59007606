"""Stripes on disk: all line centres in a recording's images, in one array that is never in memory as a whole.

`stripes.npy` is an array in NumPy's format, little-endian, one entry a line centre, in the order of the poses and then
along the stripe.
"""

import io
import warnings
from collections.abc import Iterable
from pathlib import Path

import numpy as np
from numpy.lib import format as npy
from numpy.typing import NDArray

from robolaser.bounded_reading import CLOUD_BYTES, opened
from robolaser.data.result_folder import write_streamed
from robolaser.errors import DataError, unreadable

FILE = "stripes.npy"  # its name in the recording's folder
STRIPE = np.dtype([("pose", "<u4"), ("u", "<f4"), ("v", "<f4"), ("std", "<f4"), ("intensity", "<f4")])
"""Row of poses.csv, the first is 0; the distorted line centre [px]; its standard deviation across the stripe [px]; and
its grey above the background at the peak, 0 to 255. Twenty bytes."""

Stripes = NDArray[np.void]


def open_stripes(path: Path) -> Stripes:
    """Map a file of stripes into memory, to be read piece by piece, (n,) of STRIPE."""
    with opened(path, CLOUD_BYTES), warnings.catch_warnings(action="ignore"):  # of headers that an old Python wrote
        try:
            found = np.load(path, mmap_mode="r", allow_pickle=False)
        except Exception as error:  # of any type for a damaged header
            raise unreadable(path, f"it is no whole file of NumPy's ({error})") from None
    if not isinstance(found, np.ndarray) or found.dtype != STRIPE or found.ndim != 1:
        raise DataError(
            f"{path} holds no line centres, {STRIPE} (n,). Write it again with `robolaser extract --force`.", file=path
        )
    return found


def write_stripes(path: Path, blocks: Iterable[Stripes]) -> int:
    """Write line centres, pieces (n,) of STRIPE in order, completely or not at all, and return their number."""
    return write_streamed(path, _announced, (np.asarray(block, STRIPE) for block in blocks))


def _announced(count: int) -> bytes:
    """NumPy's header, which it fills up to one length for every count."""
    head = io.BytesIO()
    npy.write_array_header_1_0(head, {"descr": npy.dtype_to_descr(STRIPE), "fortran_order": False, "shape": (count,)})
    return head.getvalue()
