"""The bound that proves that requirements exclude each other: it never excludes an existing design."""

from __future__ import annotations

from dataclasses import replace

import pytest
import yaml

from mbcdm_cad.layouts.loader import load_text
from tests.acceptance.test_gallery import GALLERY
from tests.support.random_generator import WHOLE, failing, requirements
from tests.support.reach_bound import Asked, asked, excluding

# 68 mm across at a ratio of 20: the input pulleys are 3.4 mm across, no journal goes round a 3 mm shaft in them.
THIN = Asked(ratio=20.0, radius=34.0, travel=35.0, torque=0.5, rope=None, distance=None)


@pytest.mark.parametrize("path", GALLERY, ids=lambda path: path.stem)
def test_no_drive_of_the_gallery_is_excluded(path) -> None:  # type: ignore[no-untyped-def]
    assert excluding(asked(yaml.safe_load(path.read_text("utf-8")))) == ()


def test_a_set_is_the_smallest() -> None:
    assert excluding(THIN) == ("ratio", "radius")
    for name in ("ratio", "radius"):
        assert excluding(replace(THIN, **{name: None})) == ()


@pytest.mark.parametrize(
    ("found", "names"),
    [
        (replace(THIN, ratio=5.0, torque=60.0), ("ratio", "radius", "torque")),
        (replace(THIN, ratio=5.0, torque=6.0, rope="7x7-0.3"), ("radius", "torque", "rope")),
        (replace(THIN, ratio=5.0, rope="7x7-3.0"), ("ratio", "radius", "rope")),
        (replace(THIN, ratio=5.0, distance=8.0), ("radius", "distance")),
    ],
    ids=["torque", "thin rope", "thick rope", "distance"],
)
def test_each_condition_names_its_requirements(found: Asked, names: tuple[str, ...]) -> None:
    assert excluding(found) == names


def test_what_is_excluded_fails_when_it_is_sized() -> None:
    data = requirements(2, WHOLE)
    assert excluding(asked(data)) == ("ratio", "radius")
    assert "bearing_shoulders" in dict(failing(load_text(yaml.safe_dump(data))))
