"""What the sizing rules of siso_bevel read: fields, catalogue, and results of checks on a trial drive."""

from __future__ import annotations

from collections.abc import Mapping

from mbcdm_cad.layouts.siso_bevel.drive import DirectDrive
from mbcdm_cad.layouts.siso_bevel.layout import DirectLayout
from mbcdm_cad.layouts.trial_sizing import TrialKnown


class DirectKnown(TrialKnown):
    """Adds the values of an input at the drum."""

    layout = DirectLayout
    asked = (
        "travel.half_angle_deg",
        "loads.peak_torque_Nm",
        "transmission.input_to_drum",
        "rope.type",
        "rope.preload_N",
        "drive.motor",
        "drive.gearhead",
    )
    own_checks: Mapping[str, tuple[str, ...]] = {"input_pulleys.lower_bearing": ("bearing_seats",)}

    @property
    def drum_mm(self) -> float:
        """Pitch radius of the drum's step 1."""
        if self.has("transmission.drum_radii_mm"):
            return float(self["transmission.drum_radii_mm"][0])
        return float(self["transmission.drum_radius_mm"])

    @property
    def ratio(self) -> float:
        """Drum radius over input radius."""
        if self.has("transmission.input_to_drum"):
            return float(self["transmission.input_to_drum"])
        return float(self["transmission.drum_radii_mm"][0] / self["transmission.input_radii_mm"][0])

    def trial_drive(self, field: str, value: float) -> DirectDrive:
        """The drive of a trial. Raises as :meth:`trial` does."""
        found = self.trial(field, value).drive
        assert isinstance(found, DirectDrive)
        return found
