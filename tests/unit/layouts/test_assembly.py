"""The order of assembly from templates: names come from the bill, a first stage is a drive with all its parts."""

from dataclasses import replace
from pathlib import Path

import pytest

from mbcdm_cad.layouts.loader import layout_of, load_design, load_text

PARAMS = Path(__file__).parents[3] / "params"


@pytest.mark.parametrize("name", ["mbcdm", "siso_bevel", "siso_spur", "miso_spur"])
def test_a_renamed_part_is_an_error(name: str, monkeypatch: pytest.MonkeyPatch) -> None:
    layout = layout_of(load_design(PARAMS / f"{name}.yaml").drive)
    bill = layout.bill()
    for old, item in (("stop_pin", "stop_pin"), ("hub_set_screw_1", "hub_set_screw_#")):
        wanted = item.replace("#", "")
        items = [replace(i, name=i.name.replace(wanted, "renamed")) for i in bill.items]
        assert old in {i.name for i in bill.items}
        monkeypatch.setattr(layout, "bill", lambda items=items: replace(bill, items=items))
        with pytest.raises(LookupError, match=item):
            layout.assembly_order  # noqa: B018 - raises


def test_a_first_stage_of_several_cables_has_all_its_parts() -> None:
    """Its sectors join one by one, on a shaft that is bonded in them."""
    text = "name: twice\nconfiguration: siso_spur\ntravel: {half_angle_deg: 35.0}\nloads: {peak_torque_Nm: 4.0}\n"
    text += "first_stage: {total_ratio: 24.0, design: {transmission: {parallel: 2}}}\n"
    layout = layout_of(load_text(text).drive)
    joined = [name for step in layout.assembly_order for name in step.items]
    assert sorted(joined) == sorted(item.name for item in layout.bill().items)
    (first,) = [step for step in layout.assembly_order if "first_drum_1" in step.items]
    assert "Wet the shaft with retaining compound. Push sector 1" in first.text
