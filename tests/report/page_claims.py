"""Properties of every page."""

import json
import re
from html.parser import HTMLParser

HOSTILE = "<script>alert('$x_$')</script> & \"quotes\" $\\frac$ 測定\x07"
VOID = {"meta", "link", "br", "img", "hr", "input", "wbr"}


class Reader(HTMLParser):
    """Collects the elements, texts and scripts of a page."""

    def __init__(self, text):
        super().__init__()
        self.open, self.tags, self.links, self.ids, self.texts, self.scripts = [], [], [], [], [], []
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
        if tag == "script":
            self.scripts.append((dict(attrs), ""))

    def handle_startendtag(self, tag, attrs):
        self.handle_starttag(tag, attrs)
        if tag not in VOID:
            self.open.pop()

    def handle_endtag(self, tag):
        assert self.open
        assert self.open.pop() == tag

    def handle_data(self, data):
        if self.open and self.open[-1] == "script":
            attributes, before = self.scripts[-1]
            self.scripts[-1] = attributes, before + data
        else:
            self.texts.append(data)

    @property
    def programs(self):
        """Scripts that a browser runs."""
        return [text for attributes, text in self.scripts if "type" not in attributes]


def needs_nothing_from_elsewhere(text):
    read = Reader(text)
    assert all(link.startswith(("#", "data:")) for link in read.links)
    assert not [tag for tag, _ in read.tags if tag in ("iframe", "object", "embed")]
    for program in read.programs:
        text = text.replace(program, "")
        assert "sourceMappingURL" not in program
    assert not re.search(r"url\((?!#)|@import", text)
    assert set(re.findall(r"https?://[^\"]*", text)) <= {"https://vega.github.io/schema/vega-lite/v6.json"}  # a name
    for spec in charts(read):
        assert '"url"' not in json.dumps(spec)


def is_small(text):
    assert len(text.encode()) < 3_000_000


def runs_only_our_own_scripts(text):
    programs = Reader(text).programs
    assert len(programs) in (3, 5)  # Vega, Vega-Lite, and ours
    assert not any("alert(" in program for program in programs)


def is_closed_and_its_ids_are_its_own(text):
    read = Reader(text)
    assert not read.open
    assert len(set(read.ids)) == len(read.ids)
    for link in read.links:
        assert not link.startswith("#") or link[1:] in read.ids


def is_whole(text):
    """A page can be mailed: it is self-contained, small, well-formed, and runs no foreign script."""
    needs_nothing_from_elsewhere(text)
    is_small(text)
    runs_only_our_own_scripts(text)
    is_closed_and_its_ids_are_its_own(text)


def said(text):
    """The readable text of a page, in one line."""
    return " ".join("".join(Reader(text).texts).split()).replace("\u2212", "-")


def charts(page):
    """The specifications of a page's charts."""
    return [one for one in _embedded(page if isinstance(page, Reader) else Reader(page)) if "layer" in one]


def scenes(page):
    """The scenes of a page."""
    return [one for one in _embedded(Reader(page)) if "shapes" in one]


def _embedded(read):
    return [json.loads(text) for attributes, text in read.scripts if "type" in attributes and "id" not in attributes]


def titled(text):
    """The specifications of a page's charts by their titles."""
    return dict(zip(re.findall(r'<figure class="chart">\s*<h3>(.*?)</h3>', text), charts(text), strict=True))


def sound_charts(text):
    """The charts of a page, each with named axes and units, tooltips, and a description."""
    found = charts(text)
    for spec in found:
        assert len(spec["description"]) > 20
        assert any("tooltip" in layer["encoding"] for layer in spec["layer"])
        for layer in spec["layer"]:
            assert layer["data"]["values"] or layer is not spec["layer"][0]
            for channel in ("x", "y"):
                axis = layer["encoding"].get(channel, {})
                assert axis.get("type") != "quantitative" or "title" in axis
    assert text.count("<figcaption>") == text.count("<noscript>") == len(found) + len(scenes(text))
    return found


def series(spec):
    """Entries of a chart's legend."""
    return next(layer["encoding"]["color"]["scale"]["domain"] for layer in spec["layer"]
                if layer["encoding"].get("color", {}).get("field") == "series")  # fmt: skip


def rows(spec):
    """All records of a chart."""
    return [row for layer in spec["layer"] for row in layer["data"]["values"]]


def hovered(spec):
    """Fields of a chart's tooltip."""
    return {channel["field"] for layer in spec["layer"] for channel in layer["encoding"].get("tooltip", [])}


def is_logarithmic(spec, channel):
    return any(layer["encoding"].get(channel, {}).get("scale", {}).get("type") == "log" for layer in spec["layer"])
