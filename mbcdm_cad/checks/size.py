"""Mass and box against their targets, from the layout and of the drawn solids; and what only the build can measure."""

from collections.abc import Callable, Sequence
from functools import partial
from typing import Any

from mbcdm_cad.checks.comparison import Check, CheckResult, Comparison, at_least, at_most, check, noted, worst
from mbcdm_cad.checks.design_variables import Adjustment
from mbcdm_cad.checks.run import judged
from mbcdm_cad.design.drive import Drive
from mbcdm_cad.layouts.base import Layout, NoFigureError
from mbcdm_cad.parts.bill import Bill


def estimated_mass_g(bill: Bill) -> float:
    """Mass of all items, g: bought parts as in the catalogue, made ones by closed forms of their volume."""
    volumes = bill.volumes_mm3
    return sum(
        volumes[item.part] * item.material.density_g_cm3 * 1e-3 if item.mass_g is None else item.mass_g
        for item in bill.items
    )


def kept_mass_g(layout: Layout) -> float:
    """The same of a layout, worked out once."""
    return float(layout.once("estimated mass", lambda s: estimated_mass_g(s.once("bill", lambda s: s.bill()))))


@check(
    "Estimated mass",
    "targets.mass_g; volumes in closed form",
    advice="set targets.mass_g to the required mass, or change walls of the frame where their limits allow",
    warn=True,
)
def mass_estimate(s: Layout) -> Comparison:
    """Mass of all parts from their dimensions, within 1 % of the mass of the solids, which the build computes."""
    try:
        mass, targets = kept_mass_g(s), s.drive.targets
    except (ValueError, ZeroDivisionError) as error:
        raise NoFigureError(f"a part of this design has no volume: {error}") from None
    if targets.mass_g is None:
        return noted("estimated mass", mass, "g", "the design file has no target")
    what = f"estimated mass {mass:.1f} g: from the target of {targets.mass_g:g} g"
    return at_most(what, abs(mass - targets.mass_g), targets.mass_tolerance_g, "g")


# A design's box (X, Z, Y), mm.
Box = Callable[[Any], tuple[float, float, float]]


def _side(box_mm: Box, axis: int, s: Any) -> Comparison:
    """Box along one axis."""
    size, wanted, name = s.once("box_mm", box_mm)[axis], s.drive.targets.envelope_mm, "XZY"[axis]
    if wanted is None:
        return noted(f"box along {name}, drum centred", size, "mm", "the design file has no target")
    target = wanted[axis]
    what = f"box along {name}, drum centred, {size:.2f} mm: from the target of {target:g} mm"
    return at_most(what, abs(size - target), s.drive.targets.envelope_tolerance_mm, "mm")


def box_checks(box_mm: Box, source: str, adjust: Sequence[tuple[Adjustment, ...]]) -> tuple[Check, ...]:
    """The box of all parts against its target, from a layout before anything is drawn."""
    return tuple(
        Check(
            f"envelope_{name.lower()}",
            f"Box along {name}",
            source,
            partial(_side, box_mm, axis),
            adjust=adjust[axis],
            advice="set targets.envelope_mm to the required box",
        )
        for axis, name in enumerate("XZY")
    )


# Checks that need the drawn solids, or seconds; the build adds them to those of the configuration.
BUILD_IDS = ("mass", "envelope", "interference", "printed_walls", "overhang")


def _judged(
    drive: Drive, name: str, title: str, source: str, found: Comparison, advice: str = "", severity: str = "fail"
) -> CheckResult:
    """The result of a check that the build measures."""
    return judged(Check(name, title, source, lambda _: found, severity), found, drive, lambda: advice)


def mass_check(drive: Drive, mass_g: float, sigma_g: float) -> CheckResult:
    """Mass of all items against the target; ``sigma_g`` is the uncertainty from estimated masses (one sigma)."""
    target, advice = drive.targets, ""
    if target.mass_g is None:
        found = noted("mass", mass_g, "g", f"+- {sigma_g:.2g} g; the design file has no target")
    else:
        over, prototype = mass_g - target.mass_g, target.prototype_mass_g
        advice = (
            f"{'thin' if over > 0 else 'thicken'} walls of the frame where their limits allow, about "
            f"{abs(over):.3g} g, or set targets.mass_g to the required mass"
        )
        what = f"mass {mass_g:.2f} g +- {sigma_g:.2g}: from the target of {target.mass_g:g} g"
        note = "" if prototype is None else f"the prototype was measured at {prototype:g} g"
        found = at_most(what, abs(over), target.mass_tolerance_g, "g", note)
    return _judged(drive, "mass", "Mass against the target", "targets.mass_g; paper section 4.1", found, advice)


def envelope_check(drive: Drive, box_mm: Sequence[float]) -> CheckResult:
    """Box (X, Z, Y) of all solids with the drum centred against the target, the worst side."""
    target, box = drive.targets, " x ".join(f"{size:.2f}" for size in box_mm)
    if target.envelope_mm is None:
        what = f"box X x Z x Y {box} mm: the longest side"
        found = noted(what, max(box_mm), "mm", "the design file has no target")
    else:
        off = [abs(size - want) for size, want in zip(box_mm, target.envelope_mm, strict=True)]
        k = off.index(max(off))
        what = f"box X x Z x Y {box} mm: {'XZY'[k]} from the target of {target.envelope_mm[k]:g} mm"
        found = at_most(what, off[k], target.envelope_tolerance_mm, "mm")
    advice = "see the remedies of envelope_x, envelope_z and envelope_y, or set targets.envelope_mm to the required box"
    return _judged(drive, "envelope", "Box of all solids", "targets.envelope_mm; paper section 4.1", found, advice)


def interference_check(drive: Drive, clashes: Sequence[object]) -> CheckResult:
    """No two bodies overlap over the travel. The texts ``clashes`` say which bodies overlap and where."""
    listed = "; ".join(str(clash) for clash in clashes[:3]) + ("; ..." if len(clashes) > 3 else "")
    return _judged(
        drive,
        "interference",
        "Interference over the travel",
        "solids under 0.01 mm^3, cables at d",
        at_most("clashes over the travel", float(len(clashes)), 0.0, "clashes", listed),
        "increase the space for the named parts: centre distance, steps, or smaller bought parts",
    )


def printed_walls_check(drive: Drive, found: Sequence[tuple[str, float, float, str]]) -> CheckResult:
    """Thinnest wall of each printed part against its material's; ``found``: part, wall (mm), limit (mm), where."""
    return _judged(
        drive,
        "printed_walls",
        "Walls of printed parts as drawn",
        "material: min_wall_mm; filament: two lines of printing.nozzle_mm",
        worst(at_least(f"wall of {part} at {where}", wall, low, "mm") for part, wall, low, where in found),
        "the wall is too thin at that place: choose another material, or for filament a finer nozzle_mm",
        "warn",
    )


def overhang_check(drive: Drive, areas_mm2: dict[str, float]) -> CheckResult:
    """Area of overhangs of more than 45 degrees from the vertical, of parts printed from filament, by part."""
    each = ", ".join(f"{part} {area:.0f}" for part, area in areas_mm2.items() if area)
    what = "faces that overhang by more than 45 degrees in the position of the 3MF file"
    return _judged(
        drive,
        "overhang",
        "Overhangs of parts of filament",
        "45 degrees: usual rule for filament",
        at_most(what, sum(areas_mm2.values()), 0.0, "mm2", each),
        "print these parts with supports under such faces, or of a sintered material, which needs none",
        "warn",
    )
