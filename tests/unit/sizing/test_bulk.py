"""Sizing rules on columns of designs give the same values as for each design alone."""

from __future__ import annotations

import copy
import random
from dataclasses import replace
from typing import Any

import numpy as np
import pytest

from mbcdm_cad.design.sized import SizingError
from mbcdm_cad.layouts.miso_bevel.sizing import BEFORE_FRAME
from mbcdm_cad.layouts.miso_bevel.sizing.known import BevelKnown
from mbcdm_cad.sizing.arithmetic import Split, greatest, index_of_greatest, least, per_design, significant
from mbcdm_cad.sizing.bulk import fill_many, gathered
from mbcdm_cad.sizing.engine import fill
from mbcdm_cad.sizing.known import KnownFields
from mbcdm_cad.sizing.rule import Found, Rule, largest
from tests.support.random_generator import WHOLE, requirements

FIELDS = {
    "travel.half_angle_deg": lambda data: data["travel"]["half_angle_deg"],
    "transmission.ratio": lambda data: data["transmission"]["ratio"],
    "transmission.drum_radius_mm": lambda data: data["transmission"]["drum_radius_mm"],
    "loads.peak_torque_Nm": lambda data: data["loads"]["peak_torque_Nm"],
}
BLOCKS = ("travel", "transmission", "loads", "rope", "targets", "export")


def single(data: dict[str, Any]) -> KnownFields | None:
    """The early fields of one design by themselves; None where no rule can fill one."""
    known = BevelKnown(copy.deepcopy({block: {} for block in BLOCKS} | data))
    try:
        fill(known, BEFORE_FRAME)
    except SizingError:
        return None
    return known


def assert_same(files: list[dict[str, Any]], columns: dict[str, list[Any]]) -> None:
    """Sized as a batch and one by one: the same choices, the same figures to rounding."""
    base = {block: {} for block in BLOCKS} | {k: v for k, v in files[0].items() if k in ("drum", "guide", "support")}
    alike = list(fill_many(base, columns, BEFORE_FRAME, BevelKnown))
    n = len(files)
    refused = {int(row) for group in alike if group.refused for row in group.rows}
    alone = [single(data) for data in files]
    assert refused == {k for k, one in enumerate(alone) if one is None}
    for rule in BEFORE_FRAME:
        found = gathered(alike, rule.field, n)
        for k, one in enumerate(alone):
            if one is None or (isinstance(one.peek(rule.field), list) and isinstance(one.peek(rule.field)[0], dict)):
                continue
            expected = one.peek(rule.field)
            if isinstance(expected, str | bool | None):
                assert found[k] == expected, (rule.field, k, files[k])
            else:
                assert found[k] == pytest.approx(expected, rel=1e-9), (rule.field, k, files[k])


@pytest.mark.parametrize("printed", [False, True])
def test_a_batch_of_random_files_is_sized_as_each_alone(printed: bool) -> None:
    files = [requirements(700 + k, replace(WHOLE, stated=0.0)) for k in range(8)]
    if printed:
        files = [data | {"drum": {"material": "pa12"}, "support": {"material": "pa12"}} for data in files]
    assert_same(files, {field: [of(data) for data in files] for field, of in FIELDS.items()})


def test_ropes_and_centre_distances_differ_row_by_row() -> None:
    rng = random.Random(5)
    ropes = ["7x7-1.0", "uhmwpe-0.8", "FF-081"]
    files = [requirements(k, replace(WHOLE, stated=0.0)) for k in range(8)]
    for data in files:
        data["rope"] = {"type": rng.choice(ropes)}
        data["transmission"]["centre_distance_mm"] = round(
            rng.uniform(0.1, 1.2) * data["transmission"]["drum_radius_mm"], 1
        )
    columns: dict[str, list[Any]] = {field: [of(data) for data in files] for field, of in FIELDS.items()}
    columns["rope.type"] = [data["rope"]["type"] for data in files]
    columns["transmission.centre_distance_mm"] = [data["transmission"]["centre_distance_mm"] for data in files]
    assert_same(files, columns)


def test_designs_are_divided_where_a_rule_goes_two_ways() -> None:
    rules = (
        Rule("a.kind", "thick or thin", "", lambda known: "thick" if known["a.d"] > 2.0 else "thin"),
        Rule("a.twice", "of the thick ones", "", lambda known: 2 * known["a.d"], lambda k: k["a.kind"] == "thick"),
        Rule("a.room", "the larger need", "", lambda known: largest({"one": known["a.d"], "two": 1.23}, 0.1)),
    )
    alike = list(fill_many({"a": {}}, {"a.d": [1.0, 3.0, 2.5, 0.5]}, rules, KnownFields))
    assert list(gathered(alike, "a.kind", 4)) == ["thin", "thick", "thick", "thin"]
    assert gathered([g for g in alike if g.known.has("a.twice")], "a.twice", 4)[1:3].tolist() == [6.0, 5.0]
    assert gathered(alike, "a.room", 4).tolist() == [1.3, 3.0, 2.5, 1.3]


def test_designs_that_a_rule_cannot_fill_are_refused_alone() -> None:
    def picky(known: KnownFields) -> Found:
        if known["a.d"] < 0.0:
            raise ValueError("negative")
        return Found(known["a.d"])

    alike = list(fill_many({"a": {}}, {"a.d": [1.0, -1.0]}, (Rule("a.x", "", "", picky),), KnownFields))
    assert {int(g.rows[0]): g.refused for g in alike} == {0: "", 1: "a.x: no rule can fill it here (negative)"}
    assert np.isnan(gathered(alike, "a.x", 2)).tolist() == [False, True]


def test_values_per_design_work_as_numbers_do() -> None:
    a, b = per_design([1.0, 5.0]), 2.0
    assert greatest(a, b).tolist() == [2.0, 5.0] and least(a, b).tolist() == [1.0, 2.0]  # type: ignore[attr-defined]
    assert (greatest(1.0, 2.0), least(1.0, 2.0)) == (2.0, 1.0)
    assert significant(per_design([123.4, 0.01239]), 2).tolist() == [120.0, 0.012]  # type: ignore[attr-defined]
    assert index_of_greatest([a, per_design([0.0, 4.0])]) == 0
    with pytest.raises(Split) as split:
        index_of_greatest([a, b])
    assert split.value.holds.tolist() == [True, False] or split.value.holds.tolist() == [False, True]
    with pytest.raises(Split):
        bool(a > b)
    assert bool(a > 0.0) and not bool(a > 9.0)


def test_largest_and_smallest_of_one_value_are_that_value() -> None:
    column = per_design([3.0, 1.0])
    for function in (greatest, least):
        assert function(2.5) == 2.5
        assert function(column).tolist() == [3.0, 1.0], function.__doc__  # type: ignore[attr-defined]
