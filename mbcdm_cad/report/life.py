"""The life of the cables, as text for a terminal and as plain data for JSON and the page."""

from __future__ import annotations

from collections.abc import Iterator, Mapping, Sequence
from dataclasses import asdict, dataclass
from math import isnan
from typing import TYPE_CHECKING, Any

from mbcdm_cad.layouts.base import NoFigureError
from mbcdm_cad.report.table import ReportTable

if TYPE_CHECKING:
    from mbcdm_cad.layouts.base import Layout
    from mbcdm_cad.layouts.life import Life
    from mbcdm_cad.model.life.zones import AtPulley, RopeLife

# Points of a line in the picture of one rope.
_SHOWN_POINTS = 160
_QUANTILES = (0.1, 0.5, 0.9)


@dataclass(frozen=True)
class LifeReport:
    """Life of all cables of one design."""

    life: Life

    def to_dict(self) -> dict[str, Any]:
        """Everything, ready for JSON; cycles of the output, places in mm from the middle or stop on the input."""
        life, first = self.life, self.life.first
        return {
            "duty": life.duty,
            "cycles_per_h": life.cycles_per_h,
            "generic": life.generic,
            "first": None if first is None else first.name,
            "first_on": None if first is None else first.pulleys[0].body,
            "replace_at_cycles": None if first is None else first.reached(0.1),
            "replace_at_h": None
            if first is None or life.cycles_per_h is None
            else first.reached(0.1) / life.cycles_per_h,
            "refused": life.refused,
            "governs_instead": list(life.governs),
            "bend_ratio": life.layout.smallest_bend_ratio,
            "bend_ratio_minimum": life.layout.drive.cable.bend_ratio_minimum,
            "ropes": [_rope(rope) for rope in life.ropes],
            "helps": [asdict(each) for each in life.helps],
        }

    def table(self) -> ReportTable:
        """Bendings at each pulley of the weakest point of each cable, and its life."""
        rows: list[tuple[str, ...]] = []
        for rope in self.life.ropes:
            for k, p in enumerate(rope.pulleys):
                cycles = ("", "", "") if k or rope.refused else tuple(_cycles(rope.reached(q)) for q in _QUANTILES)
                share = "" if isnan(p.damage_share) else f"{p.damage_share:.0%}"
                tension = f"{p.tension_N[0]:.1f} to {p.tension_N[1]:.1f}"
                name = rope.name if k == 0 else ""
                rows.append((name, p.body, f"{p.bend_ratio:.1f}", f"{p.bendings:.3g}", tension, share, *cycles))
        heads = ("cable", "on", "D/d", "bendings", "tension N", "damage", "N10", "N50", "N90")
        return ReportTable(heads, tuple(rows))

    def lines(self) -> Iterator[str]:
        """Sentences below the table."""
        life, first = self.life, self.life.first
        least = life.layout.drive.cable.bend_ratio_minimum
        if life.layout.smallest_bend_ratio < least:
            yield f"the cables bend over D/d {life.layout.smallest_bend_ratio:.3g}; the maker's least is {least:g}"
        for reason in dict.fromkeys(rope.refused for rope in life.ropes if rope.refused):
            names = ", ".join(rope.name for rope in life.ropes if rope.refused == reason)
            yield f"no figure for {names}: {reason}"
        yield from (f"what governs instead: {text}" for text in life.governs)
        if first is None:
            return
        early = first.reached(0.1)
        hours = "" if life.cycles_per_h is None else f" ({early / life.cycles_per_h:.2g} h)"
        yield (
            f"{first.name} breaks first, on the {first.pulleys[0].body}: {life.told}; inspect it from "
            f"{_cycles(early / 2.0)} cycles on and replace it at {_cycles(early)}{hours}: its core breaks unseen"
        )
        helps = [f"{h.change} x{h.factor:.2g}{f' ({h.note})' if h.note else ''}" for h in life.helps]
        if helps:
            yield f"what helps, as a factor of its life: {', '.join(helps)}"


def _cycles(value: float) -> str:
    """Two digits are more than these figures are worth."""
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


def _pulley(pulley: AtPulley) -> dict[str, Any]:
    return asdict(pulley) | {"damage_share": None if isnan(pulley.damage_share) else pulley.damage_share}


def life_shown(found: Mapping[str, Any] | None) -> dict[str, Any] | None:
    """What page and report show of the block ``life``: a row for each cable and pulley, pictures along the cables."""
    if found is None:
        return None
    ropes, rows = found["ropes"], []
    for rope in ropes:
        for k, pulley in enumerate(rope["weakest_point"]):
            life = [_cycles(rope[key]) if rope[key] is not None else "none" for key in ("n10", "n50", "n90")]
            rows.append({"cable": rope["name"] if k == 0 else "", "life": life if k == 0 else [""] * 3, **pulley})
    bent = [{"label": rope["name"], **_steps(rope["zones"])} for rope in ropes]
    used = [
        {"label": rope["name"], "x": rope["place_mm"], "y": [1e5 * d for d in rope["damage_per_cycle"]]}
        for rope in ropes
        if rope["n50"] is not None
    ]
    along = {"label": "along the cable, from its middle or stop on the input", "unit": "mm"}
    charts = [("bent", "Bendings of each zone in a cycle of the output", "bendings", "", bent)]
    if used:
        charts.append(("used", "Life that 1000 cycles take", "of the median life", "%", used))
    return dict(found) | {
        "rows": rows,
        "too_small": found["bend_ratio"] < found["bend_ratio_minimum"],
        "median": next((_cycles(rope["n50"]) for rope in ropes if rope["name"] == found["first"]), None),
        "early": None if found["replace_at_cycles"] is None else _cycles(found["replace_at_cycles"]),
        "charts": {
            name: {"title": title, "x": along, "y": {"label": label, "unit": unit}, "lines": lines}
            for name, title, label, unit, lines in charts
        },
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


def life_report(layout: Layout) -> tuple[LifeReport | None, str]:
    """The figures of the cables' life; None, with the reason, where the cables have no tensions or places."""
    try:
        return LifeReport(layout.life), ""
    except NoFigureError as missing:
        return None, str(missing)
