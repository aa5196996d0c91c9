"""Files for a printer are those of printed parts; what a standard names is bought and has neither file nor sheet."""

from __future__ import annotations

import re
from dataclasses import replace
from pathlib import Path

import pytest

from mbcdm_cad.design.drive import Drive
from mbcdm_cad.errors import MbcdmError
from mbcdm_cad.layouts.loader import load_design
from mbcdm_cad.parts.part import StandardPart
from mbcdm_cad.storage.cache import Cache, cache_folder
from mbcdm_cad.workshop.drawings import drawn_parts
from mbcdm_cad.workshop.prints import prints_of
from tests.support.checked import of_params

PARAMS = Path(__file__).parents[3] / "params"
# Nominal lengths of ISO 2338 to 30 mm; greatest height and width across flats of ISO 4032 by thread.
PIN_LENGTHS_MM = (2, 3, 4, 5, 6, 8, 10, 12, 14, 16, 18, 20, 22, 24, 26, 28, 30)
NUTS_MM = {1.6: (1.3, 3.2), 2.0: (1.6, 4.0), 2.5: (2.0, 5.0), 3.0: (2.4, 5.5), 4.0: (3.2, 7.0)}


@pytest.fixture(scope="module")
def metal() -> Drive:
    drive: Drive = load_design(PARAMS / "siso_spur.yaml").drive
    return drive


def test_a_design_of_metal_prints_nothing_unless_asked(metal: Drive) -> None:
    with pytest.raises(
        MbcdmError, match=r"no part is printed \(value milled, turned, limit printed or sintered.*--all"
    ):
        prints_of(metal, Cache(cache_folder()))


def test_only_the_printed_parts_get_a_file(metal: Drive) -> None:
    drive = replace(metal, drum_material=metal.material("pla"))
    assert set(prints_of(drive, Cache(cache_folder()))) == {"drum.3mf"}


@pytest.mark.parametrize("name", ["mbcdm", "siso_bevel", "siso_spur", "miso_spur", "gallery/hip", "gallery/capstan"])
def test_nuts_and_dowels_are_bought_in_sizes_that_their_standards_have(name: str) -> None:
    drive = of_params(name).drive
    bill = drive.layout.bill()
    standard = {n: spec.part for n, spec in bill.parts.items() if isinstance(spec.part, StandardPart)}
    assert {"nut", "dowel"} <= set(standard), set(standard)
    assert not set(standard) & set(drawn_parts(drive))
    for part, body in standard.items():
        said = body.designation
        if pin := re.fullmatch(r"ISO 2338 - ([\d.]+) m6 x ([\d.]+)", said):
            assert float(pin[2]) in PIN_LENGTHS_MM and float(pin[1]) == 2 * body.radius, (part, said)  # type: ignore[attr-defined]
        else:
            nut = re.fullmatch(r"ISO 4032 - M([\d.]+)", said)
            assert nut and NUTS_MM[float(nut[1])] == (body.height, body.across_flats), (part, said)  # type: ignore[attr-defined]
        (weighed,) = {item.mass_g for item in bill.items if item.part == part}
        assert weighed == pytest.approx(7.85e-3 * body.volume_mm3(), rel=0.03), (part, weighed)
