"""Untrusted XML: read without document types, and with limited depth; changed, and else left as written."""

import re
import xml.etree.ElementTree as ET
from collections.abc import Iterator, Mapping
from xml.parsers import expat
from xml.sax.saxutils import quoteattr

from robolaser.bounded_reading import XML_ATTRIBUTES, XML_DEPTH
from robolaser.errors import RobotError

_TAG = re.compile(
    r"""<!--.*?-->|<!\[CDATA\[.*?\]\]>|<\?.*?\?>"""
    r"""|<(?P<end>/?)(?P<name>[^\s/>]+)(?P<attributes>(?:[^"'>]|"[^"]*"|'[^']*')*?)\s*(?P<empty>/?)>""",
    re.DOTALL,
)
_ATTRIBUTE = re.compile(r"""(\s+)([^\s=]+)(\s*=\s*)("[^"]*"|'[^']*')""")


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


def with_changes(text: str, changed: ET.Element) -> str:
    """XML text in which only the attributes differ that its changed tree has otherwise, and elements are added.

    Args:
        text: As it was read.
        changed: Its tree, with other attributes, or with further elements as the last ones of others.
    """
    elements = _pairs(read(text, "", len(text)), changed)
    parts, done, further = list[str](), 0, list[list[str]]()
    for tag in _TAG.finditer(text):
        if tag["name"] is None:
            continue
        if tag["end"]:
            before = text[done : tag.start()].rstrip()
            space = text[done + len(before) : tag.start()]
            parts += before, *(f"{space}  {element}" for element in further.pop()), space
            done = tag.start()
            continue
        was, now = next(elements)
        added = [ET.tostring(child, encoding="unicode").strip() for child in now[len(was) :]]
        parts += text[done : tag.start("attributes")], _with_attributes(tag["attributes"], was.attrib, now.attrib)
        done = tag.end("attributes")
        if not tag["empty"]:
            further.append(added)
        elif added:
            parts += ">", *added, f"</{tag['name']}>"
            done = tag.end()
    return "".join([*parts, text[done:]]).lstrip()


def _pairs(was: ET.Element, now: ET.Element) -> Iterator[tuple[ET.Element, ET.Element]]:
    """Each element before and after, without comments, in the order of the text."""
    if isinstance(was.tag, str):
        yield was, now
        for pair in zip(was, now, strict=False):
            yield from _pairs(*pair)


def _with_attributes(written: str, was: Mapping[str, str], now: Mapping[str, str]) -> str:
    def replaced(found: re.Match[str]) -> str:
        space, name, equals, _ = found.groups()
        if name not in now:
            return ""
        return found[0] if now[name] == was[name] else f"{space}{name}{equals}{quoteattr(now[name])}"

    added = (f" {name}={quoteattr(value)}" for name, value in now.items() if name not in was)
    return "".join([_ATTRIBUTE.sub(replaced, written), *added])


def too_large(source: str, what: str, limit: int) -> RobotError:
    """The error of a count that no robot has."""
    return RobotError(f"{source} has more than {limit} {what}: too large for a robot. Is it the right file?")
