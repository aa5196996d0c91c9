"""The torque that turns the drum from its side: asked, not asked, and gearheads that lock."""

from __future__ import annotations

import pytest
from designs import put, reference

from mbcdm_cad.checks.motors import backdrive
from mbcdm_cad.checks.run import run_check
from mbcdm_cad.layouts.loader import design_file, layout_of, load_text
from tests.support.checked import failing, results

HANDLE = """name: handle
configuration: siso_spur
travel: {half_angle_deg: 45}
transmission: {input_to_drum: 10, drum_radius_mm: 60}
loads: {peak_torque_Nm: 0.5, backdrive_Nm: 0.05}
"""


def test_a_design_that_asks_for_none_is_told_the_torque() -> None:
    found = backdrive(layout_of(reference()))
    back = layout_of(reference()).losses.backdrive
    assert back is not None
    assert found.sense == 0 and found.actual == pytest.approx(back.start_Nm)


def test_gearheads_that_lock_fail_only_where_back_driving_is_asked() -> None:
    locked = put(reference(), "gearhead.efficiency", 0.5)
    assert run_check(backdrive, layout_of(locked)).status == "pass"
    asked = run_check(backdrive, layout_of(put(locked, "loads.backdrive_Nm", 1.0)))
    assert asked.status == "fail" and "0.5 or below" in asked.message, asked


GEARED = HANDLE + "drive: {motor: motor-4.5mNm-17, gearhead: gearhead-76-22}\n"


def test_a_handle_learns_what_resists_most() -> None:
    found = run_check(backdrive, layout_of(load_text(GEARED).drive))
    assert found.status == "fail" and found.actual is not None and found.actual > 0.05, found
    assert "gearhead" in found.remedy, found.remedy


@pytest.mark.parametrize(
    ("layout", "share", "geared"),
    [
        ("siso_spur", 0.9, True),
        ("siso_spur", 0.4, False),
        ("miso_spur", 0.9, True),
        ("siso_bevel", 0.5, False),
        ("miso_bevel", 0.9, True),
        ("miso_bevel", 0.4, False),
    ],
)
def test_rules_choose_a_train_that_the_drum_turns(layout: str, share: float, geared: bool) -> None:
    """Motor, gearhead and preload hold a wish that the drive without it does not, and still move its torque."""
    text = str(design_file(layout).starting).format(name="started")
    back = layout_of(load_text(text).drive).losses.backdrive
    assert back is not None
    wanted = share * back.start_Nm
    asked = load_text(text.replace("loads:\n", f"loads:\n  backdrive_Nm: {wanted:.4g}\n", 1)).drive
    found = {c.id: c for c in results(asked)}
    assert found["backdrive"].status == "pass" and found["backdrive"].limit == pytest.approx(wanted, rel=1e-3)
    assert found["motor_torque_forward"].status == found["motor_torque_back"].status == "pass", found
    assert asked.gearhead.absent is not geared, asked.gearhead.name


def test_what_no_train_of_the_catalogue_does_comes_near() -> None:
    """The drive that turns most easily, with the one failed check that says by how much it misses."""
    text = str(design_file("siso_spur").starting).format(name="started")
    drive = load_text(text.replace("loads:\n", "loads:\n  backdrive_Nm: 0.02\n", 1)).drive
    assert drive.gearhead.absent
    assert list(failing(drive)) == ["backdrive"]


def test_a_lower_preload_turns_more_easily_where_motor_and_ratio_are_stated() -> None:
    text = HANDLE + "drive: {motor: maxon-ec45flat-70W, gearhead: none, encoder: none}\n"
    usual = load_text(text.replace("0.05}", "1.0}")).drive
    back = layout_of(usual).losses.backdrive
    assert back is not None
    asked = load_text(text.replace("0.05}", f"{0.99 * back.start_Nm:.4g}}}")).drive
    assert asked.cables[0].preload_N < usual.cables[0].preload_N
    assert run_check(backdrive, layout_of(asked)).status == "pass"


@pytest.mark.parametrize(
    ("layout", "cables", "share"),
    [("miso_bevel", "", 0.93), ("siso_bevel", "", 0.987), ("siso_spur", "  cables: two_anchored\n", 0.935)],
)
def test_anchored_cables_get_less_preload_until_one_would_go_slack(layout: str, cables: str, share: float) -> None:
    text = str(design_file(layout).starting).format(name="started").rstrip() + "\n"
    text = text.replace("transmission:\n", f"transmission:\n{cables}", 1)
    text += "drive: {motor: mjbots-mj5208, gearhead: none}\n"

    def asked(wanted_Nm: float | None) -> tuple[float, dict[str, str], str, float]:
        line = "" if wanted_Nm is None else f"  backdrive_Nm: {wanted_Nm:.4g}\n"
        found = load_text(text.replace("loads:\n", f"loads:\n{line}", 1))
        preload = next(value for value in found.sized if value.field == "rope.preload_N")
        back = layout_of(found.drive).losses.backdrive
        assert back is not None
        return preload.value, failing(found.drive), preload.driver, back.start_Nm

    usual, failed, driver, turned = asked(None)
    assert not failed and driver != "backdrive"
    less, failed, driver, _ = asked(share * turned)
    assert not failed and driver == "backdrive" and 0.5 * usual <= less < usual, (usual, less)
    least, failed, _, easiest = asked(0.1 * turned)
    assert set(failed) == {"backdrive"} and least < less and easiest < share * turned, (least, failed)
