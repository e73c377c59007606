"""Untrusted XML: read without document types, and with limited depth."""

import xml.etree.ElementTree as ET
from xml.parsers import expat

from robolaser.bounded_reading import XML_ATTRIBUTES, XML_DEPTH
from robolaser.errors import RobotError


def read(text: str, source: str, most_bytes: int) -> ET.Element:
    """Parse XML, comments kept, prefixes of names as they are written; empty lines may precede it.

    Args:
        text: The XML itself; an encoding that it declares is ignored.
        source: Its name in error messages.
        most_bytes: The length above which it is refused unread.

    Raises:
        RobotError: It is too long, too deep, declares a document type (and only there entities can be declared), is
            not well-formed or has characters that no text has.
    """
    if len(text) > most_bytes:
        raise too_large(source, "bytes", most_bytes)
    tree, depth = ET.TreeBuilder(insert_comments=True), 0
    parser, plain = expat.ParserCreate("UTF-8"), text.lstrip()
    lines_before = text[: len(text) - len(plain)].count("\n")

    def start(name: str, attributes: dict[str, str]) -> None:
        nonlocal depth
        depth += 1
        if depth > XML_DEPTH:
            raise too_large(source, "levels of nested elements", XML_DEPTH)
        if len(attributes) > XML_ATTRIBUTES:
            raise too_large(source, "attributes in one element", XML_ATTRIBUTES)
        tree.start(name, attributes)

    def end(name: str) -> None:
        nonlocal depth
        depth -= 1
        tree.end(name)

    def comment(content: str) -> None:
        if depth:
            tree.comment(content)

    def document_type(*_: object) -> None:
        line = lines_before + parser.CurrentLineNumber
        raise RobotError(
            f"{source}, line {line}: it declares a document type, which no URDF needs and robolaser refuses. Remove it."
        )

    parser.StartElementHandler, parser.EndElementHandler = start, end
    parser.CharacterDataHandler, parser.CommentHandler = tree.data, comment
    parser.StartDoctypeDeclHandler = document_type
    try:
        parser.Parse(plain.encode(), True)  # noqa: FBT003 - it is the whole text
    except expat.ExpatError as fault:
        raise RobotError(
            f"{source}, line {lines_before + fault.lineno}, column {fault.offset + 1}: not well-formed XML"
            f" ({expat.ErrorString(fault.code)}). Is the file complete?"
        ) from None
    except UnicodeEncodeError as fault:
        reason = f"character {fault.start}: {fault.reason}"
        raise RobotError(f"{source} cannot be read as UTF-8 text: {reason}. Save it as UTF-8.") from None
    return tree.close()


def too_large(source: str, what: str, limit: int) -> RobotError:
    """The error of a count that no robot has."""
    return RobotError(f"{source} has more than {limit} {what}: too large for a robot. Is it the right file?")
