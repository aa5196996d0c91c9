"""What turns the payload besides the cables, as text for a terminal and as plain data for JSON and the page."""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import dataclass
from math import isfinite
from typing import TYPE_CHECKING, Any

from mbcdm_cad.layouts.turns import implied_moduli_GPa
from mbcdm_cad.model.measured import BACKLASH_RAD
from mbcdm_cad.report.table import ReportTable

if TYPE_CHECKING:
    from mbcdm_cad.layouts.base import Layout
    from mbcdm_cad.layouts.structure import Structure
    from mbcdm_cad.layouts.turns import DriveTurns, TurnAt


@dataclass(frozen=True)
class StructureReport:
    """The structure of one design, and what it and the cables turn by at the test torque."""

    structure: Structure
    turns: DriveTurns
    payload: TurnAt
    implied_moduli_GPa: dict[str, float]

    def to_dict(self) -> dict[str, Any]:
        """Everything, ready for JSON."""
        cables, payload = self.turns.cables, self.payload
        turned = {
            "cables_turn_mrad": cables.turn_mrad,
            "cables_swing_mrad": cables.swing_mrad,
            "payload_turn_mrad": payload.turn_mrad,
            "payload_swing_mrad": payload.swing_mrad,
            "test_torque_Nm": self.turns.load_Nm,
            "places": self.turns.to_dict(),
            "implied_moduli_GPa": {name: x if isfinite(x) else None for name, x in self.implied_moduli_GPa.items()},
        }
        return self.structure.to_dict() | turned

    def table(self) -> ReportTable:
        """Turn by cause."""
        s = self.structure
        whole = s.cables_urad_Nm + s.motor_urad_Nm
        rows = [("cables, at the test torque", s.cables_urad_Nm, "", "yes", "yes")]
        rows += [(c.name, c.urad_Nm, f"{c.factor:g}", _yes(c in s.at_payload), _yes(c.at_encoder)) for c in s.causes]
        shown = tuple((name, f"{turn:.1f}", f"{turn / whole:.1%}", *rest) for name, turn, *rest in rows)
        heads = ("cause", "urad/N m", "share", "factor", "inputs held", "encoder")
        return ReportTable(heads, shown)

    def places(self) -> ReportTable:
        """Turn, swing and stiffness at each place."""
        t = self.turns
        rows = (
            ("cables alone", t.cables),
            ("drum's encoder", t.drum_encoder),
            ("payload", t.payload),
            ("payload, motors held", t.motors_held),
        )
        shown = tuple((name, *_place(at)) for name, at in rows if at is not None)
        heads = ("seen at", "turn mrad", "+-", "swing mrad", "N m/rad", "small motion N m/rad")
        return ReportTable(heads, shown)

    def modulus_words(self) -> str:
        """E that the paper's backlash implies with the structure counted, and what to think of it."""
        found = [f"{_modulus(x)} ({reading})" for reading, x in self.implied_moduli_GPa.items()]
        return (
            f"with the structure counted, as the drum's encoder sees it, the same {BACKLASH_RAD * 1e3:g} mrad implies "
            f"E = {', '.join(found)}; steel has 200 GPa, a 7x7 rope 60 to 110"
        )

    def lines(self) -> Iterator[str]:
        """Sentences below the tables."""
        s = self.structure
        yield (
            f"turn: first loading to {self.turns.load_Nm:g} N m, +- by the structure's figures; swing: its full "
            "reversal; factor: one standard deviation of a cause"
        )
        share = s.peak_stress_MPa / s.yield_MPa
        said = f"{share:.0%} of the yield stress" if share < 1.0 else "above the yield stress"
        yield (
            f"largest stress of the drum's web and rim at the peak torque {s.peak_stress_MPa:.0f} MPa, {said} of "
            f"{s.yield_MPa:g} MPa; corners as drawn, without a factor for notches or creep"
        )


def _modulus(found_GPa: float) -> str:
    return f"{found_GPa:.1f} GPa" if isfinite(found_GPa) else "none, the structure alone turns further"


def _yes(said: bool) -> str:
    return "yes" if said else "no"


def _place(at: TurnAt) -> tuple[str, ...]:
    return (
        f"{at.turn_mrad:.3f}",
        f"{at.turn_sigma_mrad:.3f}",
        f"{at.swing_mrad:.3f}",
        f"{at.stiffness_Nm_rad:.0f}",
        f"{at.sticking_stiffness_Nm_rad:.0f}",
    )


def structure_report(layout: Layout) -> tuple[StructureReport | None, str]:
    """The structure's figures; None, with the reason, where there are none."""
    turns = layout.turns
    if turns.payload is None:
        return None, turns.no_structure
    structure = layout.structure
    assert structure is not None
    return StructureReport(structure, turns, turns.payload, implied_moduli_GPa(layout)), ""
