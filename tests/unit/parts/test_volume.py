"""The closed forms of volume compared with the drawn solids: each part of the reference, mass of varied designs."""

from __future__ import annotations

from dataclasses import replace

import pytest

from mbcdm_cad.checks.estimated_mass import estimated_mass_g
from mbcdm_cad.design.drive import Drive
from mbcdm_cad.layouts.loader import load_text, new_design_text
from mbcdm_cad.layouts.miso_bevel.bill import bill
from mbcdm_cad.layouts.miso_bevel.drive import BevelDrive, bevel
from mbcdm_cad.layouts.miso_bevel.layout import BevelLayout
from mbcdm_cad.layouts.miso_bevel.support.volume import VOLUMES
from mbcdm_cad.layouts.siso_bevel.support.volume import VOLUMES as SISO_VOLUMES
from mbcdm_cad.layouts.siso_spur.support.volume import VOLUMES as SPUR_VOLUMES
from mbcdm_cad.parts import volume
from mbcdm_cad.parts.bill import Bill
from mbcdm_cad.parts.make import make
from mbcdm_cad.parts.volume import Volume, estimated_mm3
from tests.random_generator import Passing, passing

from .golden import golden_volumes

GOLDEN = golden_volumes()
MADE = sorted(
    name
    for name in GOLDEN
    if not name.startswith(("bearing_", "cable_", "screw_"))
    and name not in ("encoder", "drum_encoder", "gearhead", "motor")
)
MASS_SHARE = 0.01


@pytest.mark.parametrize("name", MADE)
def test_each_part_of_the_reference_within_a_hundredth(centred: Bill, name: str) -> None:
    found = estimated_mm3(centred.parts[name], VOLUMES)
    assert found == pytest.approx(GOLDEN[name], rel=0.01), f"{name}: {found / GOLDEN[name] - 1:+.2%}"


def test_every_made_part_has_a_closed_form(centred: Bill) -> None:
    known = {**volume.VOLUMES, **VOLUMES}
    assert {centred.parts[i.part].maker for i in centred.items if i.mass_g is None} <= set(known)


def drawn_mass_g(drive: BevelDrive) -> float:
    """Mass of all items from the solids' volumes."""
    found = bill(BevelLayout(drive))
    made = {item.part for item in found.items if item.mass_g is None}
    volumes = {name: make(found.parts[name].maker, found.parts[name].args).Volume() for name in made}
    return sum(
        volumes[item.part] * item.material.density_g_cm3 * 1e-3 if item.mass_g is None else item.mass_g
        for item in found.items
    )


def _close(drive: BevelDrive, what: str) -> None:
    drawn, estimated = drawn_mass_g(drive), estimated_mass_g(bill(BevelLayout(drive)), VOLUMES)
    assert estimated == pytest.approx(drawn, rel=MASS_SHARE), f"{what}: {estimated:.1f} g, drawn {drawn:.1f} g"


@pytest.mark.slow
@pytest.mark.parametrize("seed", [1, 2, 3, 4, 5, 6])
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


@pytest.mark.slow
@pytest.mark.parametrize(("layout", "own"), [("siso_bevel", SISO_VOLUMES), ("siso_spur", SPUR_VOLUMES)])
def test_parts_of_drives_with_one_input_within_a_hundredth(layout: str, own: dict[str, Volume]) -> None:
    bill = load_text(new_design_text("single", layout)).drive.layout.bill()
    for name in ("frame", "motor_head", "drum", "input_pulley_main"):
        spec = bill.parts[name]
        drawn = make(spec.maker, spec.args).Volume()
        assert estimated_mm3(spec, own) == pytest.approx(drawn, rel=0.01), name
