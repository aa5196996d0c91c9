"""Springs in the terminals: they fit, do not go flat or free, and move only at torques that the file accepts."""

from collections.abc import Iterator
from contextlib import suppress

import numpy as np

from mbcdm_cad.checks.comparison import Comparison, Findings, at_most, check_for
from mbcdm_cad.checks.design_variables import down, up
from mbcdm_cad.checks.strength import wound_ends
from mbcdm_cad.design.bought import SpringSpec
from mbcdm_cad.design.catalogue import package_entries
from mbcdm_cad.design.drive import CableRun
from mbcdm_cad.design.paths import at
from mbcdm_cad.layouts.base import NoFigureError
from mbcdm_cad.layouts.sector import SectorLayout
from mbcdm_cad.layouts.springs import spring_start_Nm, spring_turn_urad_Nm, spring_urad_Nm

# Play of a spring round its stud, mm: DIN EN 16983 asks for 0.2 on a mandrel of up to 16 mm; with more than the largest
# (estimate) it sits beside the stud's axis.
LEAST_PLAY_MM, MOST_PLAY_MM = 0.199, 1.0
# Least share of a spring's force at the preload that is left with the cable at its lowest tension (estimate).
LEFT_SHARE = 0.05
# Least share of the preload that is left after the rope has bedded in, before it is tightened again (estimate).
KEPT_SHARE = 0.5
# Springs on one stud that a remedy names at most: the file's bound of drum.spring_count.
MOST_SPRINGS = 40
# A higher stack makes the sector, and so the rope that beds in, a little longer (estimate, beside 1 % seen).
_LONGER = 1.05
# Further turn of the drum by springs that move, over that of the cables (the share that structure may have).
MOVED_SHARE = 0.25
_spring_check = check_for(lambda drive: drive.spring is not None)


def _spring(s: SectorLayout) -> SpringSpec:
    """The spring of the terminals. Raises ``NoFigureError`` where they have none."""
    spring: SpringSpec | None = s.drive.spring
    if spring is None:
        raise NoFigureError("the terminals have no springs")
    return spring


def _fitting(s: SectorLayout) -> str:
    """Terminals of the package that lead this spring."""
    names = [name for name, e in package_entries("tensioners").items() if led(_spring(s), e["thread_mm"])]
    return f"choose drum.tensioner: {' or '.join(names)}, or leave it out" if names else "choose another drum.spring"


@_spring_check("Springs fit on their studs", "catalogue of springs", advice=_fitting)
def spring_fits(s: SectorLayout) -> Findings:
    """The stud passes through the springs with play and leads them."""
    spring, stud = _spring(s), s.drive.tensioner
    play, what = spring.inside_mm - stud.thread_mm, f"play of {spring.name} round the stud of {stud.name}"
    yield what, play, LEAST_PLAY_MM
    yield at_most(what, play, MOST_PLAY_MM, "mm")


def _strong(s: SectorLayout) -> str:
    """Springs of the catalogue that carry the largest tension; the rules choose a terminal that leads them."""
    strong = sorted((e.usable_N, e.name) for e in s.drive.springs if e.usable_N >= s.loads.highest_N)
    if not strong:
        return "add a stronger spring to catalogue: springs:, or leave drum.spring out"
    return f"choose drum.spring: {' or '.join(name for _, name in strong[:4])}, and leave drum.tensioner to the rules"


@_spring_check(
    "Springs are not pressed flat at peak torque",
    "catalogue of springs: usable share of their travel",
    *down(at.loads.peak_torque_Nm, at.rope.preload_N),
    advice=_strong,
    unit="times",
)
def spring_flat(s: SectorLayout) -> Findings:
    """Usable force of a spring over the largest tension at peak torque.

    That is of the span: what friction on the drum keeps from the terminal does not count, since it may be low.
    """
    spring, highest = _spring(s), s.loads.highest_N
    what = f"usable force of {spring.name}, {spring.usable_N:.4g} N, over the largest tension {highest:.4g} N"
    yield what, spring.usable_N / highest, 1.0


@_spring_check(
    "Springs stay pressed at peak torque",
    "model with wraps that end; a twentieth of the preload: estimate",
    *up(at.rope.preload_N),
    *down(at.loads.peak_torque_Nm),
    unit="of preload",
)
def spring_free(s: SectorLayout) -> Findings:
    """Lowest tension at the terminals at peak torque, at both ends of the travel: a free spring holds no nut."""
    for name, low in _lowest_shares(s):
        yield f"lowest tension at the spring of {name} over its preload", low, LEFT_SHARE


def _lowest_shares(s: SectorLayout) -> list[tuple[str, float]]:
    """(cable, lowest tension at its terminal over its preload) at peak torque both ways."""
    _spring(s)
    d, found = s.loads.si, []
    for wound, tension in wound_ends(s, d):
        # Slip that comes to the terminal leaves more tension there than in the span, by friction on the drum.
        eased = np.exp(d.friction_coefficient * wound.drum_wrap_rad)
        lowest = np.minimum(tension.min(axis=1) / d.preload_N * eased, 1.0)
        found += [(c.name, float(low)) for c, low in zip(s.drive.cables, lowest, strict=True)]
    return found


def _stiffer(s: SectorLayout) -> str:
    """How few springs may be taken: fewer turn the drum less, and keep less of the preload."""
    least = max(int(np.ceil(_give_wanted_mm_N(s) * _spring(s).stiffness_N_mm)), 1)
    if s.drive.drum.spring_count > least:
        return f"lower drum.spring_count, to no less than {least}, with which the preload is kept"
    return ""


@_spring_check(
    "Turn by springs that move",
    "model with wraps that end; a quarter of the cables' turn: estimate",
    *up(at.rope.preload_N, at.drum.sector_half_angle_deg),
    advice=_stiffer,
    warn=True,
)
def spring_hold(s: SectorLayout) -> Comparison:
    """Further turn by springs at the test torque, where the wraps on the drum are shortest, over that of the cables."""
    _spring(s)
    moved = 100.0 * spring_urad_Nm(s) / s.loads.test_urad_Nm
    start = s.once("springs start", spring_start_Nm)
    note = f"the first terminal moves at {start:.3g} N m" if np.isfinite(start) else "no terminal moves at any torque"
    what = f"turn by springs at {s.drive.loads.test_torque_Nm:g} N m over that of the cables"
    return at_most(what, moved, 100.0 * MOVED_SHARE, "%", note)


def _more(s: SectorLayout) -> str:
    """How many springs keep the share, or else which softer ones on the same stud do."""
    own, most, ways = _spring(s), _give_wanted_mm_N(s), []
    wanted = int(np.ceil(most * own.stiffness_N_mm))
    if wanted <= MOST_SPRINGS:
        ways.append(f"raise drum.spring_count to {wanted}")
    softer = [
        (count * e.free_mm, f"{e.name} with drum.spring_count: {count}")
        for e in s.drive.springs
        if e.stiffness_N_mm < own.stiffness_N_mm
        and e.usable_N >= s.loads.highest_N
        and led(e, s.drive.tensioner.thread_mm)
        and (count := int(np.ceil(_LONGER * most * e.stiffness_N_mm))) <= MOST_SPRINGS
    ]
    if softer:
        ways.append(f"choose drum.spring: {min(softer)[1]}")
    if not ways:
        return _NO_SPRING
    return "; ".join((" or ".join(ways), *_told_by_hold(s, most), "else tighten again after the first runs"))


@_spring_check(
    "Preload that springs keep while the rope beds in",
    "catalogue: bedding_in_share and setting_ratio; a half: estimate",
    advice=_more,
    warn=True,
    unit="of preload",
)
def spring_keeps(s: SectorLayout) -> Findings:
    """Share of the preload left after the rope has bedded in and its ends have set, nuts untouched."""
    _spring(s)
    rope = s.drive.cable
    for c, length, lost in _bedded_in_mm(s):
        give = length / rope.axial_stiffness_N + s.drive.anchor_m_N * 1e3
        # A rope that grows by more than rope and springs gave way is loose.
        left = max(1.0 - lost / give / c.preload_N, 0.0)
        yield f"preload of {c.name} left after bedding-in", left, KEPT_SHARE


def _bedded_in_mm(s: SectorLayout) -> Iterator[tuple[CableRun, float, float]]:
    """(cable, its length under tension, what the rope's bedding-in and the setting of its ends add to it)."""
    for c, length in zip(s.drive.cables, s.tensioned_lengths_mm(), strict=True):
        yield c, length, s.drive.cable.bedding_in_share * length + s.drive.setting_mm


def _told_by_hold(s: SectorLayout, give_mm_N: float) -> Iterator[str]:
    """What :func:`spring_hold` says of springs that give so much, where it warns."""
    with suppress(NoFigureError):
        moved = 100.0 * spring_turn_urad_Nm(s, give_mm_N * 1e-3) / s.loads.test_urad_Nm
        if moved > 100.0 * MOVED_SHARE:
            told = f"spring_hold then tells {moved:.4g} % (limit at most {100.0 * MOVED_SHARE:g})"
            yield told if s.drum.whole else f"{told}: raise drum.sector_half_angle_deg too"


def _give_wanted_mm_N(s: SectorLayout) -> float:
    """Give of the springs of one cable with which each cable keeps its share of the preload."""
    stiffness_N = s.drive.cable.axial_stiffness_N
    return max(lost / ((1.0 - KEPT_SHARE) * c.preload_N) - length / stiffness_N for c, length, lost in _bedded_in_mm(s))


_NO_SPRING = "tighten again after the first runs: no springs of the catalogue that this terminal leads keep so much"


def led(spring: SpringSpec, thread_mm: float) -> bool:
    """Whether a stud leads the spring."""
    return LEAST_PLAY_MM <= spring.inside_mm - thread_mm <= MOST_PLAY_MM
