"""Text that is safe to print: data never reach a terminal as control sequences."""

import re

_COMMANDS = re.compile("[\x00-\x08\x0b-\x1f\x7f-\x9f\u202a-\u202e\u2066-\u2069]")
"""Control characters except tab and line feed, and those that change the direction of writing."""

_LONG_WORDS = re.compile(r"(\S{400})\S+")


def printable(text: str) -> str:
    r"""Text with control characters escaped, as \u001b: the same text in JSON."""
    return _COMMANDS.sub(lambda found: f"\\u{ord(found[0]):04x}", text)


def short(sentence: str) -> str:
    """A sentence with words truncated to the length of a line or a path: a cell or a key may have megabytes."""
    return _LONG_WORDS.sub(r"\1...", sentence)
