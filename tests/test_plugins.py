"""A family of ours takes in what installed packages announce to it, by either kind of name."""

from pathlib import Path

import pytest
from installed import installed

from robolaser.errors import DependencyMissing, PluginError
from robolaser.plugins import announced, extra


class Family:
    name: str


@pytest.fixture
def folder(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> Path:
    """A place where Python finds packages, with one that announces two members of a family."""
    code = "from test_plugins import Family\n\nclass B(Family): name = 'bee'\n\nclass A(Family): name = 'ant'\n"
    announced = "[our.members]\nfirst = two_members:B\nsecond = two_members:A\n"
    installed(tmp_path, "two_members", code, announced, package="two-members")
    monkeypatch.syspath_prepend(tmp_path)
    return tmp_path


@pytest.mark.usefixtures("folder")
def test_members_come_in_the_order_of_their_names():
    assert list(announced("our.members", Family, taken=())) == ["ant", "bee"]


@pytest.mark.usefixtures("folder")
def test_where_a_class_has_no_name_the_entry_point_has_one():
    found = announced("our.members", Family, taken=(), name="")
    assert [(key, member.name) for key, member in found.items()] == [("first", "bee"), ("second", "ant")]


@pytest.mark.usefixtures("folder")
def test_a_member_of_another_family_is_refused():
    with pytest.raises(PluginError, match=r"two_members:B under our\.members.* not a subclass of"):
        announced("our.members", Path, taken=(), name="")


@pytest.mark.usefixtures("folder")
def test_a_taken_name_is_refused_and_both_owners_are_named():
    with pytest.raises(PluginError, match=r"two-members announces .* as the member 'ant', but robolaser has one"):
        announced("our.members", Family, taken=["ant"])


def test_a_group_that_nobody_announces_to_is_empty():
    assert announced("our.strangers", Family, taken=()) == {}


def test_a_package_that_is_there_but_does_not_load_is_not_to_be_installed_again(tmp_path, monkeypatch):
    (tmp_path / "broken_viewer.py").write_text("raise ImportError('libGL.so.1: no such file')\n", "utf-8")
    monkeypatch.syspath_prepend(tmp_path)
    with pytest.raises(DependencyMissing, match=r"broken_viewer is installed, but does not load: libGL\.so\.1"):
        extra("broken_viewer", "pip install broken_viewer")
    with pytest.raises(DependencyMissing, match="pip install no_viewer"):
        extra("no_viewer", "pip install no_viewer")
