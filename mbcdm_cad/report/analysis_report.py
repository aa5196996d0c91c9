"""The report of the model on one design: figures and cable paths as text for a terminal, as JSON, as a table.

The command line prints it, the Python API returns it.
"""

from __future__ import annotations

from collections.abc import Callable, Iterator, Mapping, Sequence
from dataclasses import asdict, dataclass, field, fields
from math import exp, inf, isfinite, isnan
from typing import TYPE_CHECKING, Any

import numpy as np

from mbcdm_cad.design.drive import Drive
from mbcdm_cad.layouts.base import Layout, NoFigureError, PathFigures
from mbcdm_cad.layouts.life import life_of
from mbcdm_cad.layouts.preload import preload_rule
from mbcdm_cad.layouts.registry import layout_of
from mbcdm_cad.layouts.structure import structure_of
from mbcdm_cad.layouts.turns import implied_moduli_GPa, modes_of, turns_of
from mbcdm_cad.model.analysis import analyse
from mbcdm_cad.model.duty import MotorDay
from mbcdm_cad.model.equations import papers_test
from mbcdm_cad.model.equilibrium import solve_equilibrium
from mbcdm_cad.model.figures import Analysis
from mbcdm_cad.model.heat import STANDSTILL_SHARE, MotorHeat
from mbcdm_cad.model.si import DriveSI, ModelError
from mbcdm_cad.model.stiffness import sticking_response
from mbcdm_cad.report.check_report import Chance, chance_lines, chances_of
from mbcdm_cad.report.losses import losses_report, stage_figures
from mbcdm_cad.report.preload import preload_shown
from mbcdm_cad.report.table import ReportTable, TextReport, blocks, chart, rendered, terminal_lines

if TYPE_CHECKING:
    import pandas

    from mbcdm_cad.design.blocks import AsBuilt
    from mbcdm_cad.design.drive import Drive
    from mbcdm_cad.model.capability import TorqueLimit
    from mbcdm_cad.model.rope_zones import RopeLife


# Shares of the time and temperatures of the air in the picture of the torque that may be held.
TIME_SHARES = (0.05, 0.1, 0.2, 0.3, 0.4, 0.6, 0.8, 1.0)
AMBIENTS_C = (20.0, 40.0, 60.0)
# What an estimate stands for, in words.
_WORDS = {
    "winding_K_W": "resistance from winding to housing",
    "housing_K_W": "resistance from housing to air",
    "winding_J_K": "heat capacity of the winding",
    "housing_J_K": "heat capacity of the housing",
    "limit_C": "limit of the winding",
}


def duty_data(layout: Layout) -> dict[str, Any]:
    """Duty and motors of a design; a temperature or a time without an end is null.

    ``held``: torque that the drum moves for a share of each period, at rest for the others, by ambient. Raises
    ``ModelError`` where the routes have no free span.
    """
    d, drive, motors = layout.duty, layout.drive, layout.motor_days
    held = []
    for ambient in AMBIENTS_C:
        motor = [motors[0].heat.allowed_Nm(share, d.period_s, ambient) for share in TIME_SHARES]
        limited = np.minimum(motor, drive.motor.peak_torque_mNm * 1e-3)
        output = np.minimum(layout.losses.output_Nm(limited), drive.reduction.max_torque_mNm * 1e-3)
        ways = [layout.losses.raised_Nm(output, way).min(axis=0) for way in (1, -1)]
        held.append(np.minimum(*ways).tolist())
    return {
        "stated": d.stated,
        "assumed": list(d.assumed),
        "period_s": d.period_s,
        "ambient_C": d.ambient_C,
        "peak_torque_Nm": d.peak_torque_Nm,
        "rms_torque_Nm": d.rms_torque_Nm,
        "moving_share": d.moving_share,
        "largest_speed_deg_s": d.largest_speed_deg_s,
        "cycles_per_h": d.cycles_per_h,
        "strokes": [{"range_deg": s.range_deg, "torque_Nm": s.torque_Nm, "per_h": s.per_h} for s in d.strokes],
        "motors": [_motor(m) for m in motors],
        "held": {"time_share": list(TIME_SHARES), "ambient_C": list(AMBIENTS_C), "torque_Nm": held},
    }


def estimated(heat: MotorHeat) -> str:
    """The figures of a motor's heat that are estimates, in words."""
    return ", ".join(_WORDS[name] for name in heat.estimated)


def time_words(seconds: float) -> str:
    """A time as text; without an end: no limit."""
    if not isfinite(seconds):
        return "no limit"
    if seconds < 120.0:
        return f"{seconds:.3g} s"
    return f"{seconds / 60.0:.3g} min" if seconds < 7200.0 else f"{seconds / 3600.0:.3g} h"


def _warm(temperature_C: float, sigma_K: float) -> str:
    if not isfinite(temperature_C):
        return "burns"
    return f"{temperature_C:.0f} +- {sigma_K:.0f}" if isfinite(sigma_K) else f"{temperature_C:.0f}"


def _finite(value: float) -> float | None:
    return value if isfinite(value) else None


def _endless(value: float | None) -> float:
    """A figure of the JSON, in which null stands for one without an end."""
    return inf if value is None else value


def _motor(m: MotorDay) -> dict[str, Any]:
    return {
        "name": m.name,
        "rms_mNm": m.rms_Nm * 1e3,
        "continuous_mNm": m.heat.continuous_at_Nm(m.duty.ambient_C) * 1e3,
        "winding_C": _finite(m.winding_C),
        "winding_sigma_K": _finite(m.sigma_K[0]),
        "winding_limit_C": m.heat.limit_C,
        "housing_C": _finite(m.housing_C),
        "housing_sigma_K": _finite(m.sigma_K[1]),
        "peak_from_cold_s": _finite(m.peak_from_cold_s),
        "peak_from_warm_s": _finite(m.peak_from_warm_s),
        "duty_from_cold_s": _finite(m.duty_from_cold_s),
        "winding_K_W": m.heat.winding_K_W,
        "housing_K_W": m.heat.housing_K_W,
        "winding_J_K": m.heat.winding_J_K,
        "housing_J_K": m.heat.housing_J_K,
        "estimated": list(m.heat.estimated),
    }


def duty_shown(found: Mapping[str, Any]) -> dict[str, Any]:
    """What page and report show of the block ``duty``."""
    held = found["held"]
    lines = [
        {"label": f"air at {ambient:g} C", "x": [100.0 * share for share in held["time_share"]], "y": torque}
        for ambient, torque in zip(held["ambient_C"], held["torque_Nm"], strict=True)
    ]
    motors = [
        {
            **m,
            "winding": _warm(_endless(m["winding_C"]), _endless(m["winding_sigma_K"])),
            "housing": _warm(_endless(m["housing_C"]), _endless(m["housing_sigma_K"])),
            "cold": time_words(_endless(m["peak_from_cold_s"])),
            "warm": time_words(_endless(m["peak_from_warm_s"])),
        }
        for m in found["motors"]
    ]
    title = f"Torque moved for a share of each {found['period_s']:.4g} s, by the windings' heat"
    shown = chart(title, ("share of the time", "%"), ("torque at the drum", "N m"), lines)
    return {**found, "motors": motors, "chart": shown}


# Points of a line in the picture of one rope.
_SHOWN_POINTS = 160


def life_data(layout: Layout) -> dict[str, Any]:
    """Life of all cables; cycles of the output, places in mm from the middle or stop on the input.

    Raises ``NoFigureError`` where the cables have no tensions or places.
    """
    life = life_of(layout)
    first = life.first
    early = None if first is None else first.reached(0.1)
    return {
        "duty": life.duty,
        "cycles_per_h": life.cycles_per_h,
        "generic": life.generic,
        "first": None if first is None else first.name,
        "first_on": None if first is None else first.pulleys[0].body,
        "replace_at_cycles": early,
        "replace_at_h": None if early is None or life.cycles_per_h is None else early / life.cycles_per_h,
        "refused": life.refused,
        "governs_instead": list(life.governs),
        "bend_ratio": layout.smallest_bend_ratio,
        "bend_ratio_minimum": layout.drive.cable.bend_ratio_minimum,
        "ropes": [_rope(rope) for rope in life.ropes],
        "helps": [asdict(each) for each in life.helps],
    }


def two_digits(value: float) -> str:
    """Two digits are more than figures of cycles are worth."""
    return f"{float(f'{value:.2g}'):.0f}"


def _rope(rope: RopeLife) -> dict[str, Any]:
    known = not rope.refused
    damaged = rope.place_m.size > 0 and not isnan(float(rope.damage[0]))
    step = max(1, rope.place_m.size // _SHOWN_POINTS)
    return {
        "name": rope.name,
        "refused": rope.refused,
        "order_of_magnitude_only": rope.rough,
        "n10": rope.reached(0.1) if known else None,
        "n50": rope.cycles if known else None,
        "n90": rope.reached(0.9) if known else None,
        "sigma_ln": rope.sigma if known else None,
        "sigma_ln_by_cause": rope.sigmas if known else {},
        "weakest_point": [
            asdict(p) | {"damage_share": None if isnan(p.damage_share) else p.damage_share} for p in rope.pulleys
        ],
        "zones": [{"from_mm": 1e3 * z.start_m, "to_mm": 1e3 * z.end_m, "bendings": z.bendings} for z in rope.zones],
        "place_mm": (1e3 * rope.place_m[::step]).tolist() if damaged else [],
        "damage_per_cycle": rope.damage[::step].tolist() if damaged else [],
    }


def life_shown(found: Mapping[str, Any] | None) -> dict[str, Any] | None:
    """What page and report show of the block ``life``: a row for each cable and pulley, pictures along the cables."""
    if found is None:
        return None
    ropes, rows = found["ropes"], []
    for rope in ropes:
        for k, pulley in enumerate(rope["weakest_point"]):
            life = [two_digits(rope[key]) if rope[key] is not None else "none" for key in ("n10", "n50", "n90")]
            rows.append({"cable": rope["name"] if k == 0 else "", "life": life if k == 0 else [""] * 3, **pulley})
    bent = [{"label": rope["name"], **_steps(rope["zones"])} for rope in ropes]
    used = [
        {"label": rope["name"], "x": rope["place_mm"], "y": [1e5 * d for d in rope["damage_per_cycle"]]}
        for rope in ropes
        if rope["n50"] is not None
    ]
    along = "along the cable, from its middle or stop on the input", "mm"
    charts = [("bent", "Bendings of each zone in a cycle of the output", "bendings", "", bent)]
    if used:
        charts.append(("used", "Life that 1000 cycles take", "of the median life", "%", used))
    return dict(found) | {
        "rows": rows,
        "too_small": found["bend_ratio"] < found["bend_ratio_minimum"],
        "median": next((two_digits(rope["n50"]) for rope in ropes if rope["name"] == found["first"]), None),
        "early": None if found["replace_at_cycles"] is None else two_digits(found["replace_at_cycles"]),
        "charts": {name: chart(title, along, (label, unit), lines) for name, title, label, unit, lines in charts},
    }


def _steps(zones: Sequence[Mapping[str, Any]]) -> dict[str, list[float]]:
    """Bendings over the place as a line with steps; 0 where nothing bends."""
    x, y, last = list[float](), list[float](), None
    for zone in zones:
        if last is not None and zone["from_mm"] > last:
            x += [last, zone["from_mm"]]
            y += [0.0, 0.0]
        x += [zone["from_mm"], zone["to_mm"]]
        y += [sum(zone["bendings"].values())] * 2
        last = zone["to_mm"]
    return {"x": x, "y": y}


def structure_data(layout: Layout) -> dict[str, Any]:
    """The structure, and what it and the cables turn by at the test torque. ``NoFigureError`` without figures."""
    turns = turns_of(layout)
    if turns.payload is None:
        raise NoFigureError(turns.no_structure)
    structure = structure_of(layout)
    assert structure is not None
    return structure.to_dict() | {
        "cables_turn_mrad": turns.cables.turn_mrad,
        "cables_swing_mrad": turns.cables.swing_mrad,
        "payload_turn_mrad": turns.payload.turn_mrad,
        "payload_swing_mrad": turns.payload.swing_mrad,
        "test_torque_Nm": turns.load_Nm,
        "places": turns.to_dict(),
        "implied_moduli_GPa": {name: x if isfinite(x) else None for name, x in implied_moduli_GPa(layout).items()},
    }


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


CAUSES = {
    "motor": "motor's rated torque, without losses",
    "motor_with_losses": "motor's rated torque, all losses counted",
    "gearhead_rated": "gearhead's continuous rating",
    "gearhead_maximum": "gearhead's intermittent rating",
    "motor_alone": "motor's continuous torque",
    "motor_alone_peak": "motor's torque at its peak current",
    "strength": "tension limit of a cable",
    "slack": "a cable goes slack",
    "slip": "the cable slips on its input",
}
# The subjects of a design: each gives its data, and raises ``NoFigureError`` where it has no figures.
SUBJECTS: dict[str, Callable[[Layout], dict[str, Any]]] = {
    "structure": structure_data,
    "modes": lambda layout: asdict(modes_of(layout)),
    "losses": lambda layout: losses_report(layout).to_dict(),
    "duty": duty_data,
    "life": life_data,
    "preload": lambda layout: asdict(preload_rule(layout)),
}


def subject_or_reason(layout: Layout, name: str) -> tuple[dict[str, Any] | None, str]:
    """The data of one of :data:`SUBJECTS`; None, with the reason, where there are no figures."""
    try:
        return SUBJECTS[name](layout), ""
    except NoFigureError as missing:
        return None, str(missing)


@dataclass(frozen=True)
class AnalysisReport(TextReport):
    """``figures`` of the analytic model, and the data of the cables' paths and of each of :data:`SUBJECTS`.

    Data are None where ``missing`` says why. ``chances``: probabilities of the checks of a drive as built.
    """

    figures: Analysis
    data: dict[str, dict[str, Any] | None]
    missing: dict[str, str]
    layout: Layout = field(repr=False)
    chances: tuple[Chance, ...] = ()

    def to_dict(self) -> dict[str, Any]:
        """Everything, ready for JSON; this is what ``mbcdm analyse --json`` prints."""
        found: dict[str, Any] = self.figures.to_dict() | self.data
        if self.layout.first_stage_unit is not None:
            found["stages"] = [asdict(one) for one in stage_figures(self.layout)]
            found["first_stage"] = analyse_design(self.layout.first_stage_unit.drive).to_dict()
        if self.chances:
            found["as_built"] = {one.check: one.probability for one in self.chances}
        return found

    def to_pandas(self) -> pandas.DataFrame:
        """The figures of each cable at the test torque, one row a cable. ``MbcdmError`` without pandas."""
        names = [field.name for field in fields(self.figures.cables[0])]
        rows = tuple(tuple(getattr(cable, name) for name in names) for cable in self.figures.cables)
        return ReportTable(tuple(names), rows).pandas()

    def text(self, width: int | None = None) -> str:
        """What ``mbcdm analyse`` prints: figures by subject, no line longer than ``width``."""
        return "\n".join(terminal_lines(self._written(), width))

    def html(self) -> str:
        """For notebooks: the tables of the text."""
        tables = (block.html() for _, block in blocks(self._written()) if isinstance(block, ReportTable))
        return f"<p>{self.figures.name}</p>" + "".join(tables)

    def _written(self) -> str:
        a, layout, data = self.figures, self.layout, self.data
        stages = [asdict(one) for one in stage_figures(layout)]
        motor = layout.motor_days[0].heat
        called = {"without losses": a.peak_torque_lossless_Nm, "with losses": a.peak_torque_with_losses_Nm}
        return rendered(
            "analysis.txt.j2",
            filters={"cycles": two_digits, "time": time_words},
            a=a,
            d=data | {"stages": stages},
            missing=self.missing,
            papers_test=papers_test(a.test[0].load_Nm),
            shafts=list(dict.fromkeys(shaft for t in a.shaft_turns for shaft in t.turned_deg)),
            factors={x.name: exp(x.sigma) for x in layout.losses.moving(layout.drive.loads.peak_torque_Nm, 1).losses},
            life=life_shown(data["life"]),
            life_is_worth=data["life"] and life_of(layout).told,
            preload=preload_shown(data["preload"]),
            capability=capability({"analysis": a.to_dict()} | ({"stages": stages} if stages else {})),
            above=[above_gearhead(a.limits, layout.drive.mounted, f"peak torque {x}", y) for x, y in called.items()],
            duty=data["duty"] and duty_shown(data["duty"]),
            still=1.0 / STANDSTILL_SHARE if motor.brushless else None,
            estimates=estimated(motor),
            motor_lines=motor_lines(asdict(a.motor)) if a.motor else (),
            paths=path_lines(layout, data["paths"]) if data["paths"] else [f"Cable paths: {self.missing['paths']}"],
            chances=list(chance_lines(self.chances)),
        )


def analyse_design(drive: Drive, found: Sequence[AsBuilt] = ()) -> AnalysisReport:
    """Every figure of the model, and the cables' paths. ``ModelError`` where the geometry leaves no free span.

    ``found``: the list ``as_built`` of the design's file, from which the probabilities of the checks follow.
    """
    layout = layout_of(drive)
    known = {"paths": path_data_or_reason(drive)} | {name: subject_or_reason(layout, name) for name in SUBJECTS}
    data, missing = {name: one[0] for name, one in known.items()}, {name: one[1] for name, one in known.items()}
    return AnalysisReport(analyse(layout), data, missing, layout, chances_of(drive, found))


def capability(report: Mapping[str, Any]) -> list[dict[str, Any]]:
    """Torque limits by cause in both directions, N m; None if a cause sets no limit."""
    rows: dict[str, dict[str, Any]] = {}
    names = CAUSES | ({"gearhead_rated": "torque that the first stage is made for"} if "stages" in report else {})
    for limit in report["analysis"]["limits"]:
        if "stages" in report and limit["cause"] == "gearhead_maximum":
            continue  # a first stage has one torque
        row = rows.setdefault(limit["cause"], {"cause": names.get(limit["cause"], limit["cause"])})
        row["plus" if limit["direction"] > 0 else "minus"] = limit
    return list(rows.values())


def above_gearhead(limits: Sequence[TorqueLimit], mounted: str, called: str, peaks_Nm: tuple[float, float]) -> str:
    """A sentence on a peak torque (+, -), which motor and cables allow, above a rating of what is ``mounted``, or "".

    Limits that count losses stand beside a lossless peak where only these were worked out.
    """
    for cause, holds, why in (
        ("gearhead_maximum", "at most", "which forbids it"),
        ("gearhead_rated", "continuously", "so hold it for a short time only"),
    ):
        low = [
            (limit.torque_Nm, peaks_Nm[limit.direction < 0])
            for limit in limits
            if limit.cause == cause and limit.torque_Nm < peaks_Nm[limit.direction < 0] * (1.0 - 1e-9)
        ]
        if low:
            limit_Nm, peak_Nm = min(low)
            return (
                f"the {called}, {peak_Nm:.3f} N m, is above what the {mounted} holds {holds}, {limit_Nm:.3f} N m, {why}"
            )
    return ""


def motor_lines(m: Mapping[str, Any]) -> tuple[str, ...]:
    """Sentences on ``analysis.motor``: its torque, the torque that the design requires, the inertia of its rotors."""
    return (
        f"Motor at {m['bus_voltage_V']:g} V: {m['continuous_torque_mNm']:.4g} mN m continuous with "
        f"{m['continuous_loss_W']:.3g} W lost in the copper, {m['peak_torque_mNm']:.4g} mN m short-time with "
        f"{m['peak_loss_W']:.3g} W; no load {m['no_load_speed_rad_s']:.4g} rad/s, which turns the drum at "
        f"{m['drum_no_load_speed_deg_s']:.4g} deg/s",
        f"At the required peak torque: {m['at_peak_load_torque_mNm']:.4g} mN m, {m['at_peak_load_current_A']:.3g} A, "
        f"{m['at_peak_load_loss_W']:.3g} W for each motor; the drum at most "
        f"{m['at_peak_load_drum_speed_deg_s']:.4g} deg/s",
        f"Rotors reflected to the drum {m['reflected_inertia_kg_m2'] * 1e3:.4g} g m^2",
    )
