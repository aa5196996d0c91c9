"""Stiffness and strength of what carries the cables' forces: drum, payload's joint, mounting, frame."""

from math import hypot, pi

from mbcdm_cad.checks.comparison import Comparison, Findings, at_least, at_most, check, noted
from mbcdm_cad.checks.design_variables import LESS_TORQUE, up
from mbcdm_cad.checks.fixings import FRICTION, STRESS_SAFETY, lasting_MPa, stalled_Nm
from mbcdm_cad.design.paths import at
from mbcdm_cad.layouts.base import PRINTED_WINDUP
from mbcdm_cad.layouts.sector import SectorLayout
from mbcdm_cad.layouts.structure import drum_structure_of, structure_of
from mbcdm_cad.model.structure.causes import Structure
from mbcdm_cad.parts.drum_sector.dims import DEPTH_DIAMETERS, LEAST_DEPTH_MM, SLIP_SAFETY, PayloadJoint, hub, joint_load
from mbcdm_cad.parts.fits import SHEAR_SHARE, ScrewHold, clamp_force_N, screw_hold

# Turn of the structure over that of the cables from which on a design that asks for no stiffness is warned of, of metal
# and where drum or frame is printed: sized by the rules, drives have at most 2.4 and 4.7 (docs/structure.md).
SOFT, SOFT_PRINTED = 2.5, 5.0
# A material is no number, so that remedies offer none: a search alone takes a stiffer one.
_METALS = up(at.support.material, at.drum.material)


def _stress(what: str, strength_MPa: float, stress_MPa: float, load_Nm: float) -> Comparison:
    subject = f"{strength_MPa:.4g} MPa over {stress_MPa:.4g} MPa in {what} at {load_Nm:.4g} N m:"
    return at_least(subject, strength_MPa / max(stress_MPa, 1e-9), STRESS_SAFETY, "times")


def _stronger(s: SectorLayout) -> str:
    closed = "set drum.windows to none, or " if s.drum.windows else ""
    return f"{closed}choose a stronger drum.material"


@check(
    "Stress in the drum",
    "plane elements and plates, torsion of a tube; 1.5 on yield, 0.4 of it for plastics: usual rule, estimate",
    *up(at.drum.web_thickness_mm, at.drum.hub_diameter_mm),
    *LESS_TORQUE,
    advice=_stronger,
)
def drum_stress(s: SectorLayout) -> Findings:
    """Stress of web and rim, of the hub in torsion, and of the web at the stop pin, against the yield stress.

    At the larger of peak torque and stalled motors: web and rim by plane elements, corners as drawn, the web with its
    bending by cables beside its middle; the hub at 2.5 times an even tube, or as a layer where it is wide. Printed
    parts count with the strength that creep leaves.
    """
    d, drive = s.drum, s.drive
    material = drive.drum_material
    strength, load = lasting_MPa(material), max(drive.loads.peak_torque_Nm, stalled_Nm(s))
    torsion = hub(d, drive.screw(d.set_screw).thread_mm).shear_MPa(load)
    yield _stress("web and rim", strength, drum_structure_of(s).stress_MPa(load), load)
    yield _stress("the hub", strength * SHEAR_SHARE, torsion, load)
    if d.has_slot:
        pressed = load * 1e3 / d.stop_radius / (2.0 * s.frame.stop_pin_radius * (d.web_end_y - d.web_start_y))
        yield _stress("the web under the stop pin", strength, pressed, load)


@check(
    "Payload's screws hold peak torque and payload",
    "mu F r; class 8.8 at 0.7 of yield, mu 0.15, 1.5 on slip: usual values",
    *up(at.drum.hub_diameter_mm),
    *LESS_TORQUE,
    advice="choose a stronger drum.material",
    unit="times",
)
def payload_screws(s: SectorLayout) -> Findings:
    """The payload neither slips on the hub's face nor opens its joint, under the peak torque and its own load."""
    d, drive = s.drum, s.drive
    joint = PayloadJoint(d.payload_screw_thread, drive.drum_material, d.payload_insert, len(d.payload_places))
    circle, load = d.payload_circle_radius, joint_load(drive.loads.peak_torque_Nm, drive.loads.carried)
    screws = f"{joint.screws} x M{joint.thread_mm:g} at {joint.clamp_N:.4g} N on a circle of {2 * circle:.4g} mm"
    across = f" and {load.across_N:.4g} N across" if load.across_N > 0.0 else ""
    slips_Nm = f"{joint.slips_Nm(circle):.4g} N m by friction, over the peak torque of {load.torque_Nm:g} N m{across}"
    yield f"{screws} hold {slips_Nm}", joint.slips_times(load, circle), SLIP_SAFETY
    if load.tilt_Nm != 0.0:
        what = f"{screws} press the payload on the hub, over the pull on one of them by {load.tilt_Nm:.4g} N m of tilt"
        yield what, joint.opens_times(load, circle), SLIP_SAFETY


def _mount_advice(s: SectorLayout) -> str:
    """Dowels or a shoulder; where the frame is printed and has the screws' threads, inserts before that."""
    inserts = (
        "set printing.threads to inserts, flush with the face that lies on the base, whose holes must be smaller than "
        "they are, or "
        if s.mount_thread is not None and s.mount_thread.insert is None and s.printed_frame
        else ""
    )
    return f"{inserts}let dowels or a shoulder of what the frame stands on carry the torque, and waive this check"


@check(
    "Mounting screws hold the peak torque",
    "mu F r; class 8.8 at 0.7 of yield, mu 0.15, 1.5 on slip: usual values; inserts: base bears on the brass",
    *LESS_TORQUE,
    advice=_mount_advice,
    unit="times",
)
def mounting_screws(s: SectorLayout) -> Findings:
    """Torque at which the frame slips on what it is mounted on, over the peak torque."""
    hold, places = _mount_hold(s), s.frame.mounts
    middle = [sum(place[k] for place in places) / len(places) for k in (0, 1)]
    arms = sum(hypot(x - middle[0], z - middle[1]) for x, z in places)
    slips, peak = hold.slips_N(FRICTION) * arms * 1e-3, s.drive.loads.peak_torque_Nm
    inserts = " in inserts" if s.mount_thread is not None and s.mount_thread.insert else ""
    what = (
        f"{len(places)} x {s.mounting.words(s.mount_washers)}{inserts} at {hold.clamp_N:.4g} N hold the frame against "
        f"{slips:.4g} N m by friction, over the peak torque of {peak:g} N m"
    )
    yield what, slips / peak, SLIP_SAFETY


def _mount_hold(s: SectorLayout) -> ScrewHold:
    material, screw, thread = s.drive.frame_material, s.mounting, s.mount_thread
    if thread is not None:
        engaged = min(thread.depth_mm, max(LEAST_DEPTH_MM, DEPTH_DIAMETERS * screw.thread_mm))
        return screw_hold(screw.thread_mm, material, thread.insert, engaged)
    # The ring under a head or a washer presses the frame; a printed one yields to it in time.
    ring = pi / 4.0 * (screw.seat_mm(s.mount_washers) ** 2 - (2.0 * s.frame.mount_radius) ** 2)
    clamp = min(clamp_force_N(screw.thread_mm), lasting_MPa(material) * ring)
    return ScrewHold(clamp, clamp)


def _stiffer_frame(s: SectorLayout) -> str:
    """The walls that give most, the fields that thicken them as they are, and what else there is."""
    study, found = s.frame_study, s.frame_compliance
    if study is None or found is None:
        return ""
    most = sorted(found.shares_urad_Nm.items(), key=lambda share: -share[1])[:3]
    told = ", ".join(f"{name} {turn / found.windup_urad_Nm:.0%}" for name, turn in most)
    walls = ", ".join(f"support.{wall} ({thick:g})" for wall, thick in study.walls.items())
    times = f"{PRINTED_WINDUP:g} times the cables' turn" if s.printed_frame else "the cables' turn"
    metal = " or choose a metal support.material" if s.printed_frame else ""
    stated = f" or state limits.frame_windup_max_mrad, left out {times}"
    return (
        f"thicken the walls that bend most{f' ({told})' if told else ''}: {walls}{metal}"
        f"{stated if s.drive.limits.frame_windup_max_mrad is None else ''}"
    )


@check(
    "Frame stiff against the test torque",
    "limits.frame_windup_max_mrad; folded plates on the mounting screws",
    *_METALS[:1],
    advice=_stiffer_frame,
)
def frame_windup(s: SectorLayout) -> Comparison:
    """Turn of the drum by the frame's deflection at the test torque."""
    torque = s.drive.loads.test_torque_Nm
    found = s.frame_compliance
    if found is None:
        return noted("the frame counts as rigid: turn of the drum by it", 0.0, "mrad")
    what = f"the frame's deflection turns the drum at {torque:g} N m by"
    return at_most(what, found.windup_mrad(torque), s.windup_limit_mrad, "mrad")


def _stiffer(s: SectorLayout) -> str:
    """What gives most, cables too, with the fields that stiffen it: rules raise those that the file leaves open."""
    structure = structure_of(s)
    cables = f"the cables ({structure.cables_urad_Nm:.3g} urad/N m: thicker or stiffer rope)"
    return _softest(structure, {cables: structure.cables_urad_Nm})


@check(
    "Stiffness at the payload",
    "loads.stiffness_Nm_rad; compliance by cause",
    *up(at.drum.web_thickness_mm, at.drum.hub_diameter_mm, "all radii of transmission", at.rope.preload_N),
    *_METALS,
    advice=_stiffer,
)
def stiffness(s: SectorLayout) -> Comparison:
    """Stiffness at the payload at the test torque: cables, drum, shafts, bearings and frame, the inputs held."""
    structure, torque = structure_of(s), s.drive.loads.test_torque_Nm
    most = max(structure.at_payload, key=lambda c: c.urad_Nm)
    note = (
        f"cables {structure.cables_urad_Nm:.4g} urad/N m, all else {structure.payload_urad_Nm:.4g}, of it most by "
        f"{most.name}, {most.urad_Nm:.4g}"
    )
    what, found = f"stiffness at the payload at {torque:g} N m", structure.stiffness_Nm_rad
    wanted = s.drive.loads.stiffness_Nm_rad
    if wanted is None:
        return noted(what, found, "N m/rad", f"{note}; the design file asks for none")
    return at_least(what, found, wanted, "N m/rad", note)


def most_share(s: SectorLayout) -> float:
    """Turn of the structure over that of the cables beyond which a design that asks for no stiffness is warned of."""
    return SOFT_PRINTED if s.printed_frame or s.drive.drum_material.printed else SOFT


@check(
    "Structure's turn over the cables' turn",
    "loads.structure_share, else a warning beyond 2.5, printed 5: more than rules leave; compliance by cause",
    *up(at.drum.web_thickness_mm, at.drum.hub_diameter_mm),
    *_METALS,
    advice=lambda s: _softest(structure_of(s), {}),
    applies=lambda drive: drive.loads.structure_share is not None or drive.loads.stiffness_Nm_rad is None,
    warn=lambda drive: drive.loads.structure_share is None,
)
def structure_share(s: SectorLayout) -> Comparison:
    """Turn of the payload by all parts besides the cables over that by the cables, the inputs held."""
    structure, most = structure_of(s), s.drive.loads.structure_share or most_share(s)
    softest, cables = max(structure.at_payload, key=lambda c: c.urad_Nm), structure.cables_urad_Nm
    note = f"{structure.payload_urad_Nm:.4g} over {cables:.4g} urad/N m, most by {softest.name}, {softest.urad_Nm:.4g}"
    return at_most("turn of the structure over that of the cables", structure.over_cables, most, "", note)


def _softest(structure: Structure, turns: dict[str, float]) -> str:
    for cause in structure.at_payload:
        turns[f"{cause.name} ({cause.urad_Nm:.3g}: {cause.stiffer})"] = cause.urad_Nm
    first = " and ".join(sorted(turns, key=lambda name: -turns[name])[:2])
    return (
        f"stiffen what gives most, {first}; the rules raise what the file leaves to them as far as the other checks "
        "allow: leave more of it to them, widen the box or radii, or choose stiffer materials"
    )
