"""Texts and bytes with parts removed, doubled or replaced, drawn by hypothesis."""

from hypothesis import strategies as st

SIGNS = st.sampled_from([*"\"'\n,.-e[]{}=<>\x00\x1bé", "9" * 400, "0x" + "f" * 5000])


@st.composite
def damaged(draw, text):
    """A text with parts removed, doubled or replaced."""
    for _ in range(draw(st.integers(1, 4))):
        start = draw(st.integers(0, len(text)))
        end = min(len(text), start + draw(st.integers(0, 12)))
        text = text[:start] + draw(SIGNS | st.text(max_size=4) | st.just(text[start:end] * 2)) + text[end:]
    return text


@st.composite
def damaged_bytes(draw, data):
    """Damaged bytes, mostly near their beginning, where formats have headers; some are truncated."""
    for _ in range(draw(st.integers(1, 4))):
        start = draw(st.integers(0, min(200, len(data))) | st.integers(0, len(data)))
        end = min(len(data), start + draw(st.integers(0, 12)))
        data = data[:start] + draw(st.binary(max_size=8) | st.just(data[start:end] * 2)) + data[end:]
    return data[: draw(st.integers(0, len(data)))] if draw(st.integers(0, 4)) == 0 else data
