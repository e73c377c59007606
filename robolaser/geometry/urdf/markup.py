"""XML from strangers: read without document types, entities, or depths that break recursion."""

import io
import xml.etree.ElementTree as ET
from typing import final
from xml.sax import SAXParseException
from xml.sax.handler import ContentHandler, LexicalHandler, property_lexical_handler
from xml.sax.xmlreader import AttributesImpl, InputSource

from defusedxml import DefusedXmlException
from defusedxml.expatreader import DefusedExpatParser

from robolaser.bounded_reading import XML_ATTRIBUTES, XML_DEPTH
from robolaser.errors import RobotError


def read(text: str, source: str, most_bytes: int) -> ET.Element:
    """Parse XML, comments kept; neither the parser nor whoever walks the result can be made to run away.

    Args:
        text: The XML itself; an encoding it declares is passed over.
        source: What error messages call it.
        most_bytes: The length from which it is refused unread.

    Raises:
        RobotError: It is too long, too deep, declares a document type or an entity, is not well-formed or has
            characters that no text has.
    """
    if len(text) > most_bytes:
        raise too_large(source, "bytes", most_bytes)
    built = _Shallow(source)
    parser = DefusedExpatParser(forbid_dtd=True)
    parser.setContentHandler(built)
    parser.setProperty(property_lexical_handler, built)
    stream = InputSource(source)
    stream.setCharacterStream(io.StringIO(text))
    try:
        parser.parse(stream)
    except DefusedXmlException:
        raise RobotError(
            f"{source}, line {parser.getLineNumber()}: it declares a document type or entities, which no URDF needs and"
            " robolaser refuses. Remove it."
        ) from None
    except SAXParseException as fault:
        raise RobotError(
            f"{source}, line {fault.getLineNumber()}, column {(fault.getColumnNumber() or 0) + 1}: not well-formed XML"
            f" ({fault.getMessage()}). Is the file complete?"
        ) from None
    except UnicodeEncodeError as fault:
        raise no_text(source, f"character {fault.start}: {fault.reason}") from None
    return built.tree.close()


def too_large(source: str, what: str, limit: int) -> RobotError:
    """The error of more of something than any robot has."""
    return RobotError(f"{source} has more than {limit} {what}: too large for a robot. Is it the right file?")


def no_text(source: str, reason: str) -> RobotError:
    """The error of a file whose bytes are not the text they should be."""
    return RobotError(f"{source} cannot be read as UTF-8 text: {reason}. Save it as UTF-8.")


@final
class _Shallow(ContentHandler, LexicalHandler):
    """Builds a tree with its comments, of no more levels and attributes than a robot's description has."""

    def __init__(self, source: str) -> None:
        super().__init__()
        self.tree = ET.TreeBuilder(insert_comments=True)
        self._source, self._depth = source, 0

    def startElement(self, name: str, attrs: AttributesImpl) -> None:  # noqa: N802 - SAX's names
        self._depth += 1
        if self._depth > XML_DEPTH:
            raise too_large(self._source, "levels of nested elements", XML_DEPTH)
        if len(attrs) > XML_ATTRIBUTES:
            raise too_large(self._source, "attributes in one element", XML_ATTRIBUTES)
        self.tree.start(name, dict(attrs))

    def endElement(self, name: str) -> None:  # noqa: N802
        self._depth -= 1
        self.tree.end(name)

    def characters(self, content: str) -> None:
        self.tree.data(content)

    def comment(self, text: str) -> None:
        if self._depth:
            self.tree.comment(text)
