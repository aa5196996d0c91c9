"""What turns the drum besides its cables: the compliance of every part between motor and payload, by cause.

Drum (web, rim, hub), shaft of the drum, its bearings, input pulleys, their bearings, gearheads and frame are computed
under the loads that 1 N m on the payload puts on them, with the cables' changes of tension in the shares of their
stiffness. Twice the energy that a part stores is the turn that it causes. docs/structure.md says what was compared with
what.
"""

from __future__ import annotations

from collections.abc import Callable, Iterator, Mapping, Sequence
from dataclasses import dataclass, replace
from math import radians
from typing import TYPE_CHECKING, NamedTuple, TypeVar, overload

import numpy as np

from mbcdm_cad.design.stage import STIFFNESS_FACTOR
from mbcdm_cad.layouts.base import Layout, NoFigureError
from mbcdm_cad.layouts.sector import SectorLayout
from mbcdm_cad.layouts.springs import spring_urad_Nm
from mbcdm_cad.model.equilibrium import bearing_loads, sum_per_input
from mbcdm_cad.model.si import MM
from mbcdm_cad.model.stiffness import unit_tensions_N
from mbcdm_cad.model.structure.causes import (
    BY_BEARINGS,
    BY_FRAME,
    BY_GEARHEADS,
    BY_PARTS,
    BY_SPRINGS,
    Acting,
    Cause,
    Section,
    Structure,
    ball_bearing_N_mm,
    bearing_urad_Nm,
    bending_urad_Nm,
    torsion_urad_Nm,
)
from mbcdm_cad.model.structure.drum_sector import CELLS, Isotropic, sector_study
from mbcdm_cad.parts.drum_sector.dims import hub, land_pulls, sector_shape
from mbcdm_cad.routes import Floats
from mbcdm_cad.routes.route import BodyLoad, body_load, two_bearing_reactions_N

if TYPE_CHECKING:
    from mbcdm_cad.design.bought import Bearing, Material, Servo
    from mbcdm_cad.design.drive import Drive
    from mbcdm_cad.parts.input_pulley.dims import InputPulleyDims

_T = TypeVar("_T")
_Y = np.array([0.0, 1.0, 0.0])
# Torsional stiffness of small planetary gearheads at their output, N m/rad at 40 mm diameter; it grows with the cube of
# the diameter. An estimate from catalogues of larger ones, known to a factor of two.
GEARHEAD_NM_RAD_40 = 3.4e3
SPRINGS = "springs of the terminals"
# Cells of the drum's mesh where only changes of the drum are weighed.
ROUGH_CELLS = 8
# Radius that a neck without metal counts with, mm.
LEAST_RADIUS_MM = 0.1
_SOFT_SPRINGS = "drum.spring or fewer of them, or a longer wrap by drum.sector_half_angle_deg"
_HUB, _PULLEYS, _SHAFTS = "drum.hub_diameter_mm", "the bearings of input_pulleys", "drive.motor and drive.gearhead"


@overload
def structure_of(layout: SectorLayout) -> Structure: ...
@overload
def structure_of(layout: Layout) -> Structure | None: ...
def structure_of(layout: Layout) -> Structure | None:
    """Compliance of all parts of a design besides the cables, by cause, and the drum's stress; None if all are rigid.

    Raises ``NoFigureError`` where a part has no metal to carry the load.
    """
    return (
        _carrying(layout, "structure", lambda one: structure_with(one, drum_structure_of(one)))
        if isinstance(layout, SectorLayout)
        else None
    )


def drum_structure_of(layout: SectorLayout) -> DrumStructure:
    """Compliance and stress of the drum alone, which the sizing asks for before there is a frame.

    Raises ``NoFigureError`` where it has no metal to carry the load.
    """
    return _carrying(layout, "drum structure", drum_study)


def _carrying(layout: SectorLayout, name: str, figures: Callable[[SectorLayout], _T]) -> _T:
    layout.require_geometry()
    try:
        return layout.once(name, figures)
    except ValueError as error:
        raise NoFigureError(f"the structure has no figures: {error}") from None


def structure_with(layout: SectorLayout, drum: DrumStructure) -> Structure:
    """All causes of one design with a drum's figures, where these are known already or asked for less exactly.

    Raises ``NoFigureError`` for a frame, ``ValueError`` for a drum or a shaft, that has no metal to carry the load.
    """
    d = layout.loads.si
    unit = unit_tensions_N(d)
    torques = sum_per_input(d, unit, d.input_radius_m)
    causes = [
        *_gearheads(layout, torques),
        *_stage(layout, torques),
        *_inputs(layout, unit, torques),
        *(cause for each in layout.attachments for cause in each.structure(unit)),
        *drum.causes,
        *_drum_shaft(layout, unit),
    ]
    if layout.drive.anchor_m_N > 0.0:
        springs = Cause(SPRINGS, spring_urad_Nm(layout), factor=BY_SPRINGS, after_slip=True, stiffer=_SOFT_SPRINGS)
        causes.append(springs)
    frame = layout.frame_compliance
    if frame is not None:
        if not np.isfinite(frame.windup_urad_Nm):
            raise NoFigureError("the frame has no metal that carries the load")
        causes.append(Cause("frame", frame.windup_urad_Nm, factor=BY_FRAME, stiffer="the frame's walls"))
    return Structure(
        tuple(causes),
        layout.loads.test_urad_Nm,
        drum.stress_MPa,
        layout.drive.loads.peak_torque_Nm,
        float(layout.drive.drum_material.yield_MPa),
        motor_encoders=layout.drive.encoder.absent and not _senses_output(layout.drive.servo),
    )


def _senses_output(servo: Servo | None) -> bool:
    """Whether a servo's own sensor is behind its gears, so that it holds the horn in place of its motor."""
    return servo is not None and servo.sensor == "output"


def input_play_rad(drive: Drive, motors_held: bool) -> float:
    """Play of an input, from one side to the other, by the gears of a servo and by a stage before it; rad.

    With the sensors holding the inputs only the play behind a sensor at the motor is left.
    """
    servo, stage, play = drive.servo, drive.stage, 0.0
    if servo is not None and (motors_held or not _senses_output(servo)):
        play += radians(servo.lash_deg) / (1.0 if stage is None else stage.ratio)
    if stage is not None and (motors_held or drive.encoder.absent):
        play += stage.lash_rad
    if drive.cable_stage is not None and (motors_held or drive.encoder.absent):
        play += drive.cable_stage.lash_rad
    return play


def lash_rad(drive: Drive, motors_held: bool) -> float:
    """The same at the drum. Inputs side by side share it: the drum is free only as far as all are."""
    cable = drive.cables[0]
    return input_play_rad(drive, motors_held) * cable.input_radius_mm / cable.drum_radius_mm


@dataclass(frozen=True)
class InputLoads:
    """Forces along x on the bearings of a drive with one input, and the torque about it that the motor holds."""

    lower_N: float
    upper_N: float
    rear_N: float
    front_N: float
    torque_Nm: float


def one_input_loads(layout: SectorLayout, tension_N: Floats, height_sign: int = 1) -> InputLoads:
    """Loads by the tensions; ``height_sign``: -1 where the bearings' heights count against the input's axis."""
    d = layout.si
    loads = bearing_loads(d, tension_N)
    pulley, axis = loads.inputs[0], d.routes.inputs[0].axis
    lower, upper = (height_sign * at * MM for at in layout.input_bearings_mm(0))
    pair = two_bearing_reactions_N(pulley.force_N, pulley.moment_Nm, pulley.height_m, lower, upper, axis)
    rear, front = layout.drum_bearings_mm
    # The drum's bearings share force and couple along x by their distances; the moment about its axis is not theirs.
    on_drum = float(loads.drum.force_N[0])
    on_front = (-float(loads.drum.moment_Nm[2]) - rear * MM * on_drum) / ((front - rear) * MM)
    torque = float((d.sigma * np.asarray(tension_N) * d.input_radius_m).sum())
    return InputLoads(-float(pair[0, 0]), -float(pair[1, 0]), on_drum - on_front, on_front, torque)


def elastic(material: Material) -> Isotropic:
    """The elastic constants of a material of the catalogue."""
    return Isotropic(material.youngs_modulus_GPa * 1e3, material.poisson_ratio)


def _acting(load: BodyLoad, sense: int = 1) -> Acting:
    """A load on a body at its height, which counts along the levels where ``sense`` is that of the levels."""
    return Acting(load.height_m * 1e3 * sense, load.force_N, load.moment_Nm * 1e3)


def _supported(loads: Sequence[Acting], supports_mm: tuple[float, float], axis: Floats) -> list[Acting]:
    """The reactions of two supports to all the loads on a shaft."""
    along = (float(axis[0]), float(axis[1]), float(axis[2]))
    pair = sum(two_bearing_reactions_N(a.force_N, a.couple_Nmm, a.at_mm, *supports_mm, along) for a in loads)
    return [Acting(at, force, np.zeros(3)) for at, force in zip(supports_mm, np.asarray(pair), strict=True)]


def _bearings_urad_Nm(
    specs: Sequence[Bearing], changed: Sequence[Acting], rest: Sequence[Acting], axial_N: float = 0.0
) -> float:
    """Turn by the give of bearings, from the changes of their loads for 1 N m and their loads at rest."""
    return sum(
        bearing_urad_Nm(
            float(np.linalg.norm(change.force_N)),
            ball_bearing_N_mm(spec.bore_mm, spec.outer_diameter_mm, float(np.linalg.norm(carried.force_N)), axial_N),
        )
        for spec, change, carried in zip(specs, changed, rest, strict=True)
    )


class DrumStructure(NamedTuple):
    """Web with rim, hub to the set screws and hub to the face; and the largest stress of web and rim under a torque of
    either sense, N m, with the preload, MPa."""

    causes: tuple[Cause, ...]
    stress_MPa: Callable[[float], float]


def drum_study(layout: SectorLayout, *, rough: bool = False, flat: bool = False) -> DrumStructure:
    """The drum of one design, which needs no frame; ``rough``: on fewer cells, ``flat``: see :func:`sector_study`.

    Raises ``ValueError`` where it has no metal to carry the load."""
    drive, dims, d = layout.drive, layout.drum, layout.loads.si
    unit = unit_tensions_N(d)
    names = {terminal.cable_name for terminal in dims.tensioners}
    # Of 1 N m. Sectors side by side on one shaft are equal, and each carries its own cables' share.
    shares = {
        name: float(share)
        for name, share in zip(d.cable_names, np.abs(unit) * d.drum_radius_m, strict=True)
        if name in names
    }
    own = sum(shares.values())
    pulls = land_pulls(
        dims, {name: share / own for name, share in shares.items()}, {c.name: c.preload_N for c in drive.cables}
    )
    # Hubs in line pass the torque on, each a share more.
    count = layout.hubs_in_line
    passed = sum((k / count) ** 2 for k in range(1, count))
    whole = own if count == 1 else 1.0
    thread = drive.screw(dims.set_screw).thread_mm
    cells = ROUGH_CELLS if rough else CELLS
    study = sector_study(sector_shape(dims), hub(dims, thread), pulls, elastic(drive.drum_material), cells, flat=flat)

    def stress_MPa(torque_Nm: float) -> float:
        return max(float(study.von_mises_MPa(way * torque_Nm * own).max()) for way in (1.0, -1.0))

    causes = (
        Cause("drum: web and rim", study.web_urad_Nm * own, in_drum=True, stiffer=f"drum.web_thickness_mm and {_HUB}"),
        Cause(
            "drum: hub to the set screws",
            study.hub_to_screws_urad_Nm * (whole + passed) + study.hub_to_face_urad_Nm * passed,
            in_drum=True,
            stiffer=_HUB,
        ),
        Cause(
            "drum: hub to the payload", study.hub_to_face_urad_Nm * whole, at_encoder=False, in_drum=True, stiffer=_HUB
        ),
    )
    return DrumStructure(causes, stress_MPa)


def _drum_shaft(layout: SectorLayout, unit: Floats) -> Iterator[Cause]:
    """Bending of the shaft from its bearings to the hub, and its bearings."""
    drive, shaft, loads = layout.drive, layout.drum_shaft, layout.loads
    routes, supports = loads.si.routes, layout.drum_bearings_mm
    changed, rest = (_acting(body_load(routes, routes.drum.name, tension)) for tension in (unit, loads.idle))
    # The hub is stiff, so that the load bends the shaft up to where it begins.
    at = max(layout.drum.hub_start_y, supports[1])
    couple = changed.couple_Nmm + np.cross((changed.at_mm - at) * _Y, changed.force_N)
    on_hub = Acting(at, changed.force_N, couple - couple[1] * _Y)
    held = _supported([changed], supports, _Y)
    section = Section(supports[0], at, shaft.radius, shaft.bore_radius)
    bend = bending_urad_Nm(_Y, [on_hub, *held], [section], elastic(drive.shaft_material))
    yield Cause("drum's shaft", bend, stiffer="drum.bearing")
    spec, spring = drive.bearings.drum, layout.preload_spring.force_N
    give = _bearings_urad_Nm((spec, spec), held, _supported([rest], supports, _Y), spring)
    yield Cause("drum's bearings", give, factor=BY_BEARINGS, stiffer="drum.bearing")


def _gearheads(layout: SectorLayout, torques_Nm: Floats) -> Iterator[Cause]:
    gear, stage = layout.drive.gearhead, layout.drive.stage
    if gear.absent:
        return
    stated = gear.stiffness_Nm_rad
    stiffness = GEARHEAD_NM_RAD_40 * (gear.diameter_mm / 40.0) ** 3 if stated is None else stated
    if stage is not None:
        # Behind a stage it carries less, and what it turns is that much less at the input.
        stiffness *= stage.ratio**2
    first = layout.drive.cable_stage is not None
    name = layout.drive.mounted if first else "gearheads (estimate)" if stated is None else "gearheads"
    yield Cause(
        name,
        float((torques_Nm**2).sum() / stiffness) * 1e6,
        before_input=True,
        factor=BY_GEARHEADS if stated is None else BY_PARTS,
        stiffer="first_stage" if first else "drive.gearhead",
    )


def _stage(layout: SectorLayout, torques_Nm: Floats) -> Iterator[Cause]:
    stage = layout.drive.stage
    if stage is None:
        return
    stated = stage.stated_stiffness_Nm_rad is not None
    yield Cause(
        stage.words if stated else f"{stage.words} (estimate)",
        float((torques_Nm**2).sum() / stage.stiffness_Nm_rad) * 1e6,
        before_input=True,
        factor=BY_PARTS if stated else STIFFNESS_FACTOR,
        stiffer="stage",
    )


def _inputs(layout: SectorLayout, unit: Floats, torques_Nm: Floats) -> Iterator[Cause]:
    """Torsion of the input pulleys from the coupling to their cables, their bending, and their bearings.

    Of pulleys on the motors' shafts those of the shafts with the pulleys on them, from their front bearings on.
    """
    d, drive, sense, overhung = layout.loads.si, layout.drive, layout.levels_sense, layout.drive.overhung
    material = elastic(drive.material("steel") if overhung else drive.pulley_material)
    specs = drive.bearings.input_lower, drive.bearings.input_upper
    twist = bend = give = 0.0
    for i, (pulley, torque) in enumerate(zip(layout.inputs, torques_Nm, strict=True)):
        route, supports = d.routes.inputs[i], layout.input_bearings_mm(i)
        axis = sense * np.array(route.axis)
        if overhung:
            sections, start, pulls = _shaft_sections(layout, i), supports[1], [unit]
        else:
            sections, start = pulley_sections(pulley), layout.collar.top_z
            # Each cable bends the pulley at its own height.
            pulls = [unit * (np.arange(d.n_cables) == j) for j in range(d.n_cables) if d.input_of[j] == i]
        middle = (pulley.land_bottom_z + pulley.land_top_z) / 2.0
        twisted = [replace(s, start_mm=max(s.start_mm, start), end_mm=min(s.end_mm, middle)) for s in sections]
        carrying = [s for s in twisted if s.end_mm > s.start_mm]
        twist += torsion_urad_Nm(float(torque) * 1e3, carrying, material.shear_MPa, collar=not overhung)
        *loads, idle = (_acting(body_load(d.routes, route.name, pull), sense) for pull in (*pulls, layout.loads.idle))
        held = _supported(loads, supports, axis)
        bend += bending_urad_Nm(axis, [*loads, *held], sections, material)
        give += _bearings_urad_Nm(specs, held, _supported([idle], supports, axis))
    if overhung:
        before = not _senses_output(drive.servo)
        yield Cause("motors' shafts, torsion", twist, before_input=before, stiffer=_SHAFTS)
        yield Cause("motors' shafts, bending", bend, stiffer=_SHAFTS)
        yield Cause("motors' own bearings (estimate)", give, factor=BY_GEARHEADS, stiffer=_SHAFTS)
        return
    yield Cause("input pulleys, torsion", twist, before_input=True, stiffer=_PULLEYS)
    yield Cause("input pulleys, bending", bend, stiffer=_PULLEYS)
    yield Cause("input pulleys' bearings", give, factor=BY_BEARINGS, stiffer=_PULLEYS)


def _shaft_sections(layout: SectorLayout, index: int) -> list[Section]:
    """The shaft from its rear bearing on, and the pulley with the shaft in it, as one shaft of steel.

    A pulley thinner than its bore, and one without metal beyond the shaft, hold nothing, as in :func:`pulley_sections`.
    """
    drive, pulley, (rear, face) = layout.drive, layout.inputs[index], layout.input_bearings_mm(index)
    radius, end = drive.gearhead.shaft_diameter_mm / 2.0, face + drive.gearhead.shaft_length_mm
    if drive.servo is not None:
        end = pulley.journal_bottom_z
    share = drive.pulley_material.youngs_modulus_GPa / drive.material("steel").youngs_modulus_GPa
    found = [Section(rear, pulley.journal_bottom_z, radius)]
    for start, stop, outside in (
        (pulley.journal_bottom_z, pulley.lower_neck_bottom_z, pulley.lower_journal_radius),
        (pulley.lower_neck_bottom_z, pulley.land_bottom_z, pulley.lower_neck_radius),
        (pulley.land_bottom_z, pulley.land_top_z, pulley.lower_surface_radius),
    ):
        for low, high in ((start, min(end, stop)), (max(end, start), stop)):
            if high > low:
                bore = pulley.bore_radius if low < pulley.bore_top_z else 0.0
                inside = radius if high <= end else 0.0
                metal = share * (max(outside, bore) ** 4 - bore**4) + inside**4
                found.append(Section(low, high, max(metal**0.25, LEAST_RADIUS_MM)))
    return found


def overhung_sag_mm(layout: SectorLayout) -> float:
    """Largest distance by which the cables pull an input pulley aside on its motor's shaft, middle of the land."""
    d, own, sense = layout.loads.si, layout.drive.bearings.input_lower, layout.levels_sense
    steel, most = elastic(layout.drive.material("steel")), 0.0
    for i, route in enumerate(d.routes.inputs):
        axis, supports, sections = sense * np.array(route.axis), layout.input_bearings_mm(i), _shaft_sections(layout, i)
        for loads in layout.loads.on_bodies:
            acting = _acting(loads.inputs[i], sense)
            held = _supported([acting], supports, axis)
            # Twice the energy of the load at its height is load times sag.
            twice = bending_urad_Nm(axis, [acting, *held], sections, steel)
            twice += _bearings_urad_Nm((own, own), held, held)
            most = max(most, twice / 1e3 / max(float(np.linalg.norm(acting.force_N)), 1e-9))
    return most


def pulley_sections(pulley: InputPulleyDims) -> list[Section]:
    """Each length of a pulley with its radius and bore, the grooves counted as cut away all round.

    A neck to which its cable leaves no metal (``bearing_shoulders`` fails then) has a radius of ``LEAST_RADIUS_MM``:
    the figures of such a drive are those of a pulley that holds nothing, and all its checks are still told.
    """
    lengths = (
        Section(pulley.journal_bottom_z, pulley.lower_neck_bottom_z, pulley.lower_journal_radius),
        Section(pulley.lower_neck_bottom_z, pulley.land_bottom_z, pulley.lower_neck_radius),
        Section(pulley.land_bottom_z, pulley.wall_z, pulley.lower_surface_radius),
        Section(pulley.wall_z, pulley.land_top_z, pulley.upper_surface_radius),
        Section(pulley.land_top_z, pulley.upper_neck_top_z, pulley.upper_neck_radius),
        Section(pulley.upper_neck_top_z, pulley.journal_top_z, pulley.upper_journal_radius),
    )
    solid = [replace(s, radius_mm=max(s.radius_mm, LEAST_RADIUS_MM)) for s in lengths]
    return [s for length in solid for s in _bored(length, pulley.bore_radius, pulley.bore_top_z)]


def _bored(section: Section, bore_mm: float, to_mm: float) -> Iterator[Section]:
    """A section with the bore that it has up to a height."""
    cut = min(max(to_mm, section.start_mm), section.end_mm)
    if cut > section.start_mm:
        yield replace(section, end_mm=cut, bore_mm=bore_mm)
    if section.end_mm > cut:
        yield replace(section, start_mm=cut)


def axle_causes(
    layout: SectorLayout,
    bodies: Mapping[str, tuple[float, float]],
    unit: Floats,
    supports_mm: tuple[float, float],
    spec: Bearing,
    axle: Section,
    material: Isotropic,
) -> Iterator[Cause]:
    """Bending of a fixed axle between its supports and give of the two bearings on it in each body that cables pass.

    ``bodies``: the middles of both bearings along the axis, by the body's name. The axle bends by all of them at once.
    """
    routes, on_axle, found = layout.loads.si.routes, list[Acting](), list[Cause]()
    for body, middles in bodies.items():
        axis = np.array(routes.body(body).axis)
        changed, rest = (
            [
                replace(a, force_N=-a.force_N)
                for a in _supported([_acting(body_load(routes, body, tension))], middles, axis)
            ]
            for tension in (unit, layout.loads.idle)
        )
        on_axle += changed
        give = _bearings_urad_Nm((spec, spec), changed, rest)
        found.append(Cause(f"{body}'s bearings", give, factor=BY_BEARINGS))
    acting = [*on_axle, *_supported(on_axle, supports_mm, axis)]
    yield Cause(f"{' and '.join(bodies)}'s axle", bending_urad_Nm(axis, acting, [axle], material))
    yield from found
