"""What reading a damaged file of NumPy's raises: its header is Python, and an archive of them a zip file."""

import struct
import tokenize
import zipfile
import zlib

DAMAGE = (
    OSError,
    EOFError,
    ValueError,
    KeyError,
    TypeError,
    AttributeError,
    OverflowError,
    MemoryError,
    RuntimeError,
    SyntaxError,
    struct.error,
    tokenize.TokenError,
    zipfile.BadZipFile,
    zlib.error,
)
