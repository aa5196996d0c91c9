"""Parameters that a remedy may turn, and the search for the value at which a check passes.

A remedy is never a guess: the value it names was tried on the design. Only the one check is looked at; what else the
change does, the next run says.
"""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import replace
from functools import reduce
from math import ceil, floor, log10
from typing import Any, NamedTuple, cast

from mbcdm_cad.checks.finding import Finding
from mbcdm_cad.checks.subject import NoFigureError, Subject
from mbcdm_cad.design.drive import Drive

SIGNIFICANT_DIGITS = 4
BISECTIONS = 14
# How far a parameter is turned at most: to this multiple of itself, or its inverse.
REACH = 6.0
MOST_OFFERS = 3
TRIALS = 600
# A figure may be rounded by this much to be read more easily, if it still passes.
ROUNDING = 3e-3
ALL_RADII = "all radii of transmission"
ROPE_DIAMETER = "rope diameter_mm"


class Knob(NamedTuple):
    """A parameter under the name it has in the design file.

    ``scale``: its value is a factor on a list of radii. ``explicit``: only for designs whose radii are (not) given
    one by one.
    """

    path: str
    get: Callable[[Drive], float]
    put: Callable[[Drive, float], Drive]
    scale: bool = False
    explicit: bool | None = None


class Turn(NamedTuple):
    """A parameter and the sense in which to turn it, +1 up or -1 down."""

    path: str
    sense: int


def up(path: str) -> Turn:
    """Raise the parameter."""
    return Turn(path, 1)


def down(path: str) -> Turn:
    """Lower the parameter."""
    return Turn(path, -1)


def _read(drive: Drive, names: list[str]) -> Any:
    return reduce(getattr, names, cast(Any, drive))


def _field(path: str, attributes: str = "") -> Knob:
    names = (attributes or path).split(".")

    def put(drive: Drive, value: float) -> Drive:
        def set_in(block: Any, rest: list[str]) -> Any:
            inner = value if len(rest) == 1 else set_in(getattr(block, rest[0]), rest[1:])
            return replace(block, **{rest[0]: inner})

        changed: Drive = set_in(drive, names)
        return changed

    return Knob(path, lambda drive: float(_read(drive, names)), put)


def _radii(path: str, attributes: tuple[str, ...]) -> Knob:
    def put(drive: Drive, factor: float) -> Drive:
        cables = (replace(c, **{name: getattr(c, name) * factor for name in attributes}) for c in drive.cables)
        return replace(drive, cables=tuple(cables))

    return Knob(path, lambda drive: 1.0, put, True, None if path == ALL_RADII else True)


def _preload(drive: Drive, value: float) -> Drive:
    factor = value / drive.cables[0].preload_N
    return replace(drive, cables=tuple(replace(c, preload_N=c.preload_N * factor) for c in drive.cables))


def _input_ratio(drive: Drive, value: float) -> Drive:
    return replace(drive, cables=tuple(replace(c, input_radius_mm=c.guide_radius_mm / value) for c in drive.cables))


KNOBS: dict[str, Knob] = {
    knob.path: knob
    for knob in (
        _field("travel.half_angle_deg", "half_travel_deg"),
        _field("travel.stop_clearance_deg", "stop_clearance_deg"),
        _field("transmission.centre_distance_mm", "centre_distance_mm"),
        _radii(ALL_RADII, ("drum_radius_mm", "guide_radius_mm", "input_radius_mm")),
        _radii("transmission.input_radii_mm", ("input_radius_mm",)),
        _radii("transmission.guide_radii_mm", ("guide_radius_mm",)),
        Knob(
            "transmission.ratios.input_to_guide",
            lambda drive: drive.cables[0].guide_radius_mm / drive.cables[0].input_radius_mm,
            _input_ratio,
            explicit=False,
        ),
        Knob("rope.preload_N", lambda drive: drive.cables[0].preload_N, _preload),
        _field("rope.helix_lead_mm", "helix_lead_mm"),
        _field("rope.dead_turns", "dead_turns"),
        _field(ROPE_DIAMETER, "cable.diameter_mm"),
        _field("clearances.transfer_gap_mm"),
        _field("clearances.land_edge_mm"),
        *(
            _field(f"drum.{name}")
            for name in (
                "sector_half_angle_deg",
                "rim_inner_radius_mm",
                "outer_face_y_mm",
                "web_thickness_mm",
                "hub_diameter_mm",
                "hub_face_y_mm",
                "shaft_bore_mm",
            )
        ),
        *(
            _field(f"support.{name}")
            for name in (
                "back_y_mm",
                "back_plate_mm",
                "side_wall_mm",
                "motor_shelf_mm",
                "coupling_space_mm",
                "bearing_shelf_mm",
                "top_plate_mm",
                "rib_mm",
            )
        ),
        _field("loads.test_torque_Nm"),
        _field("loads.peak_torque_Nm"),
    )
}


class Budget:
    """How many trials all remedies of one run may take together; a count, so that the words never depend on speed."""

    def __init__(self, trials: int = TRIALS) -> None:
        self.left = trials


def offers(turns: tuple[Turn, ...], drive: Drive, measure: Callable[[Subject], Finding], budget: Budget) -> list[str]:
    """The first parameters that can mend the check alone: ``raise X from 34.6 to at least 36.2``."""
    found: list[str] = []
    for turn in turns:
        knob = KNOBS[turn.path]
        if len(found) == MOST_OFFERS or budget.left <= 0:
            break
        if knob.explicit is None or knob.explicit == drive.radii_explicit:
            value = passing_value(knob, turn.sense, drive, measure, budget)
            if value is not None:
                found.append(_offer(knob, turn.sense, drive, value))
    return found


def _offer(knob: Knob, sense: int, drive: Drive, value: float) -> str:
    bound, figure = "at least" if sense > 0 else "at most", f"{value:.{SIGNIFICANT_DIGITS}g}"
    if knob.path == ROPE_DIAMETER:
        return f"choose a rope of {bound} {figure} mm{_rope_of(drive, sense, value)}"
    if knob.path == ALL_RADII and not drive.radii_explicit:
        return f"scale transmission.drum_radii_mm by {bound} {figure} (the others follow)"
    if knob.scale:
        return f"scale {knob.path} by {bound} {figure}"
    verb = "raise" if sense > 0 else "lower"
    return f"{verb} {knob.path} from {knob.get(drive):.4g} to {bound} {figure}"


def _rope_of(drive: Drive, sense: int, diameter_mm: float) -> str:
    """The catalogue's nearest rope of the same construction on the right side, in brackets."""
    from mbcdm_cad.design.catalogue import package_entries

    ropes = package_entries("ropes")
    fitting = [
        (sense * entry["diameter_mm"], name)
        for name, entry in ropes.items()
        if entry["construction"] == drive.cable.construction and sense * (entry["diameter_mm"] - diameter_mm) >= 0.0
    ]
    return f" (such as {min(fitting)[1]})" if fitting else ""


def passing_value(
    knob: Knob, sense: int, drive: Drive, measure: Callable[[Subject], Finding], budget: Budget
) -> float | None:
    """The rounded value nearest to the present one, in the sense given, at which ``measure`` holds; None if none is."""

    def holds(value: float) -> bool:
        budget.left -= 1
        try:
            return measure(Subject(knob.put(drive, value))).holds
        except NoFigureError:
            return False

    now = knob.get(drive)
    size = abs(now) or 1.0
    step, before = size * 1e-3, now
    limit = size * (REACH - 1.0) if sense * (now or 1.0) > 0 else size * (1.0 - 1.0 / REACH)
    while not holds(now + sense * min(step, limit)):
        if step >= limit:
            return None
        before = now + sense * step
        step *= 2.0
    after = now + sense * min(step, limit)
    for _ in range(BISECTIONS):
        middle = 0.5 * (before + after)
        before, after = (before, middle) if holds(middle) else (middle, after)
    for digits in range(2, SIGNIFICANT_DIGITS + 1):
        unit = 10.0 ** (floor(log10(abs(after))) + 1 - digits) if after else 1.0
        for rounded in (round(after / unit) * unit, (ceil if sense > 0 else floor)(after / unit) * unit):
            if abs(rounded - after) <= ROUNDING * abs(after) and holds(rounded):
                return round(rounded, 12)
    return after


def floored(value: float) -> str:
    """A positive value rounded down to the digits that remedies show."""
    unit = 10.0 ** (floor(log10(value)) + 1 - SIGNIFICANT_DIGITS)
    return f"{floor(value / unit) * unit:.{SIGNIFICANT_DIGITS}g}"
