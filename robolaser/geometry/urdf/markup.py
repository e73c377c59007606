"""XML from strangers: read without document types, entities, or depths that break recursion."""

import io
import xml.etree.ElementTree as ET
from typing import Any
from xml.parsers import expat

from robolaser.errors import UrdfNotText, UrdfNotXml, UrdfTooLarge, UrdfUnsafe

MOST_NESTING = 60


def read(text: str, source: str, most_bytes: int) -> ET.Element:
    """Parse XML, comments kept; neither the parser nor whoever walks the result can be made to run away.

    Args:
        text: The XML itself; an encoding it declares is passed over.
        source: What error messages call it.
        most_bytes: The length from which it is refused unread.

    Raises:
        UrdfTooLarge: Too long or too deep.
        UrdfUnsafe: A document type or an entity is declared.
        UrdfNotXml: Not well-formed, with line and column.
        UrdfNotText: Characters that no text has.
    """
    if len(text) > most_bytes:
        raise UrdfTooLarge(source, "bytes", most_bytes)
    builder = ET.TreeBuilder(insert_comments=True)
    parser = expat.ParserCreate("utf-8")
    parser.buffer_text = True
    depth = 0

    def start(tag: str, attributes: dict[str, str]) -> None:
        nonlocal depth
        depth += 1
        if depth > MOST_NESTING:
            raise UrdfTooLarge(source, "levels of nested elements", MOST_NESTING)
        builder.start(tag, attributes)

    def end(tag: str) -> None:
        nonlocal depth
        depth -= 1
        builder.end(tag)

    def comment(said: str) -> None:
        if depth:
            builder.comment(said)

    def refuse(*_: object) -> Any:
        raise UrdfUnsafe(source, parser.CurrentLineNumber, "it declares a document type or entities")

    parser.StartElementHandler = start
    parser.EndElementHandler = end
    parser.CharacterDataHandler = builder.data
    parser.CommentHandler = comment
    parser.StartDoctypeDeclHandler = refuse
    parser.EntityDeclHandler = refuse
    parser.UnparsedEntityDeclHandler = refuse
    parser.ExternalEntityRefHandler = refuse
    try:
        parser.ParseFile(io.BytesIO(text.encode()))
    except expat.ExpatError as fault:
        raise UrdfNotXml(source, fault.lineno, fault.offset + 1, expat.ErrorString(fault.code)) from None
    except UnicodeEncodeError as fault:
        raise UrdfNotText(source, f"character {fault.start}: {fault.reason}") from None
    return builder.close()
