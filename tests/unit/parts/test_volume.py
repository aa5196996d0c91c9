"""The closed forms of volume compared with the drawn solids: mass of varied designs."""

from __future__ import annotations

from dataclasses import replace

import pytest

from mbcdm_cad.checks.size import estimated_mass_g
from mbcdm_cad.design.drive import Drive
from mbcdm_cad.layouts.miso_bevel.bill import bill
from mbcdm_cad.layouts.miso_bevel.drive import BevelDrive, bevel
from mbcdm_cad.layouts.miso_bevel.layout import BevelLayout
from tests.support.random_generator import Passing, passing

MASS_SHARE = 0.01


def drawn_mass_g(drive: BevelDrive) -> float:
    """Mass of all items from the solids' volumes."""
    found = bill(BevelLayout(drive))
    made = {item.part for item in found.items if item.mass_g is None}
    volumes = {name: found.parts[name].part.solid().Volume() for name in made}
    return sum(
        volumes[item.part] * item.material.density_g_cm3 * 1e-3 if item.mass_g is None else item.mass_g
        for item in found.items
    )


def _close(drive: BevelDrive, what: str) -> None:
    drawn, estimated = drawn_mass_g(drive), estimated_mass_g(bill(BevelLayout(drive)))
    assert estimated == pytest.approx(drawn, rel=MASS_SHARE), f"{what}: {estimated:.1f} g, drawn {drawn:.1f} g"


@pytest.mark.slow
@pytest.mark.parametrize("seed", [4, 5, 6])
def test_mass_of_random_designs(seed: int) -> None:
    found = passing(seed)
    if isinstance(found, Passing):
        _close(bevel(found.loaded.drive), f"seed {seed}")


@pytest.mark.slow
def test_mass_with_grooves_setback_and_four_screws(drive: Drive) -> None:
    design = bevel(drive)
    pulleys = replace(design.input_pulleys, surface="grooved")
    gearhead = replace(design.gearhead, screw_count=4)
    _close(
        replace(design, input_pulleys=pulleys, gearhead=gearhead, helix_lead_mm=0.9, input_setback_mm=1.5),
        "grooves, setback, four screws",
    )
