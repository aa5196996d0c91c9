"""Cost by the catalogue's prices."""

from __future__ import annotations

from dataclasses import replace
from typing import Any

import pytest

import mbcdm_cad as mc
from mbcdm_cad.checks.size import estimated_mass_g
from mbcdm_cad.design.bought import Entry
from mbcdm_cad.layouts.registry import layout_of
from mbcdm_cad.parts.bill import CABLE
from mbcdm_cad.parts.making import NoPriceError, bought_cost_EUR, material_cost_EUR


@pytest.fixture(scope="module")
def drive() -> mc.Drive:
    return mc.load("params/siso_spur.yaml").drive


def _of_catalogue(part: object) -> bool:
    return isinstance(getattr(part, "entry", None), Entry)


def _at_one_price(bill: Any) -> Any:
    """Every material for 1 EUR/kg, every part for 2 EUR."""
    items = tuple(replace(item, material=replace(item.material, price_EUR=1.0)) for item in bill.items)
    parts = {
        name: replace(spec, part=replace(spec.part, entry=replace(spec.part.entry, price_EUR=2.0)))
        if _of_catalogue(spec.part)
        else spec
        for name, spec in bill.parts.items()
    }
    return replace(bill, items=items, parts=parts)


def test_material_at_one_price_costs_the_made_mass(drive: mc.Drive) -> None:
    bill = layout_of(drive).bill()
    made_g = estimated_mass_g(bill) - sum(item.mass_g or 0.0 for item in bill.items)
    assert material_cost_EUR(_at_one_price(bill)) == pytest.approx(made_g * 1e-3)


def test_bought_parts_cost_their_number_and_the_rope_its_length(drive: mc.Drive) -> None:
    bill = _at_one_price(layout_of(drive).bill())
    rope = replace(drive.cable, price_EUR=3.0)
    length_m = sum(path.length_mm for path in layout_of(drive).cable_paths(0.0)) * 1e-3
    with_entry = [item for item in bill.items if _of_catalogue(bill.parts[item.part].part)]
    assert not [item for item in with_entry if item.name.startswith(CABLE)]
    assert bought_cost_EUR(bill, rope) == pytest.approx(2.0 * len(with_entry) + 3.0 * length_m)


def test_entries_without_a_price_are_named(drive: mc.Drive) -> None:
    with pytest.raises(NoPriceError) as refused:
        bought_cost_EUR(layout_of(drive).bill(), drive.cable)
    assert drive.motor.name in str(refused.value)
    assert drive.cable.name in str(refused.value)
