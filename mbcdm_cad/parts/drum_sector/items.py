"""The drum with all parts that turn with it, and the cables, as items of a bill."""

from collections.abc import Callable, Iterable
from dataclasses import replace
from math import atan2, cos, degrees, pi, radians, sin
from typing import Any

from mbcdm_cad.design.bought import Screw
from mbcdm_cad.parts.bill import AGAINST_Y, ALONG_Y, BillBuilder, Placement, cable_item, entry_stem
from mbcdm_cad.parts.bodies import CableRod, RingEncoderBody, WaveSpring
from mbcdm_cad.parts.drum_sector.design import SectorDrive
from mbcdm_cad.parts.drum_sector.dims import SET_SCREW_ANGLES_DEG, DrumDims
from mbcdm_cad.parts.drum_sector.part import DrumSector
from mbcdm_cad.parts.fits import thread
from mbcdm_cad.parts.terminal import SeatWasher, Tensioner, TerminalDims, TerminalSpring, ThreadedTerminal
from mbcdm_cad.parts.turned import DrumShaft, DrumShaftDims, Nut, PreloadSpringDims
from mbcdm_cad.routes.curves import CablePath

_Y, _Z = (0.0, 1.0, 0.0), (0.0, 0.0, 1.0)
_AS_DRAWN = Placement.identity()
RING_ENCODER_GRIP_MM = 2.0
# A wave spring is a strip about a third as thick as it stands high (estimate, for its mass).
SPRING_SHARE = 1.0 / 3.0
# Colours (linear RGB) that distinguish bought bodies and cables from machined metal.
ENCODER_COLOUR = (0.01, 0.12, 0.06)
# One colour for each cable, so that it can be followed; most colour-blind people can distinguish them too.
_CABLE_COLOURS = ((0.85, 0.3, 0.02), (0.05, 0.25, 0.8), (0.02, 0.45, 0.25), (0.6, 0.08, 0.4))


def add_drum(b: BillBuilder, drive: SectorDrive, d: DrumDims, shaft: DrumShaftDims) -> None:
    """Drum sector with its terminals and nuts, its shaft, and the set screws that hold it there."""
    set_screw = drive.screw(d.set_screw)
    b.add(
        "drum",
        DrumSector(d, set_screw.thread_mm),
        material=drive.drum_material,
        group="drum",
        drilled=drilled_drum(d, set_screw),
    )
    add_output(b, drive, d, shaft)
    add_terminals(b, drive, d)


def drilled_drum(d: DrumDims, set_screw: Screw) -> DrumSector:
    """The sector with its tapped holes at their tap drills."""
    tapped = replace(d, payload_screw_thread=thread(d.payload_screw_thread).tap_drill_mm)
    return DrumSector(tapped, set_screw.tap_drill_mm)


def add_output(
    b: BillBuilder, drive: SectorDrive, d: DrumDims, shaft: DrumShaftDims, stand: Placement = _AS_DRAWN
) -> None:
    """Inserts of the hub's face, the shaft, and the set screws that hold the hub on it.

    ``stand``: where the sector with this hub stands in the drum's frame.
    """
    set_screw = drive.screw(d.set_screw)
    if d.payload_insert is not None:
        for n, (x, z) in enumerate(d.payload_places, 1):
            place = stand @ Placement.translation(x, d.hub_face_y, z) @ ALONG_Y
            b.insert(f"payload_insert_{n}", d.payload_insert, drive.material("brass"), place, "drum")
    b.add("drum_shaft", DrumShaft(shaft), material=drive.shaft_material, group="drum")
    for n, deg in enumerate(SET_SCREW_ANGLES_DEG, 1):
        out = d.set_screw_radius + set_screw.length_mm
        place = Placement.translation(
            out * sin(radians(deg)), d.set_screw_y, out * cos(radians(deg))
        ) @ Placement.about(_Y, deg)
        b.screw(f"hub_set_screw_{n}", set_screw, drive.material("steel"), stand @ place, "drum")


def add_terminals(b: BillBuilder, drive: SectorDrive, d: DrumDims, stand: Placement = _AS_DRAWN) -> None:
    """Terminals with their nuts, in the lugs of a sector that stands at ``stand`` in the drum's frame."""
    t = drive.tensioner
    steel = drive.material(t.material)
    for p in d.tensioners:
        turn = Placement.about(_Y, degrees(atan2(p.side * cos(p.anchor_rad), -sin(p.anchor_rad))))

        def along(s: float, p: Any = p, turn: Placement = turn) -> Placement:
            x, z = p.at(s)
            return stand @ Placement.translation(x, p.y_mm, z) @ turn

        # The part is drawn slack and moved by the take-up of its cable, so that all cables share one part.
        slack = TerminalDims(
            swage_start=round(p.slack_start, 9),
            cable_end=round(p.cable_end - p.drawn_in, 9),
            swage_end=round(p.swage_end - p.drawn_in, 9),
            tip=round(p.tip - p.drawn_in, 9),
            swage_radius=t.swage_diameter_mm / 2,
            flat=t.swage_flats_mm / 2,
            stud_radius=t.thread_mm / 2,
            bore_radius=drive.cable.diameter_mm / 2,
        )
        b.add(
            f"terminal_{p.cable_name}",
            ThreadedTerminal(slack, drive.termination.name),
            part="terminal",
            material=steel,
            group="drum",
            # A flat of the sleeve towards the drum's axis, along the wall of its pocket.
            place=along(p.drawn_in) @ Placement.about(_Z, 90.0),
        )
        add_springs(b, drive, p, along)
        for n in range(2):
            b.standard(
                f"nut_{p.cable_name}_{n + 1}",
                Nut(t.nut_across_flats_mm, t.nut_height_mm, t.thread_mm),
                part="nut",
                material=steel,
                group="drum",
                place=along(p.lug_end + p.spring + n * t.nut_height_mm),
            )


def add_springs(b: BillBuilder, drive: SectorDrive, t: Tensioner, along: Callable[[float], Placement]) -> None:
    """The springs on a terminal's stud, compressed by its preload; discs are turned against each other."""
    if drive.spring is None:
        return
    spring, seat = drive.spring, drive.spring_seat_mm
    for n, start in enumerate((0.0, t.spring - seat), 1):
        b.standard(
            f"spring_washer_{t.cable_name}_{n}",
            SeatWasher(drive.tensioner.clearance_mm, spring.outside_mm, seat),
            part="spring_washer",
            material=drive.material("steel"),
            group="drum",
            place=along(t.lug_end + start),
        )
    height = (t.spring - 2 * seat) / drive.drum.spring_count
    body = TerminalSpring(spring, round(height, 9))
    for n in range(drive.drum.spring_count):
        turned = spring.kind == "disc" and n % 2 == 1
        at = along(t.lug_end + seat + (n + turned) * height)
        b.add(
            f"spring_{t.cable_name}_{n + 1}",
            body,
            part=f"{entry_stem('spring', spring.name)}_{t.cable_name}",
            material=drive.material(spring.material),
            group="drum",
            place=at @ Placement.about((1.0, 0.0, 0.0), 180.0) if turned else at,
            mass_g=spring.mass_g,
        )


def add_preload_spring(b: BillBuilder, drive: SectorDrive, spring: PreloadSpringDims) -> None:
    """Wave spring in the boss, under the rear bearing's outer ring."""
    steel = drive.material("steel")
    volume = pi * (spring.outer_radius**2 - spring.inner_radius**2) * spring.height
    b.add(
        "drum_preload_spring",
        WaveSpring(spring),
        part="wave_spring",
        material=steel,
        place=Placement.translation(0.0, spring.start_y, 0.0) @ ALONG_Y,
        mass_g=SPRING_SHARE * volume * steel.density_g_cm3 / 1e3,
    )


def add_drum_encoder(b: BillBuilder, drive: SectorDrive, floor_y: float, screw_circle: float) -> None:
    """Ring encoder on the shaft, behind the floor of its pocket, with its two screws at +-``screw_circle``; or none."""
    ring = drive.drum_encoder
    if ring.absent:
        return
    screw = drive.screw(ring.screw)
    b.add(
        "drum_encoder",
        RingEncoderBody(ring, screw, RING_ENCODER_GRIP_MM),
        material=replace(drive.material("stainless"), colour=ENCODER_COLOUR),
        place=Placement.translation(0.0, floor_y, 0.0) @ AGAINST_Y,
        mass_g=ring.mass_g,
    )
    for n, sign in enumerate((-1, 1), 1):
        place = Placement.translation(sign * screw_circle, floor_y - RING_ENCODER_GRIP_MM, 0.0) @ AGAINST_Y
        b.screw(f"drum_encoder_screw_{n}", screw, drive.material("steel"), place)


def add_cables(b: BillBuilder, drive: SectorDrive, paths: Iterable[CablePath]) -> None:
    """All cables, as rods along their centre lines."""
    wire = drive.material(drive.cable.material)
    for k, path in enumerate(paths):
        b.add(
            cable_item(path.cable.name),
            CableRod(path.line, drive.cable.diameter_mm / 2),
            material=replace(wire, colour=_CABLE_COLOURS[k % len(_CABLE_COLOURS)]),
            mass_g=drive.cable.mass_g_m * path.length_mm / 1e3,
        )
