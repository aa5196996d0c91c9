"""Masses that are estimates, by the part of the catalogue entry's source about the mass."""

from __future__ import annotations

import pytest

from mbcdm_cad.design.catalogue import package_entries
from mbcdm_cad.report.masses import mass_is_estimated


@pytest.mark.parametrize(
    ("kind", "name", "estimated"),
    [
        ("motors", "motor-2.9mNm-15", False),  # the paper gives 18 g; only sizes are of a class
        ("gearheads", "gearhead-76-16", True),
        ("encoders", "encoder-17", True),
        ("encoders", "encoder-24-ring", True),
        ("bearings", "618/4", False),  # ratings are estimates, masses are not
        ("bearings", "618/3", True),
        ("screws", "M2x6", False),
        ("screws", "M2x5", True),
        ("ropes", "FF-081", True),
    ],
)
def test_estimate_is_told_by_the_clause_on_the_mass(kind: str, name: str, estimated: bool) -> None:
    source = package_entries(kind)[name]["source"]
    assert mass_is_estimated(source) is estimated, source


def test_source_silent_on_the_mass_counts_as_a_whole() -> None:
    assert mass_is_estimated("estimate") and not mass_is_estimated("Maker's data sheet, edition 7")
