"""A trial drive is computed once for any number of requests, and gives the same values as alone."""

import copy
from typing import Any

import pytest

from mbcdm_cad.layouts.loader import load_text
from mbcdm_cad.layouts.siso_spur.layout import SpurLayout
from mbcdm_cad.layouts.siso_spur.sizing.known import SpurKnown
from mbcdm_cad.layouts.trial_drives import TrialDrives

SHORT = """\
name: short
configuration: siso_spur
travel: {half_angle_deg: 35.0}
transmission: {input_to_drum: 8.0, drum_radius_mm: 60.0}
loads: {peak_torque_Nm: 2.0}
"""


@pytest.fixture(scope="module")
def whole() -> dict[str, Any]:
    return dict(load_text(SHORT).data)


def trial(whole: dict[str, Any], block: str, **values: Any) -> dict[str, Any]:
    found = copy.deepcopy(whole)
    found[block] |= values
    return found


def test_trials_give_the_same_in_a_row_as_each_alone(whole: dict[str, Any]) -> None:
    given = SpurKnown(copy.deepcopy(whole), {})
    asked = ("tension", "drum_bearings", "input_bearings", "lug_stress", "hub_walls", "free_span")
    trials = [
        whole,
        trial(whole, "drum", outer_face_y_mm=9.0),
        trial(whole, "transmission", centre_distance_mm=80.0),
        trial(whole, "rope", preload_N=30.0),
        trial(whole, "loads", test_torque_Nm=1.9),
        trial(whole, "drum", outer_face_y_mm=-1e9),
        whole,
    ]
    checks, schema = SpurLayout.checks_by_id(), SpurLayout.design_file().schema
    in_a_row = [given.drives.margins(data, asked, checks) for data in trials]
    alone = [TrialDrives(schema, given.of_design).margins(data, asked, checks) for data in trials]
    assert in_a_row == alone
    assert in_a_row[0] == in_a_row[-1] != in_a_row[3]


def test_what_is_known_already_is_not_worked_out_again(whole: dict[str, Any]) -> None:
    made = list[Any]()
    given = SpurKnown(copy.deepcopy(whole), {})

    def of_design(design: Any) -> Any:
        made.append(design)
        return given.of_design(design)

    drives = TrialDrives(given.layout.design_file().schema, of_design)
    for data in (whole, trial(whole, "drum", web_thickness_mm=3.0), copy.deepcopy(whole)):
        drives.margins(data, ("hub_walls",), SpurLayout.checks_by_id())
    first, second = made
    assert second.support is first.support and second.drum.web_thickness_mm == 3.0
