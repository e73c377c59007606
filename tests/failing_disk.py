"""A disk that is observed, or fails, at each change below a folder: a file opened, flushed, renamed, removed."""

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
    """The path that an event changes, or None."""
    if event == "open":
        return args[0] if not isinstance(args[0], int) and args[2] & _WRITES else None
    return args[1] if event == "os.rename" else args[0] if event in _FIRST else None


@contextmanager
def watched(folder, notify):
    """Call `notify` with the kind of each change below a folder, before it happens."""
    global _watch
    whole, flush = str(folder), os.fsync

    def seen(event, args):
        path = _changed(event, args)
        if path is not None and os.path.abspath(os.fsdecode(path)).startswith(whole):
            notify(event)

    def fsync(descriptor):
        notify("fsync")
        flush(descriptor)

    _watch, os.fsync = seen, fsync
    try:
        yield
    finally:
        _watch, os.fsync = None, flush


def failing(number, kind):
    """A callback for `watched` that makes the disk full or read-only from the change of that number on."""
    count = 0

    def notify(event):
        nonlocal count
        count += 1
        if count > number and (kind == errno.EROFS or event in _GROWS):
            raise OSError(kind, os.strerror(kind))

    return notify


def contents(folder: Path):
    """All files below a folder, by name."""
    return {str(file.relative_to(folder)): file.read_bytes() for file in folder.rglob("*") if file.is_file()}


def restore(folder: Path, files):
    """Restore exactly these files in a folder."""
    for name in contents(folder).keys() - files.keys():
        (folder / name).unlink()
    for name, data in files.items():
        (folder / name).parent.mkdir(parents=True, exist_ok=True)
        (folder / name).write_bytes(data)
