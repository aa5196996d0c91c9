"""Wishes are read from their texts, and what is none is refused with value and limit."""

from __future__ import annotations

import pytest

from mbcdm_cad.errors import MbcdmError
from mbcdm_cad.optimising.wishes import Aim, Freed, Keep, wishes_of


def test_wishes_are_read_from_their_texts() -> None:
    found = wishes_of(
        ["mass_g:min", "torque_Nm:max"], ["bend_ratio:>=14.8"], ["drum.material=pa12,pla", "rope.preload_N=30..90"]
    )
    assert found.aims == (Aim("mass_g", "min"), Aim("torque_Nm", "max"))
    assert found.keeps == (Keep("bend_ratio", 1, 14.8),)
    assert found.free == (Freed("drum.material", ("pa12", "pla")), Freed("rope.preload_N", (), 30.0, 90.0))
    assert found.keeps[0].margin(15.0) == pytest.approx(0.2) and found.aims[1].less(3.0) == -3.0


@pytest.mark.parametrize(
    ("aims", "keeps", "free", "words"),
    [
        ([], [], [], "0 given (limit 1 to 4)"),
        (["a:min"] * 5, [], [], "5 given (limit 1 to 4)"),
        (["mass_g:min", "mass_g:max"], [], [], "mass_g is given twice"),
        (["mass_g"], [], [], "value mass_g, limit FIGURE:min or FIGURE:max"),
        (["mass_g:least"], [], [], "value mass_g:least"),
        (["mass_g:min"], ["torque_Nm:3"], [], "value torque_Nm:3, limit FIGURE:>=NUMBER"),
        (["mass_g:min"], ["torque_Nm:>=three"], [], "value torque_Nm:>=three"),
        (["mass_g:min"], [], ["rope.preload_N"], "value rope.preload_N, limit FIELD=A,B"),
        (["mass_g:min"], [], ["rope.preload_N=90..30"], "value rope.preload_N=90..30"),
    ],
)
def test_what_is_no_wish_is_refused(aims: list[str], keeps: list[str], free: list[str], words: str) -> None:
    with pytest.raises(MbcdmError) as refused:
        wishes_of(aims, keeps, free)
    assert words in str(refused.value)
