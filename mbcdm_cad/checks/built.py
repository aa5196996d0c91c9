"""Checks of the drawn solids: mass, box and interference. The build calls them with its figures."""

from __future__ import annotations

from collections.abc import Sequence
from typing import Any

from mbcdm_cad.checks.comparison import Check, CheckResult, Comparison, at_least, at_most, noted, worst
from mbcdm_cad.checks.run import judged
from mbcdm_cad.design.drive import Drive

# Checks that need the drawn solids, or seconds; the build adds them to those of the configuration.
BUILD_IDS = ("mass", "envelope", "interference", "printed_walls", "overhang")
_AXES = ("X", "Z", "Y")


def _measured_by_the_build(design: Any) -> Comparison:
    raise NotImplementedError("the build measures this")


def _result(
    check: Check, drive: Drive, what: str, actual: float, limit: float, unit: str, note: str = ""
) -> CheckResult:
    return _judged(check, drive, at_most(what, actual, limit, unit, note))


def _judged(check: Check, drive: Drive, found: Comparison) -> CheckResult:
    return judged(check, found, drive, lambda: str(check.advice))


def mass_check(drive: Drive, mass_g: float, sigma_g: float) -> CheckResult:
    """Mass of all items against the target; ``sigma_g`` is the uncertainty from estimated masses (one sigma)."""
    target = drive.targets
    title, source = "Mass against the target", "targets.mass_g; paper section 4.1"
    if target.mass_g is None:
        check = Check("mass", title, source, _measured_by_the_build)
        note = f"+- {sigma_g:.2g} g; the design file has no target"
        return _judged(check, drive, noted("mass", mass_g, "g", note))
    over = mass_g - target.mass_g
    advice = (
        f"{'thin' if over > 0 else 'thicken'} walls of the frame where their limits allow, about {abs(over):.3g} g, "
        "or set targets.mass_g to the required mass"
    )
    check = Check("mass", title, source, _measured_by_the_build, advice=advice)
    what = f"mass {mass_g:.2f} g +- {sigma_g:.2g}: from the target of {target.mass_g:g} g"
    return _result(
        check,
        drive,
        what,
        abs(over),
        target.mass_tolerance_g,
        "g",
        "" if target.prototype_mass_g is None else f"the prototype was measured at {target.prototype_mass_g:g} g",
    )


def envelope_check(drive: Drive, box_mm: Sequence[float]) -> CheckResult:
    """Box (X, Z, Y) of all solids with the drum centred against the target, the worst side."""
    target = drive.targets
    box = " x ".join(f"{size:.2f}" for size in box_mm)
    title, source = "Box of all solids", "targets.envelope_mm; paper section 4.1"
    if target.envelope_mm is None:
        check = Check("envelope", title, source, _measured_by_the_build)
        what = f"box X x Z x Y {box} mm: the longest side"
        return _judged(check, drive, noted(what, max(box_mm), "mm", "the design file has no target"))
    off = [abs(size - want) for size, want in zip(box_mm, target.envelope_mm, strict=True)]
    k = off.index(max(off))
    advice = "see the remedies of envelope_x, envelope_z and envelope_y, or set targets.envelope_mm to the required box"
    check = Check("envelope", title, source, _measured_by_the_build, advice=advice)
    what = f"box X x Z x Y {box} mm: {_AXES[k]} from the target of {target.envelope_mm[k]:g} mm"
    return _result(check, drive, what, off[k], target.envelope_tolerance_mm, "mm")


def interference_check(drive: Drive, clashes: Sequence[object]) -> CheckResult:
    """No two bodies overlap over the travel. The texts ``clashes`` say which bodies overlap and where."""
    listed = "; ".join(str(clash) for clash in clashes[:3]) + ("; ..." if len(clashes) > 3 else "")
    check = Check(
        "interference",
        "Interference over the travel",
        "solids under 0.01 mm^3, cables at d",
        _measured_by_the_build,
        advice="increase the space for the named parts: centre distance, steps, or smaller bought parts",
    )
    return _result(check, drive, "clashes over the travel", float(len(clashes)), 0.0, "clashes", listed)


def printed_walls_check(drive: Drive, found: Sequence[tuple[str, float, float, str]]) -> CheckResult:
    """Thinnest wall of each printed part against its material's; ``found``: part, wall (mm), limit (mm), where."""
    check = Check(
        "printed_walls",
        "Walls of printed parts as drawn",
        "material: min_wall_mm; filament: two lines of printing.nozzle_mm",
        _measured_by_the_build,
        severity="warn",
        advice="the wall is too thin at that place: choose another material, or for filament a finer nozzle_mm",
    )
    return _judged(
        check, drive, worst(at_least(f"wall of {part} at {where}", wall, low, "mm") for part, wall, low, where in found)
    )


def overhang_check(drive: Drive, areas_mm2: dict[str, float]) -> CheckResult:
    """Area of overhangs of more than 45 degrees from the vertical, of parts printed from filament, by part."""
    check = Check(
        "overhang",
        "Overhangs of parts of filament",
        "45 degrees: usual rule for filament",
        _measured_by_the_build,
        severity="warn",
        advice="print these parts with supports under such faces, or of a sintered material, which needs none",
    )
    each = ", ".join(f"{part} {area:.0f}" for part, area in areas_mm2.items() if area)
    what = "faces that overhang by more than 45 degrees in the position of the 3MF file"
    return _result(check, drive, what, sum(areas_mm2.values()), 0.0, "mm2", each)
