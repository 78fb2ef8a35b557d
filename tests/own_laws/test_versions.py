"""Versions of a law that a server keeps: back, forward, and what a save makes of them."""

from __future__ import annotations

from motionlab.own_laws.versions import MOST, Versions


def test_a_save_follows_the_version_that_ran() -> None:
    versions = Versions(("a",)).saved("b").saved("c")
    assert (versions.running, versions.before, versions.number) == ("c", "b", 3)
    back = versions.moved(-1)
    assert back is not None
    assert (back.running, back.before, back.texts) == ("b", "a", versions.texts)
    saved = back.saved("d")
    assert saved.texts == ("a", "c", "b", "d")  # none is lost
    assert (saved.before, saved.number) == ("b", 4)


def test_a_text_stands_once() -> None:
    versions = Versions(("a",)).saved("b").saved("a")
    assert versions.texts == ("b", "a")
    assert versions.saved("a") == versions


def test_the_ends_are_ends() -> None:
    one = Versions(("a",))
    assert one.before == "a"
    assert one.moved(-1) is None and one.moved(1) is None
    two = one.saved("b").moved(-1)
    assert two is not None and two.moved(-1) is None
    assert two.moved(1) == one.saved("b")


def test_the_oldest_goes() -> None:
    versions = Versions(("0",))
    for k in range(1, MOST + 5):
        versions = versions.saved(str(k))
    assert len(versions.texts) == versions.number == MOST
    assert versions.running == str(MOST + 4)
