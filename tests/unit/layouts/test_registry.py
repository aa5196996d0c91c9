"""The registry: finds the configurations of the package, accepts one from outside, and names an unknown one."""

from __future__ import annotations

from types import ModuleType, SimpleNamespace

import pytest

from mbcdm_cad.errors import MbcdmError
from mbcdm_cad.layouts import registry


def test_every_folder_is_found_under_its_own_name() -> None:
    assert "miso_bevel" in registry.names()
    for name in registry.names():
        assert registry.configuration(name).name == name
        assert registry.configuration(name).title


def test_one_from_outside_is_found_once_it_is_added(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(registry, "_added", {})
    module = ModuleType("outside")
    module.CONFIGURATION = SimpleNamespace(name="outside", title="from a test")  # type: ignore[attr-defined]
    with pytest.raises(MbcdmError, match="outside"):
        registry.configuration("outside")
    registry.add(module)
    assert registry.configuration("outside").title == "from a test"
    assert registry.names()[-1] == "outside"


def test_an_unknown_name_is_refused_with_the_names_there_are() -> None:
    with pytest.raises(MbcdmError, match=r"miso_bevl.*miso_bevel"):
        registry.configuration("miso_bevl")
