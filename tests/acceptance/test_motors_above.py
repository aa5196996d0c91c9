"""Very different designs with motors above, built: sound parts, no clash over the travel, box and mass as foreseen."""

from typing import Any

import pytest

from benchmarks.studies import random_designs
from mbcdm_cad.errors import InputError
from tests.acceptance.test_single_edits import EDITS, EXCLUDED
from tests.acceptance.test_single_edits import failing as failing_edit
from tests.acceptance.test_single_edits import requirements as reference
from tests.support.random_generator import PRINTED, Passing, failing, load, requirements

POSES = 3


def short(ratio: float, radius_mm: float, half_deg: float, torque_Nm: float, **blocks: Any) -> dict[str, Any]:
    return {
        "name": "raised",
        "configuration": "miso_bevel",
        "travel": {"half_angle_deg": half_deg},
        "transmission": {"ratio": ratio, "drum_radius_mm": radius_mm, **blocks.pop("transmission", {})},
        "loads": {"peak_torque_Nm": torque_Nm},
        "drive": {"motor_side": "above", **blocks.pop("drive", {})},
        **blocks,
    }


# Each kind of drive that the layout has, two in one design where neither changes what the other tests.
DESIGNS = {
    "large, four screws": short(12.0, 150.0, 30.0, 25.0),
    "small, grooved": short(6.0, 34.0, 20.0, 0.5, input_pulleys={"surface": "grooved"}),
    "printed, three screws, turned": short(
        9.0, 80.0, 30.0, 2.0, drive={"gearhead": "gearhead-76-22", "gearhead_angle_deg": 40.0}, **PRINTED
    ),
    "flat motors without gearheads": short(9.0, 80.0, 30.0, 1.0, drive={"gearhead": "none"}),
    "below, three screws, turned": short(
        8.0, 60.0, 20.0, 3.0, drive={"gearhead": "gearhead-76-22", "gearhead_angle_deg": -25.0, "motor_side": "below"}
    ),
}


@pytest.mark.slow
@pytest.mark.parametrize("name", DESIGNS)
def test_built_as_foreseen(name: str) -> None:
    loaded = load(DESIGNS[name])
    assert not failing(loaded)
    failures = list(random_designs.exercise(Passing(0, DESIGNS[name], loaded), POSES))
    assert not failures, "\n".join(f"{f.stage}: {f.what}" for f in failures)


@pytest.mark.slow
def test_the_workshop_can_make_it() -> None:
    """Every drawing but the drum's, which is that of motors below, makes its part; a forced build is never a crash."""
    data = DESIGNS["flat motors without gearheads"]
    failures = list(random_designs.exercise_workshop(Passing(0, data, load(data)), ("drum",)))
    assert not failures, "\n".join(f"{f.stage}: {f.what}" for f in failures)


@pytest.mark.parametrize("name", [name for name in EDITS if name not in EXCLUDED])
def test_one_edit_of_the_reference_passes_with_motors_above(name: str) -> None:
    data = reference()
    EDITS[name](data)
    data["drive"]["motor_side"] = "above"
    assert failing_edit(data) == {}


def test_motors_above_reach_as_far_as_motors_below() -> None:
    """Of random requirements, all that pass with motors below pass with motors above."""
    passed = 0
    for seed in range(1, 16):
        found = []
        for side in ("below", "above"):
            data = requirements(seed)
            data["drive"] = {"motor_side": side}
            try:
                found.append(not failing(load(data)))
            except InputError:
                found.append(False)
        assert found[1] or not found[0], f"seed {seed} passes with motors below only"
        passed += found[1]
    assert passed >= 12, passed
