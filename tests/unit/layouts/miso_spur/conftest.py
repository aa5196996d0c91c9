"""The reference design of miso_spur, as its schema writes it, and with more inputs."""

from collections.abc import Callable
from dataclasses import replace

import pytest

from mbcdm_cad.layouts.loader import load_text, new_design_text
from mbcdm_cad.layouts.miso_spur.layout import RoundDrumLayout
from mbcdm_cad.layouts.siso_spur.drive import SpurDrive


@pytest.fixture(scope="session")
def drive() -> SpurDrive:
    """Its drive, two inputs."""
    return load_text(new_design_text("miso_spur", "miso_spur")).drive


@pytest.fixture(scope="session")
def anchored() -> RoundDrumLayout:
    """The same with two anchored cables for each input."""
    text = new_design_text("miso_spur", "miso_spur").replace("cables: continuous", "cables: two_anchored")
    return RoundDrumLayout(load_text(text).drive)


@pytest.fixture(scope="session")
def dims(drive: SpurDrive) -> RoundDrumLayout:
    """Its dimensions."""
    return RoundDrumLayout(drive)


@pytest.fixture(scope="session")
def with_inputs(drive: SpurDrive) -> Callable[[int], SpurDrive]:
    """The reference with another number of inputs, loads in proportion, further out to pass the sectors."""
    sides = [c for c in drive.cables if c.input_name == drive.input_names[0]]

    def of(count: int) -> SpurDrive:
        names = tuple("abcd"[:count])
        cables = tuple(replace(side, name=f"{name}_{side.step}", input_name=name) for name in names for side in sides)
        share = count / len(drive.input_names)
        loads = replace(
            drive.loads,
            peak_torque_Nm=drive.loads.peak_torque_Nm * share,
            test_torque_Nm=drive.loads.test_torque_Nm * share,
        )
        return replace(
            drive,
            input_names=names,
            cables=cables,
            sigmas=drive.sigmas.of_cables((0,) * len(cables)),
            loads=loads,
            limits=replace(drive.limits, frame_windup_max_mrad=None),
            centre_distance_mm=70.0 if count < 3 else 74.0,
            drum=replace(drive.drum, stop_pin_mm=4.0, hub_diameter_mm=24.0),
            targets=replace(drive.targets, mass_g=None, envelope_mm=None),
        )

    return of
