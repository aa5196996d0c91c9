"""Effects found on the built drive change the declared values of the design and increase their sigmas."""

from __future__ import annotations

from typing import Any

import pytest

from mbcdm_cad.errors import InputError
from mbcdm_cad.layouts.registry import layout_of
from mbcdm_cad.model.analysis import analyse


def found(name: str, form: str, share: float, **more: Any) -> dict[str, Any]:
    value = {"name": "share", "value": share, "low": share - 0.0196, "high": share + 0.0196}
    return {"name": name, "form": form, "values": [value], **more}


MODULUS = found("stiffness_error", "modulus of the rope", 0.1)
ONE_CABLE = found("preload_error", "one cable", -0.2, cables=["cable_3"])
FRICTION = found("cable_friction", "rope on pulley", 0.5)
GUIDE = {
    "name": "once_per_rev",
    "form": "eccentric pulley",
    "stage": "guide",
    "values": [{"name": "cosine_m", "value": 1e-05}, {"name": "sine_m", "value": 0.0}],
}


def test_values_change_by_their_shares_and_get_sigmas(load_edited: Any) -> None:
    bare = load_edited({}).drive
    drive = load_edited({("as_built",): [MODULUS, ONE_CABLE, FRICTION, MODULUS]}).drive
    assert drive.cable.modulus_GPa == pytest.approx(1.1**2 * bare.cable.modulus_GPa)
    assert drive.sigmas.modulus_GPa == pytest.approx(0.01 * 1.1 * 2**0.5 * bare.cable.modulus_GPa)
    assert [c.preload_N for c in drive.cables] == pytest.approx([70.0, 70.0, 56.0, 70.0])
    assert drive.sigmas.preload_N == pytest.approx((0.0, 0.0, 0.7, 0.0))
    assert drive.friction_coefficient == pytest.approx(0.225)
    assert drive.as_built == ()


def test_analysis_is_that_of_the_drive_as_built(load_edited: Any) -> None:
    bare = analyse(layout_of(load_edited({}).drive))
    stiff = analyse(layout_of(load_edited({("as_built",): [MODULUS]}).drive))
    ratio = stiff.reversal_swing_mrad / bare.reversal_swing_mrad
    assert ratio == pytest.approx(1.0 / 1.1, rel=1e-9)


def test_what_has_no_value_in_the_design_is_kept(load_edited: Any) -> None:
    (entry,) = load_edited({("as_built",): [GUIDE]}).drive.as_built
    assert (entry.name, entry.stage, entry.cables) == ("once_per_rev", "guide", ())
    assert [value.value for value in entry.values] == [1e-05, 0.0]


@pytest.mark.parametrize(
    ("entry", "field", "remedy"),
    [
        (ONE_CABLE | {"cables": ["cable_7"]}, "as_built[0].cables[0]", "cable_1"),
        (found("stiffness_error", "modulus of the rope", -1.5), "as_built[0].values[0].value", "0.1 for 10 % more"),
        (MODULUS | {"values": [{"name": "part", "value": 0.1}]}, "as_built[0].values", "add {name: share"),
        (MODULUS | {"values": []}, "as_built[0].values", "1"),
    ],
)
def test_refusals_say_where_and_what_to_do(load_edited: Any, entry: dict[str, Any], field: str, remedy: str) -> None:
    with pytest.raises(InputError) as caught:
        load_edited({("as_built",): [entry]})
    text = str(caught.value)
    assert field in text, text
    assert remedy in text, text
