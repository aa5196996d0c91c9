"""What turns the payload besides the cables, and figures of the exact cable paths: text and plain data."""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import asdict, dataclass
from math import isfinite
from typing import TYPE_CHECKING, Any

import numpy as np

from mbcdm_cad.design.drive import Drive
from mbcdm_cad.layouts.base import Layout, NoFigureError, PathFigures
from mbcdm_cad.layouts.registry import layout_of
from mbcdm_cad.layouts.structure import structure_of
from mbcdm_cad.layouts.turns import DriveTurns, TurnAt, implied_moduli_GPa, turns_of
from mbcdm_cad.model.equations import BACKLASH_RAD
from mbcdm_cad.model.equilibrium import solve_equilibrium
from mbcdm_cad.model.si import DriveSI, ModelError
from mbcdm_cad.model.stiffness import sticking_response
from mbcdm_cad.report.table import ReportTable

if TYPE_CHECKING:
    from mbcdm_cad.model.structure.causes import Structure


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
    turns = turns_of(layout)
    if turns.payload is None:
        return None, turns.no_structure
    structure = structure_of(layout)
    assert structure is not None
    return StructureReport(structure, turns, turns.payload, implied_moduli_GPa(layout)), ""


def path_data(layout: Layout) -> dict[str, Any]:
    """Plain data of the paths, as in the report and in ``mbcdm analyse --json``."""
    figures = layout.path_figures
    length_m = np.array([cable.length_um for cable in figures.cables]) * 1e-6
    d = layout.si
    turn, pull = sticking_response(d, length_m)
    return {
        **asdict(figures),  # type: ignore[call-overload]
        "usable_deg": list(figures.usable_deg),
        "test_turn_mrad": _turns_with_real_wraps(d, figures, layout.drive.loads.test_torque_Nm),
        "drum_turn_urad": [float(v) for v in turn * 1e6],
        "tension_change_N": [[float(v) for v in row] for row in pull],
    }


def _turns_with_real_wraps(d: DriveSI, figures: PathFigures, load_Nm: float) -> dict[str, list[float]]:
    """Turn under + and - ``load_Nm`` at each drum angle, slip ending at the real anchors, mrad."""
    wraps = [np.radians([getattr(c, name) for c in figures.cables]) for name in ("input_wrap_deg", "drum_wrap_deg")]
    real = d.spread(len(figures.drum_angle_deg)).with_(input_wrap_rad=wraps[0], drum_wrap_rad=wraps[1])
    idle = solve_equilibrium(real, 0.0).drum_angle_rad
    ways = {"positive": load_Nm, "negative": -load_Nm}
    return {
        name: [float(v) for v in (solve_equilibrium(real, load).drum_angle_rad - idle) * 1e3]
        for name, load in ways.items()
    }


def path_data_or_reason(drive: Drive) -> tuple[dict[str, Any] | None, str]:
    """As :func:`path_data`; (None, reason) if the dimensions have no solution, which ``mbcdm check`` explains."""
    try:
        return path_data(layout_of(drive)), ""
    except (NoFigureError, ValueError, ZeroDivisionError, ModelError) as error:
        return None, str(error)


def path_lines(layout: Layout, paths: dict[str, Any]) -> Iterator[str]:
    """The paths for a terminal: the configuration's lines for each cable, then the travel."""
    ends = paths["drum_angle_deg"][0], paths["drum_angle_deg"][-1]
    yield "cable paths (wraps in deg, drum centred and at both ends of travel; walk and fleet angle at the ends):"
    for c in paths["cables"]:
        yield from layout.path_lines(c)
    longest = max(max(map(abs, c["length_um"])) for c in paths["cables"])
    pull = max(max(map(abs, row)) for row in paths["tension_change_N"])
    yield (
        f"  helix and fleet angle change the lengths by up to {longest:.1f} um over the travel: the drum turns by up "
        f"to {max(map(abs, paths['drum_turn_urad'])):.1f} urad, tensions change by up to {pull:.2f} N (wraps sticking)"
    )
    turned = [abs(v) for way in paths["test_turn_mrad"].values() for v in way]
    yield (
        f"  turn at the test torque with the real wraps: {min(turned):.4f} to {max(turned):.4f} mrad over the "
        "travel (the figures above are for endless wraps)"
    )
    low, high = paths["usable_deg"]
    drive = layout.drive
    middle = f", counted from {drive.middle_deg:+g} deg of the output" if drive.middle_deg else ""
    yield (
        f"usable travel {low:.2f} to {high:+.2f} deg (design {ends[0]:+g} to {ends[1]:+g}{middle}); limits in order:"
    )
    for name in ("limits_negative", "limits_positive"):
        yield "  " + "; ".join(f"{x['angle_deg']:+.2f} {x['cause']}" for x in paths[name][:4])
