"""What is written to a file of stripes, against what is read from it."""

import numpy as np
import pytest

from robolaser.data.stripe_file import STRIPE, open_stripes, write_stripes
from robolaser.errors import DataError


def block(count, seed=0):
    rng = np.random.default_rng(seed)
    made = np.zeros(count, STRIPE)
    made["pose"] = np.sort(rng.integers(0, 2**32, count, dtype=np.uint32))
    for name in ("u", "v", "std", "intensity"):
        made[name] = rng.uniform(0, 500, count)
    return made


def test_what_was_written_is_read(tmp_path):
    blocks = [block(3, 1), block(0), block(70_000, 2)]
    assert write_stripes(tmp_path / "s.npy", iter(blocks)) == 70_003
    read = open_stripes(tmp_path / "s.npy")
    assert isinstance(read, np.memmap)  # nothing is copied
    for found in (read, np.load(tmp_path / "s.npy")):
        np.testing.assert_array_equal(found, np.concatenate(blocks))


def test_a_scan_without_a_stripe_is_a_file_of_none(tmp_path):
    assert write_stripes(tmp_path / "s.npy", []) == 0
    assert len(open_stripes(tmp_path / "s.npy")) == 0


def test_a_source_that_breaks_off_leaves_what_was_there(tmp_path):
    def broken():
        yield block(5)
        raise KeyboardInterrupt

    write_stripes(tmp_path / "s.npy", [block(7)])
    with pytest.raises(KeyboardInterrupt):
        write_stripes(tmp_path / "s.npy", broken())
    assert len(open_stripes(tmp_path / "s.npy")) == 7
    assert [path.name for path in tmp_path.iterdir()] == ["s.npy"]


def test_a_file_that_was_cut_off_is_refused(tmp_path):
    write_stripes(tmp_path / "s.npy", [block(100)])
    (tmp_path / "s.npy").write_bytes((tmp_path / "s.npy").read_bytes()[:-1])
    with pytest.raises(DataError, match="no whole file of NumPy"):
        open_stripes(tmp_path / "s.npy")


def test_less_than_nothing_is_refused(tmp_path):
    with (tmp_path / "s.npy").open("wb") as file:
        header = {"descr": np.lib.format.dtype_to_descr(STRIPE), "fortran_order": False, "shape": (-3,)}
        np.lib.format.write_array_header_1_0(file, header)
        file.write(bytes(1000))
    with pytest.raises(DataError, match="negative dimensions"):
        open_stripes(tmp_path / "s.npy")


@pytest.mark.parametrize("array", [np.zeros(4), np.zeros((2, 2), STRIPE), np.zeros(3, STRIPE.newbyteorder(">"))])
def test_another_kind_of_array_is_refused(array, tmp_path):
    np.save(tmp_path / "s.npy", array)
    with pytest.raises(DataError, match="extract"):
        open_stripes(tmp_path / "s.npy")
