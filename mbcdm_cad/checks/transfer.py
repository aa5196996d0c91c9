"""The transfer to the drum, and the wrap on it over the travel; gaps against the sum of the tolerances of the parts.

Step k's transfer point is (0, +r_k, r_ok), r_k the radius of the pulley before the drum: its step is the plane z =
r_ok, the drum's step the plane y = r_k. By Eq. (1) all lie on a line through the apex, the pitch line of a bevel pair.
Gaps are computed in the half planes x = 0, where the two round bodies are nearest.

Both ends of a cable are anchored, so a wrap shorter than the slip zone is allowed. Eq. (5) and (6), for endless wraps,
then give another turn than the model with the wraps that are there.

Tolerances: run-out counts half its reading on each radius, play half its size to either side; the drum's bearings have
no play, because a spring presses them apart."""

from collections.abc import Callable
from math import atan2, degrees, hypot
from typing import Any, NamedTuple

import numpy as np

from mbcdm_cad.checks.comparison import Check, Comparison, Findings, at_least, at_most, check, noted, worst
from mbcdm_cad.checks.design_variables import Adjustment, down, up
from mbcdm_cad.design.paths import at
from mbcdm_cad.layouts.base import Layout, NoFigureError
from mbcdm_cad.layouts.sector import SectorLayout
from mbcdm_cad.model.equilibrium import solve_equilibrium
from mbcdm_cad.model.si import ModelError
from mbcdm_cad.model.tolerance import Contribution, StackUp, tightest
from mbcdm_cad.parts.drum_sector.design import SectorDrive, SectorRun
from mbcdm_cad.parts.making import Body, body_accuracy, land_band_mm, model_tolerances, rope_band_mm

# A tenth of the tolerance of good turning on a step plane: allows for rounding of nominal dimensions only.
PITCH_LINE_MM = 0.001
# Largest chamfer of the edges of lands; the contact line must lie further from the edge (derived).
EDGE_BREAK_MM = 0.1
# Run-out of both bodies together: 0.02 mm each and that of their bearings (estimate).
RUN_OUT_MM = 0.05


@check("Transfer points on one pitch line", "derived from paper Eq. (1): pitch cone")
def pitch_line(s: SectorLayout) -> Findings:
    """Distance of each transfer point from the line through the apex and the outermost transfer point."""
    outer = s.steps[-1]
    length = hypot(outer.land_y_mm, outer.drum_radius_mm)
    for c in s.steps[:-1]:
        yield at_most(
            f"transfer point of step {c.step} (y {c.land_y_mm:g}, z {c.drum_radius_mm:g}) off the pitch line",
            abs(c.land_y_mm * outer.drum_radius_mm - c.drum_radius_mm * outer.land_y_mm) / length,
            PITCH_LINE_MM,
            "mm",
        )


@check("", "derived: pitch cone", advice="order the radii from step 1, the smallest, upwards")
def radii_rise(s: SectorLayout) -> Findings:
    """From step to step the radii of both bodies increase together."""
    for a, b in zip(s.steps[:-1], s.steps[1:], strict=True):
        for body, rise in ((s.before_drum, b.land_y_mm - a.land_y_mm), ("drum", b.drum_radius_mm - a.drum_radius_mm)):
            yield f"{body} radius of step {b.step} over step {a.step}", rise, EDGE_BREAK_MM


@check(
    "Drum lands wide enough for half a cable and the edge",
    "",
    *down("rope diameter_mm", at.clearances.land_edge_mm),
    *up("all radii of transmission"),
)
def land_width(s: SectorLayout) -> Findings:
    """The radius increases from step to step by at least half a cable plus the edge margin; the rest is a gap.

    The land's edge must lie between a cable's flank and the next cable's contact line: delta r_k >= d/2 + edge margin.
    """
    need = s.flank_mm + s.drive.clearances.land_edge_mm
    for a, b in zip(s.steps[:-1], s.steps[1:], strict=True):
        yield (
            f"drum land of step {a.step}: delta r_{s.before_drum[0]}",
            b.land_y_mm - a.land_y_mm,
            need,
            f"d/2 {s.flank_mm:g} + edge margin {s.drive.clearances.land_edge_mm:g}; flank gap "
            f"{b.land_y_mm - a.land_y_mm - need:.4g} mm along the whole wrap",
        )


@check(
    "Contact lines clear of the lands' edges",
    "derived: edges broken by up to 0.1 mm",
    *up(at.clearances.land_edge_mm),
    *down(at.clearances.transfer_gap_mm),
)
def land_edge(s: SectorLayout) -> Findings:
    """Distance from the contact line of every cable to the broken edge of its land."""
    lands = s.drum.lands
    for c, land in zip(s.steps, lands, strict=True):
        yield f"contact line of {c.name} from its land's edge", c.land_y_mm - land.y_start, EDGE_BREAK_MM


@check("Outermost land carries its cable", "derived", *up(at.drum.outer_face_y_mm))
def outermost_land(s: SectorLayout) -> Findings:
    """The outermost land is wide enough for its cable up to the drum's outer face."""
    c = s.steps[-1]
    what = f"drum's outer face beyond the flank of {c.name}"
    yield what, s.drive.drum.outer_face_y_mm - c.land_y_mm - s.flank_mm, EDGE_BREAK_MM


def body_gaps_mm(s: SectorLayout) -> list[tuple[str, int, float]]:
    """Gaps between every step before the drum and every drum land in the half plane x = 0, along y or z, in mm.

    Each with its description, the index of the step and the gap.
    """
    return [
        (
            f"{s.before_drum} step {j + 1} to drum land {k + 1}",
            j,
            max(land.y_start - surface, bottom - land.surface_radius_mm),
        )
        for j, (surface, bottom) in enumerate(s.steps_before_drum)
        for k, land in enumerate(s.drum.lands)
    ]


@check(
    "",
    "paper section 2.2 (placed closely); run-out of 0.05 mm: estimate",
    *up(at.clearances.transfer_gap_mm),
    *down(at.clearances.land_edge_mm),
    *up("rope diameter_mm", "all radii of transmission"),
)
def bodies_clear(s: SectorLayout) -> Comparison:
    """The smallest gap between the two bodies, including the walls of their steps."""
    return worst(at_least(name, gap, RUN_OUT_MM, "mm") for name, _, gap in body_gaps_mm(s))


@check(
    "",
    "derived: a wider gap lets a cable slip in",
    *down(at.clearances.transfer_gap_mm),
    *up(at.clearances.land_edge_mm, "rope diameter_mm"),
)
def transfer_gap(s: SectorLayout) -> Findings:
    """At every transfer point the gap between the bodies is less than half a cable, so that no cable slips into it."""
    for land, (surface, _) in zip(s.drum.lands, s.steps_before_drum, strict=True):
        yield at_most(f"gap at the transfer of step {land.step}", land.y_start - surface, s.flank_mm, "mm")


def transfer_checks(body: str, keep_on_line: str) -> tuple[Check, ...]:
    """The family; ``body``: the body before the drum, ``keep_on_line``: how its radii stay on the pitch line."""
    return (
        pitch_line.but(advice=keep_on_line),
        radii_rise.but(title=f"Radii of {body} and drum rise together"),
        land_width.but(source=f"derived: delta r_{body[0]} >= d/2 + edge margin"),
        land_edge,
        outermost_land,
        bodies_clear.but(title=f"{body.capitalize()} and drum do not touch"),
        transfer_gap.but(title=f"{body.capitalize()} and drum closer than half a cable"),
    )


# Remaining land under the cable between transfer point and terminal at the end of travel (estimate).
LEAST_WRAP_DEG = 2.0
FULL_TURN_DEG = 360.0
MORE_WRAP: tuple[Adjustment, ...] = (*down(at.travel.half_angle_deg), *up(at.drum.sector_half_angle_deg))


def _larger_angle(s: SectorLayout) -> str:
    """Remedy for a cable whose wrap ends too early because the file states where its terminal is."""
    least = degrees(s.half_travel_rad) + LEAST_WRAP_DEG
    asked = [
        c.name for c in s.steps if c.terminal_angle_rad is not None and degrees(s.smallest_wrap_rad(c)) < LEAST_WRAP_DEG
    ]
    return (
        f"state a terminal_angle_deg of at least {least:.4g} for {', '.join(asked)}, or leave it out" if asked else ""
    )


@check(
    "Wrap left on the drum at both ends of travel",
    "derived; 2 deg: estimate",
    *MORE_WRAP,
    advice=_larger_angle,
    unit="deg",
)
def wrap_left(s: SectorLayout) -> Findings:
    """The cable still wraps the drum at both ends of the travel."""
    for c in s.steps:
        what = f"wrap left of {c.name} (anchor at {degrees(s.anchor_rad(c)):.4g} deg)"
        yield what, degrees(s.smallest_wrap_rad(c)), LEAST_WRAP_DEG


@check(
    "Wrap on the drum stays under a turn",
    "paper section 2.1",
    *down(at.drum.sector_half_angle_deg, at.travel.half_angle_deg),
)
def wrap_under_turn(s: SectorLayout) -> Findings:
    """Cable and terminal take less than a full turn; otherwise they would reach the transfer point a second time."""
    for t in s.drum.tensioners:
        what = f"largest wrap of {t.cable_name}, terminal included"
        yield at_most(
            what, degrees(t.anchor_rad + s.half_travel_rad + atan2(t.last_tip, t.radius_mm)), FULL_TURN_DEG, "deg"
        )


def _slip_beside_wrap(s: SectorLayout, states: tuple[np.ndarray, ...]) -> str:
    """The cable whose slip angle exceeds its smallest wrap most, in words."""
    friction, found = s.drive.friction_coefficient, []
    for k, c in enumerate(s.drive.cables):
        slip = max(abs(np.log(max(float(state[k]), 1e-9) / c.preload_N)) for state in states) / friction
        found.append((degrees(s.smallest_wrap_rad(c)), degrees(slip), c.name))
    wrap, slip, name = min(found, key=lambda row: row[0] - row[1])
    return f"{name} slips over {slip:.3g} deg of drum and has {wrap:.3g} deg at an end of the travel"


def _turns(s: SectorLayout) -> tuple[np.ndarray, np.ndarray]:
    """Turn of the drum under the loads (4,) of ``s.loads`` beside none, with endless wraps (4,) and with real (4, 3).

    Real ones are those in the middle and at both ends of the travel.
    """
    loads, angles = s.loads, (-s.half_travel_rad, 0.0, s.half_travel_rad)
    try:
        wraps = [np.stack(side, axis=1) for side in zip(*(s.wraps_rad(angle) for angle in angles), strict=True)]
        real = loads.si.spread(len(angles)).with_(input_wrap_rad=wraps[0], drum_wrap_rad=wraps[1])
        turned = solve_equilibrium(real, loads.torques_Nm[:, None]).drum_angle_rad
    except ModelError as error:
        raise NoFigureError(f"the model has no answer: {error}") from None
    endless = loads.equilibrium.drum_angle_rad
    return endless[1:] - endless[0], turned[1:] - turned[0]


def _turn_with_real_wraps(s: SectorLayout, first: int, load_Nm: float, states: tuple[np.ndarray, ...]) -> Comparison:
    """How much further the drum turns with wraps that end at anchors and stops than with endless ones.

    The largest share over the travel and both ways, loads ``first`` and the next one of :func:`_turns`. It is not above
    zero, since what is beyond an anchor does not stretch: figures for endless wraps are on the safe side, so that
    nothing is judged here.
    """
    endless, real = (turn[first : first + 2] for turn in s.once("turns with real wraps", _turns))
    further = float((real / endless[:, None] - 1.0).max())
    what = f"what the wraps that are there, in place of endless ones, change in the drum's turn at {load_Nm:g} N m"
    return noted(what, 100.0 * further, "%", _slip_beside_wrap(s, states))


@check("Wraps that end, at the test torque", "paper Eq. (5), (6); solved with the wraps over the travel")
def wrap_slip_test(s: SectorLayout) -> Comparison:
    """How far the turn at the test torque hangs on where the wraps end."""
    loads = s.loads
    return _turn_with_real_wraps(s, 2, s.drive.loads.test_torque_Nm, (loads.test_forward, loads.test_back))


@check("Wraps that end, at the peak torque", "paper Eq. (5), (6); solved with the wraps over the travel")
def wrap_slip_peak(s: SectorLayout) -> Comparison:
    """How far the turn at the peak torque hangs on where the wraps end."""
    loads = s.loads
    return _turn_with_real_wraps(s, 0, s.drive.loads.peak_torque_Nm, (loads.peak_forward, loads.peak_back))


WRAPS = (wrap_left, wrap_under_turn)
SLIPS = (wrap_slip_test, wrap_slip_peak)


# Its argument is a configuration's design under test.
Stacks = Callable[[Any], list[StackUp]]
# Standard deviations on either side that hold 95 % of all drives.
MOST_DRIVES = 1.96


class TransferStacks(NamedTuple):
    """Gaps at the transfer from a body to the drum with the tolerances that change them; ``place``: what holds it."""

    body: str
    place: str

    def contributions(self, drive: SectorDrive, cable: SectorRun, per_rope: float = 0.0) -> tuple[Contribution, ...]:
        """Distance along y between the body's surface and the wall of a drum land, and ``per_rope`` of the rope."""
        own: Body = "pulley" if drive.passed_material is None else "passed"
        body, drum, frame = (body_accuracy(drive, part) for part in (own, "drum", "frame"))
        bodies = (
            Contribution(f"radius of the {self.body}'s step", land_band_mm(drive, cable.land_y_mm, own)),
            Contribution(f"run-out of the {self.body}", body.run_out_mm, 0.5),
            Contribution(f"play of the {self.body}'s bearings", body.bearing_play_mm, 0.5),
            Contribution(f"place of the {self.body}'s {self.place}", frame.position_mm),
            Contribution("place of the drum's bearings in the frame", frame.position_mm),
            Contribution("place of the land's wall on the drum", drum.position_mm),
            Contribution("run-out of the drum's faces", drum.run_out_mm, 0.5),
        )
        return (*bodies, Contribution("rope's diameter", rope_band_mm(drive), per_rope)) if per_rope else bodies

    def gap(self, s: SectorLayout) -> list[StackUp]:
        """Half a cable minus the gap at each transfer point."""
        return [
            StackUp(
                f"half a cable over the gap at the transfer of step {c.step}, mm",
                s.flank_mm - (land.y_start - surface),
                self.contributions(s.drive, c, 0.5),
            )
            for c, land, (surface, _) in zip(s.steps, s.drum.lands, s.steps_before_drum, strict=True)
        ]

    def bodies_clear(self, s: SectorLayout) -> list[StackUp]:
        """Gap between body and drum."""
        return [
            StackUp(f"{what}, mm", gap, self.contributions(s.drive, s.steps[step]))
            for what, step, gap in body_gaps_mm(s)
        ]

    def land_edge(self, s: SectorLayout) -> list[StackUp]:
        """Distance of the contact lines, half a rope over the surface, from the broken edges of their lands."""
        return [
            StackUp(
                f"contact line of {c.name} from its land's broken edge, mm",
                c.land_y_mm - land.y_start - EDGE_BREAK_MM,
                self.contributions(s.drive, c, 0.5),
            )
            for c, land in zip(s.steps, s.drum.lands, strict=True)
        ]


def ratio_contributions(drive: SectorDrive, cable: SectorRun) -> tuple[Contribution, ...]:
    """Contributions to the total ratio r_o / r_m, relative to it."""
    r_o, r_m = cable.drum_radius_mm, cable.input_radius_mm
    return (
        Contribution("drum radius", land_band_mm(drive, r_o, "drum"), 1.0 / r_o),
        Contribution("input radius", land_band_mm(drive, r_m, "pulley"), -1.0 / r_m),
        Contribution("rope's diameter", rope_band_mm(drive), (1.0 / r_o - 1.0 / r_m) / 2.0),
    )


@check("Transmission error by the tolerances", "linear theory, two sigma")
def transmission_error(s: Layout) -> Comparison:
    """Largest error of the drum's angle over the travel that the tolerances cause: linear theory, two sigma."""
    from mbcdm_cad.model.tolerance import linear_error

    names, error = linear_error(s.loads.si, s.half_travel_rad, model_tolerances(s.drive))
    whole = np.sqrt((error**2).sum(axis=0))
    pose = int(np.argmax(whole))
    most = names[int(np.argmax(np.abs(error[:, pose])))]
    what = "drum off by at most, over the travel, in 95 % of drives"
    return noted(what, MOST_DRIVES * float(whole[pose]) * 1e3, "mrad", f"zero at the centred drum; most by the {most}")


def stack_check(name: str, title: str, of: Stacks, advice: str | Callable[[Any], str]) -> Check:
    """The check that warns if the margin of ``of`` is smaller than its tolerance stack."""

    def against(s: Any) -> Comparison:
        """The smallest gap is compared with the root sum of squares of the tolerances that change it."""
        stack = tightest(of(s))
        worst_case = f"worst case {stack.worst_case:.3g} mm; largest share: {stack.costliest.name}"
        what = stack.figure.removesuffix(", mm")
        return at_least(what, stack.margin, stack.rss, "mm", f"sum of the tolerances (RSS); {worst_case}")

    source = "root sum of squares of the tolerances in parts/fits.py and making"
    return Check(f"{name}_stack", title, source, against, "warn", advice=advice)
