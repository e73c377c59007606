"""What every page promises to whoever opens it."""

import re
import xml.etree.ElementTree as ET
from html.parser import HTMLParser

HOSTILE = "<script>alert('$x_$')</script> & \"quotes\" $\\frac$ 測定\x07"
VOID = {"meta", "link", "br", "img", "hr", "input"}


class Reader(HTMLParser):
    """Collects what matters of a page."""

    def __init__(self, text):
        super().__init__()
        self.open, self.tags, self.links, self.ids, self.texts = [], [], [], [], []
        self.feed(text)
        self.close()

    def handle_starttag(self, tag, attrs):
        self.tags.append((tag, dict(attrs)))
        self.links += [
            value for name, value in attrs if name in ("src", "href", "xlink:href", "srcset", "action", "data")
        ]
        self.ids += [value for name, value in attrs if name == "id"]
        if tag not in VOID:
            self.open.append(tag)

    def handle_startendtag(self, tag, attrs):
        self.handle_starttag(tag, attrs)
        if tag not in VOID:
            self.open.pop()

    def handle_endtag(self, tag):
        assert self.open
        assert self.open.pop() == tag

    def handle_data(self, data):
        self.texts.append(data)


def needs_nothing_from_elsewhere(text):
    read = Reader(text)
    assert all(link.startswith(("#", "data:")) for link in read.links)
    assert not re.search(r"url\((?!#)|@import", text)
    assert not [tag for tag, _ in read.tags if tag in ("script", "iframe", "object", "embed")]
    assert not re.findall(r"https?://(?!www\.w3\.org/)", text)
    assert len(text.encode()) < 3_000_000


def is_closed_and_its_ids_are_its_own(text):
    read = Reader(text)
    assert not read.open
    assert len(set(read.ids)) == len(read.ids)
    for link in read.links:
        assert not link.startswith("#") or link[1:] in read.ids


def sound_pictures(text):
    """The pictures of a page, each of which is sound and says what it shows."""
    pictures = re.findall(r"<svg role.*?</svg>", text, flags=re.DOTALL)
    for picture in pictures:
        root = ET.fromstring(picture.replace("<svg ", '<svg xmlns:xlink="http://www.w3.org/1999/xlink" ', 1))
        assert len(root.get("aria-label")) > 20
    assert text.count("<figcaption>") == len(pictures)
    return pictures
