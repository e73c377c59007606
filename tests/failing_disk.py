"""A disk that is watched, or fails, at each change below a folder: a file opened, flushed, renamed, removed."""

import errno
import os
import sys
from contextlib import contextmanager
from pathlib import Path

_FIRST = {"os.remove", "os.rmdir", "os.mkdir", "os.chmod", "os.truncate", "os.utime"}
_WRITES = os.O_WRONLY | os.O_RDWR | os.O_CREAT | os.O_TRUNC
_GROWS = {"open", "os.mkdir", "fsync"}
_watch = None


def _hook(event, args):
    if _watch is not None:
        _watch(event, args)


sys.addaudithook(_hook)


def _changed(event, args):
    """What an event changes, as a path; None where it changes nothing."""
    if event == "open":
        return args[0] if not isinstance(args[0], int) and args[2] & _WRITES else None
    return args[1] if event == "os.rename" else args[0] if event in _FIRST else None


@contextmanager
def watched(folder, tell):
    """Call `tell` with the kind of each change below a folder, before it happens."""
    global _watch
    whole, flush = str(folder), os.fsync

    def seen(event, args):
        path = _changed(event, args)
        if path is not None and os.path.abspath(os.fsdecode(path)).startswith(whole):
            tell(event)

    def fsync(descriptor):
        tell("fsync")
        flush(descriptor)

    _watch, os.fsync = seen, fsync
    try:
        yield
    finally:
        _watch, os.fsync = None, flush


def failing(number, kind):
    """A `tell` that lets a disk be full, or no longer be written to, from the change of that number on."""
    count = 0

    def tell(event):
        nonlocal count
        count += 1
        if count > number and (kind == errno.EROFS or event in _GROWS):
            raise OSError(kind, os.strerror(kind))

    return tell


def contents(folder: Path):
    """All files below a folder, by name."""
    return {str(file.relative_to(folder)): file.read_bytes() for file in folder.rglob("*") if file.is_file()}


def restore(folder: Path, files):
    """Let a folder hold these files and no other."""
    for name in contents(folder).keys() - files.keys():
        (folder / name).unlink()
    for name, data in files.items():
        (folder / name).parent.mkdir(parents=True, exist_ok=True)
        (folder / name).write_bytes(data)
