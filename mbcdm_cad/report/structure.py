"""What turns the payload besides the cables, as text for a terminal and as plain data for JSON and the page."""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import dataclass
from typing import TYPE_CHECKING, Any

from mbcdm_cad.layouts.base import NoFigureError
from mbcdm_cad.report.table import ReportTable

if TYPE_CHECKING:
    from mbcdm_cad.layouts.base import Layout
    from mbcdm_cad.layouts.structure import Structure
    from mbcdm_cad.model import Analysis


@dataclass(frozen=True)
class StructureReport:
    """The structure of one design beside the turn of its cables at the test torque."""

    structure: Structure
    test_torque_Nm: float
    cables_swing_mrad: float

    @property
    def cables_turn_mrad(self) -> float:
        """Turn of the payload by the cables at the test torque."""
        return self.structure.cables_urad_Nm * self.test_torque_Nm * 1e-3

    @property
    def payload_turn_mrad(self) -> float:
        """Turn of the payload at the test torque, cables and structure, the inputs held by their encoders."""
        return self.cables_turn_mrad + self.structure.payload_urad_Nm * self.test_torque_Nm * 1e-3

    @property
    def payload_swing_mrad(self) -> float:
        """Swing of the payload at a reversal of the test torque."""
        return self.cables_swing_mrad + 2.0 * self.structure.payload_urad_Nm * self.test_torque_Nm * 1e-3

    def to_dict(self) -> dict[str, Any]:
        """Everything, ready for JSON."""
        turned = {
            "cables_turn_mrad": self.cables_turn_mrad,
            "cables_swing_mrad": self.cables_swing_mrad,
            "payload_turn_mrad": self.payload_turn_mrad,
            "payload_swing_mrad": self.payload_swing_mrad,
            "test_torque_Nm": self.test_torque_Nm,
        }
        return self.structure.to_dict() | turned

    def table(self) -> ReportTable:
        """Turn by cause."""
        s = self.structure
        whole = s.cables_urad_Nm + s.motor_urad_Nm
        rows = [("cables, at the test torque", s.cables_urad_Nm, True, False)]
        rows += [(c.name, c.urad_Nm, c.at_encoder, c.before_input) for c in s.causes]
        shown = tuple(
            (name, f"{turn:.1f}", f"{turn / whole:.1%}", "no" if before else "yes", "yes" if seen else "no")
            for name, turn, seen, before in rows
        )
        heads = ("cause", "urad/N m", "share", "inputs held", "drum encoder")
        return ReportTable(heads, shown)

    def lines(self) -> Iterator[str]:
        """Sentences below the table."""
        s, torque = self.structure, self.test_torque_Nm
        yield (
            f"payload, inputs held: {s.cables_urad_Nm + s.payload_urad_Nm:.0f} urad/N m "
            f"({s.stiffness_Nm_rad:.0f} N m/rad), {self.payload_turn_mrad:.3f} mrad at {torque:g} N m, "
            f"{self.cables_turn_mrad:.3f} of them by the cables; swing at a reversal {self.payload_swing_mrad:.3f} mrad"
        )
        yield (
            f"an encoder on the drum's shaft sees {s.cables_urad_Nm + s.encoder_urad_Nm:.0f} urad/N m; with the motors "
            f"held in place of the inputs the payload turns by {s.cables_urad_Nm + s.motor_urad_Nm:.0f} urad/N m"
        )
        share = s.peak_stress_MPa / s.yield_MPa
        said = f"{share:.0%} of the yield stress" if share < 1.0 else "above the yield stress"
        yield (
            f"largest stress of the drum's web and rim at the peak torque {s.peak_stress_MPa:.0f} MPa, {said} of "
            f"{s.yield_MPa:g} MPa; corners as drawn, without a factor for notches or creep"
        )


def structure_report(layout: Layout, figures: Analysis) -> tuple[StructureReport | None, str]:
    """The structure's figures; None, with the reason, where there are none."""
    try:
        structure = layout.structure
    except NoFigureError as missing:
        return None, str(missing)
    if structure is None:
        return None, f"{layout.name} has no figures of its structure"
    return StructureReport(structure, figures.test[0].load_Nm, figures.reversal_swing_mrad), ""
