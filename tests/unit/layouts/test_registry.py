"""The registry: finds the layouts of the package, accepts one from outside, and names an unknown one."""

from __future__ import annotations

from importlib.metadata import EntryPoint

import pytest

from mbcdm_cad.errors import MbcdmError
from mbcdm_cad.layouts import registry
from mbcdm_cad.layouts.base import Layout


class Outside(Layout):
    """A layout of another package."""

    name, title = "outside", "from a test"


def test_every_folder_is_found_under_its_own_name() -> None:
    assert "miso_bevel" in registry.names()
    for name in registry.names():
        assert registry.layout_named(name).name == name
        assert registry.layout_named(name).title


def test_one_from_outside_is_found_once_it_is_added(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(registry, "_added", {})
    with pytest.raises(MbcdmError, match="outside"):
        registry.layout_named("outside")
    registry.add(Outside)
    assert registry.layout_named("outside").title == "from a test"
    assert registry.names()[-1] == "outside"


def test_a_plug_in_names_its_class(monkeypatch: pytest.MonkeyPatch) -> None:
    entry = EntryPoint("outside", f"{__name__}:Outside", registry.ENTRY_POINTS)
    monkeypatch.setattr(registry, "_added", {})
    monkeypatch.setattr(registry, "_plug_ins", lambda: {"outside": entry})
    assert registry.layout_named("outside").title == "from a test"
    assert registry.names()[-1] == "outside"


def test_an_unknown_name_is_refused_with_the_names_there_are() -> None:
    with pytest.raises(MbcdmError, match=r"miso_bevl.*miso_bevel"):
        registry.layout_named("miso_bevl")
