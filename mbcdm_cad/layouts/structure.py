"""What turns the drum besides its cables: the compliance of every part between motor and payload, by cause.

Drum (web, rim, hub), shaft of the drum, its bearings, input pulleys, their bearings, gearheads and frame are computed
under the loads that 1 N m on the payload puts on them, with the cables' changes of tension in the shares of their
stiffness. Twice the energy that a part stores is the turn that it causes. docs/structure.md says what was compared with
what.
"""

from __future__ import annotations

from collections.abc import Callable, Iterator
from dataclasses import dataclass, field
from typing import TYPE_CHECKING, Any

import numpy as np

from mbcdm_cad.layouts.base import NoFigureError
from mbcdm_cad.model.equilibrium import two_bearing_reactions_N
from mbcdm_cad.model.stiffness import unit_tensions_N
from mbcdm_cad.model.structure.drum_sector import Isotropic, sector_study
from mbcdm_cad.model.structure.shafts import (
    Acting,
    Section,
    ball_bearing_N_mm,
    bearing_urad_Nm,
    bending_urad_Nm,
    torsion_urad_Nm,
)
from mbcdm_cad.parts.drum_sector.structure import hub, land_pulls, sector_shape
from mbcdm_cad.routes import Floats
from mbcdm_cad.routes.loads import BodyLoad, body_load

if TYPE_CHECKING:
    from mbcdm_cad.design.bought import Bearing, Material
    from mbcdm_cad.layouts.sector import SectorLayout

_Y = np.array([0.0, 1.0, 0.0])
# Torsional stiffness of small planetary gearheads at their output, N m/rad at 40 mm diameter; it grows with the cube of
# the diameter. An estimate from catalogues of larger ones, known to a factor of two.
GEARHEAD_NM_RAD_40 = 3.4e3


@dataclass(frozen=True)
class Cause:
    """Turn of the payload per N m by one part's strain.

    ``at_encoder``: whether the drum's encoder sees it too. ``before_input``: whether it lies between the motor and the
    input's encoder, so that a controller that holds the inputs by their encoders takes it away.
    """

    name: str
    urad_Nm: float
    at_encoder: bool = True
    before_input: bool = False


@dataclass(frozen=True)
class Structure:
    """Compliance of a drive by cause, and the stress of its drum.

    ``cables_urad_Nm``: turn by the cables at the test torque, over that torque. ``stress_MPa`` gives the largest
    equivalent stress of the drum's web and rim under a torque of either sense, N m, with the preload; ``yield_MPa``:
    the yield stress of its material.
    """

    causes: tuple[Cause, ...]
    cables_urad_Nm: float
    stress_MPa: Callable[[float], float] = field(repr=False, compare=False)
    peak_torque_Nm: float
    yield_MPa: float

    @property
    def peak_stress_MPa(self) -> float:
        """Largest stress of the drum's web and rim at the peak torque."""
        return self.stress_MPa(self.peak_torque_Nm)

    @property
    def payload_urad_Nm(self) -> float:
        """Turn of the payload besides that of the cables, the inputs held by their encoders."""
        return sum(c.urad_Nm for c in self.causes if not c.before_input)

    @property
    def encoder_urad_Nm(self) -> float:
        """As :attr:`payload_urad_Nm`, as the drum's encoder sees it."""
        return sum(c.urad_Nm for c in self.causes if c.at_encoder and not c.before_input)

    @property
    def motor_urad_Nm(self) -> float:
        """As :attr:`payload_urad_Nm`, the motors' shafts held in place of the inputs."""
        return sum(c.urad_Nm for c in self.causes)

    @property
    def over_cables(self) -> float:
        """Turn of the structure over that of the cables, as the payload sees it."""
        return self.payload_urad_Nm / self.cables_urad_Nm

    @property
    def stiffness_Nm_rad(self) -> float:
        """Test torque over the payload's turn by cables and structure, the inputs held by their encoders."""
        return 1e6 / (self.cables_urad_Nm + self.payload_urad_Nm)

    def to_dict(self) -> dict[str, Any]:
        """Everything, ready for JSON."""
        return {
            "causes": [
                {
                    "name": c.name,
                    "urad_Nm": c.urad_Nm,
                    "seen_by_drum_encoder": c.at_encoder,
                    "between_motor_and_input_encoder": c.before_input,
                }
                for c in self.causes
            ],
            "cables_urad_Nm": self.cables_urad_Nm,
            "structure_at_payload_urad_Nm": self.payload_urad_Nm,
            "structure_at_drum_encoder_urad_Nm": self.encoder_urad_Nm,
            "structure_motors_held_urad_Nm": self.motor_urad_Nm,
            "structure_over_cables": self.over_cables,
            "stiffness_at_payload_Nm_rad": self.stiffness_Nm_rad,
            "drum_peak_stress_MPa": self.peak_stress_MPa,
            "drum_yield_MPa": self.yield_MPa,
        }


def structure_of(layout: SectorLayout) -> Structure:
    """All causes of one design.

    Raises ``NoFigureError`` for a frame, ``ValueError`` for a drum or a shaft, that has no metal to carry the load.
    """
    d = layout.loads.si
    unit = unit_tensions_N(d)
    own, stress = _drum(layout, unit)
    frame = layout.frame_compliance
    causes = [*_gearheads(layout, unit), *_inputs(layout, unit), *layout.passed_structure(unit), *own]
    causes += _drum_shaft(layout, unit)
    if frame is not None:
        if not np.isfinite(frame.windup_urad_Nm):
            raise NoFigureError("the frame has no metal that carries the load")
        causes.append(Cause("frame", frame.windup_urad_Nm))
    return Structure(
        tuple(causes),
        layout.loads.test_urad_Nm,
        stress,
        layout.drive.loads.peak_torque_Nm,
        float(layout.drive.drum.material.yield_MPa),
    )


def elastic(material: Material) -> Isotropic:
    """The elastic constants of a material of the catalogue."""
    return Isotropic(material.youngs_modulus_GPa * 1e3, material.poisson_ratio)


def idle_load_N(layout: SectorLayout, body: str) -> BodyLoad:
    """Load of the cables on a body at no load."""
    si = layout.loads.si
    return body_load(si.routes, body, layout.loads.idle)


def _bearing_urad_Nm(spec: Bearing, change_N: Floats, at_rest_N: Floats, axial_N: float = 0.0) -> float:
    """Turn by one bearing's give, urad per N m."""
    radial = float(np.linalg.norm(at_rest_N))
    stiffness = ball_bearing_N_mm(spec.bore_mm, spec.outer_diameter_mm, radial, axial_N)
    return bearing_urad_Nm(float(np.linalg.norm(change_N)), stiffness)


def _drum(layout: SectorLayout, unit: Floats) -> tuple[list[Cause], Callable[[float], float]]:
    """Web with rim, hub to the set screws and hub to the face; and the largest stress of the web under a torque."""
    drive, dims = layout.drive, layout.drum
    moments = {c.name: abs(tension) * c.drum_radius_mm * 1e-3 for c, tension in zip(drive.cables, unit, strict=True)}
    whole = sum(moments.values())
    names = {terminal.cable_name for terminal in dims.tensioners}
    # Sectors side by side on one shaft are equal, and each carries its own cables' share of the torque.
    own = sum(moment / whole for name, moment in moments.items() if name in names)
    shares = {name: moments[name] / whole / own for name in names}
    pulls = land_pulls(dims, shares, {c.name: c.preload_N for c in drive.cables})
    thread = drive.screw(dims.set_screw).thread_mm
    study = sector_study(sector_shape(dims), hub(dims, thread), pulls, elastic(drive.drum.material))

    def stress_MPa(torque_Nm: float) -> float:
        return max(float(study.von_mises_MPa(way * torque_Nm * own).max()) for way in (1.0, -1.0))

    return [
        Cause("drum: web and rim", study.web_urad_Nm * own),
        Cause("drum: hub to the set screws", study.hub_to_screws_urad_Nm * own),
        Cause("drum: hub to the payload", study.hub_to_face_urad_Nm * own, at_encoder=False),
    ], stress_MPa


def _drum_shaft(layout: SectorLayout, unit: Floats) -> Iterator[Cause]:
    """Bending of the shaft from its bearings to the hub, and its bearings."""
    drive, shaft, name = layout.drive, layout.drum_shaft, layout.loads.si.routes.drum.name
    spec = drive.bearings.drum
    rear, front = (y + spec.width_mm / 2.0 for y in (shaft.rear_bearing_y, shaft.front_bearing_y))
    at = max(layout.drum.hub_start_y, front)

    def acting(load: BodyLoad) -> list[Acting]:
        """Load on the hub, with the reactions of the bearings."""
        couple = load.moment_Nm * 1e3 - np.cross(at * _Y, load.force_N)
        across = couple - couple[1] * _Y
        pair = two_bearing_reactions_N(load.force_N, load.moment_Nm, 0.0, rear * 1e-3, front * 1e-3, (0.0, 1.0, 0.0))
        return [
            Acting(at, load.force_N, across),
            Acting(rear, pair[0], np.zeros(3)),
            Acting(front, pair[1], np.zeros(3)),
        ]

    changed = acting(body_load(layout.loads.si.routes, name, unit))
    rest = acting(idle_load_N(layout, name))
    modulus = elastic(drive.drum.shaft_material).modulus_MPa
    section = Section(rear, at, shaft.radius, shaft.bore_radius)
    yield Cause("drum's shaft", bending_urad_Nm(_Y, changed, [section], modulus))
    spring = layout.preload_spring.force_N
    give = sum(_bearing_urad_Nm(spec, a.force_N, b.force_N, spring) for a, b in zip(changed[1:], rest[1:], strict=True))
    yield Cause("drum's bearings", give)


def input_torques_Nm(layout: SectorLayout, unit: Floats) -> Floats:
    """Torque (n_inputs,) on each input for 1 N m on the drum."""
    d = layout.loads.si
    pull = d.sigma * unit * d.input_radius_m
    return np.array([pull[[j for j, k in enumerate(d.input_of) if k == i]].sum() for i in range(d.n_inputs)])


def _gearheads(layout: SectorLayout, unit: Floats) -> Iterator[Cause]:
    gear = layout.drive.gearhead
    if gear.absent:
        return
    stiffness = GEARHEAD_NM_RAD_40 * (gear.diameter_mm / 40.0) ** 3
    give = float((input_torques_Nm(layout, unit) ** 2).sum() / stiffness)
    yield Cause("gearheads (estimate)", give * 1e6, before_input=True)


def _inputs(layout: SectorLayout, unit: Floats) -> Iterator[Cause]:
    """Torsion of the input pulleys from the coupling to their cables, their bending, and their bearings."""
    d, drive, sense = layout.loads.si, layout.drive, layout.levels_sense
    lower_bearing, upper_bearing = drive.bearings.input_lower, drive.bearings.input_upper
    material = elastic(drive.input_pulleys.material)
    twist = bend = give = 0.0
    for i, (pulley, torque) in enumerate(zip(layout.inputs, input_torques_Nm(layout, unit), strict=True)):
        levels, route = layout.levels_of(i), d.routes.inputs[i]
        axis = sense * np.array(route.axis)
        lower = levels.bearing_shelf_top_z - lower_bearing.width_mm / 2.0
        upper = levels.top_plate_bottom_z + upper_bearing.width_mm / 2.0
        start, middle = layout.collar.top_z, (pulley.land_bottom_z + pulley.land_top_z) / 2.0
        # Each length of the pulley with its radius, the grooves counted as cut away all round.
        lengths = (
            (pulley.journal_bottom_z, pulley.lower_neck_bottom_z, pulley.lower_journal_radius),
            (pulley.lower_neck_bottom_z, pulley.land_bottom_z, pulley.lower_neck_radius),
            (pulley.land_bottom_z, pulley.wall_z, pulley.lower_surface_radius),
            (pulley.wall_z, pulley.land_top_z, pulley.upper_surface_radius),
            (pulley.land_top_z, pulley.upper_neck_top_z, pulley.upper_neck_radius),
            (pulley.upper_neck_top_z, pulley.journal_top_z, pulley.upper_journal_radius),
        )
        sections = [s for length in lengths for s in _bored(Section(*length), pulley.bore_radius, pulley.bore_top_z)]
        twisted = [Section(max(s.start_mm, start), min(s.end_mm, middle), s.radius_mm, s.bore_mm) for s in sections]
        twist += torsion_urad_Nm(float(torque) * 1e3, [s for s in twisted if s.end_mm > s.start_mm], material.shear_MPa)
        loads = []
        for j in range(d.n_cables):
            if d.input_of[j] == i:
                one = body_load(d.routes, route.name, np.where(np.arange(d.n_cables) == j, unit, 0.0))
                across = one.moment_Nm * 1e3
                loads.append(Acting(one.height_m * 1e3 * sense, one.force_N, across - (across @ axis) * axis))
        pair = _reactions_N(loads, lower, upper, axis)
        held = [Acting(lower, pair[0], np.zeros(3)), Acting(upper, pair[1], np.zeros(3))]
        bend += bending_urad_Nm(axis, [*loads, *held], sections, material.modulus_MPa)
        rest = idle_load_N(layout, route.name)
        idle = _reactions_N(
            [Acting(rest.height_m * 1e3 * sense, rest.force_N, rest.moment_Nm * 1e3)], lower, upper, axis
        )
        give += _bearing_urad_Nm(lower_bearing, pair[0], idle[0])
        give += _bearing_urad_Nm(upper_bearing, pair[1], idle[1])
    yield Cause("input pulleys, torsion", twist, before_input=True)
    yield Cause("input pulleys, bending", bend)
    yield Cause("input pulleys' bearings", give)


def _bored(section: Section, bore_mm: float, to_mm: float) -> Iterator[Section]:
    """A section with the bore that it has up to a height."""
    cut = min(max(to_mm, section.start_mm), section.end_mm)
    if cut > section.start_mm:
        yield Section(section.start_mm, cut, section.radius_mm, bore_mm)
    if section.end_mm > cut:
        yield Section(cut, section.end_mm, section.radius_mm)


def _reactions_N(loads: list[Acting], lower_mm: float, upper_mm: float, axis: Floats) -> Floats:
    """Reactions (2, 3) of two bearings to all the loads."""
    along = (float(axis[0]), float(axis[1]), float(axis[2]))
    return np.asarray(
        sum(two_bearing_reactions_N(a.force_N, a.couple_Nmm, a.at_mm, lower_mm, upper_mm, along) for a in loads)
    )


def axle_causes(
    layout: SectorLayout,
    body: str,
    unit: Floats,
    supports_mm: tuple[float, float],
    bearings: tuple[Bearing, tuple[float, float]],
    axle: Section,
    modulus_MPa: float,
) -> Iterator[Cause]:
    """Bending of a fixed axle between its supports and give of the two bearings on it, for a body that cables pass.

    ``bearings``: their entry, and the middles of both along the axis.
    """
    spec, (low, high) = bearings
    routes = layout.loads.si.routes
    axis = np.array(routes.body(body).axis)

    def on_axle(load: BodyLoad) -> list[Acting]:
        whole = Acting(load.height_m * 1e3, load.force_N, load.moment_Nm * 1e3)
        pair = -_reactions_N([whole], low, high, axis)
        return [Acting(low, pair[0], np.zeros(3)), Acting(high, pair[1], np.zeros(3))]

    changed, rest = on_axle(body_load(routes, body, unit)), on_axle(idle_load_N(layout, body))
    held = _reactions_N(changed, *supports_mm, axis)
    ends = [Acting(at, force, np.zeros(3)) for at, force in zip(supports_mm, held, strict=True)]
    yield Cause(f"{body}'s axle", bending_urad_Nm(axis, [*changed, *ends], [axle], modulus_MPa))
    give = sum(_bearing_urad_Nm(spec, a.force_N, b.force_N) for a, b in zip(changed, rest, strict=True))
    yield Cause(f"{body}'s bearings", give)
