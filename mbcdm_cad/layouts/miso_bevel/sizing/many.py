"""Many designs of miso_bevel sized at once, as far as no frame is needed, and their cables for the model."""

from __future__ import annotations

from collections.abc import Iterator, Mapping, Sequence
from dataclasses import replace
from typing import Any

from mbcdm_cad.design.blocks import Loads
from mbcdm_cad.design.bought import CableSpec, Motor
from mbcdm_cad.design.drive import Drive
from mbcdm_cad.layouts.miso_bevel.drive import BevelDrive, bevel
from mbcdm_cad.layouts.miso_bevel.sizing import BEFORE_FRAME
from mbcdm_cad.layouts.miso_bevel.sizing.known import BevelKnown
from mbcdm_cad.sizing.bulk import Alike, fill_many

FIELDS = tuple(rule.field for rule in BEFORE_FRAME)


def size_many(data: dict[str, Any], columns: Mapping[str, Sequence[Any]]) -> Iterator[Alike]:
    """The designs of ``data`` with the fields of ``columns`` changed row by row, in groups with the same choices."""
    return fill_many(data, columns, BEFORE_FRAME, BevelKnown)


def drive_of_many(alike: Alike, like: Drive) -> BevelDrive:
    """A drive that represents a group: the values that the cable model reads are columns, one number for each design.

    All other values are those of ``like``, a drive of the same file: frame, drum and setback of the inputs.
    """
    known, like = alike.known, bevel(like)
    assert isinstance(known, BevelKnown)
    drum, guide, pulley = known.drum_mm, known.guide_mm, known.input_mm
    own = {item["name"]: item.get("preload_N") for item in known["cables"]}
    rope = {
        "name": "rope",
        **known.rope,
        "modulus_GPa": known.modulus_GPa,
        "modulus_area": known.get("rope.modulus_area", known.rope["modulus_area"]),
    }
    return replace(
        like,
        cables=tuple(
            replace(
                run,
                drum_radius_mm=drum[run.step - 1],
                guide_radius_mm=guide[run.step - 1],
                input_radius_mm=pulley[run.step - 1],
                preload_N=known["rope.preload_N"] if own.get(run.name) is None else own[run.name],
            )
            for run in like.cables
        ),
        centre_distance_mm=known["transmission.centre_distance_mm"],
        half_travel_deg=known["travel.half_angle_deg"],
        friction_coefficient=known["rope.friction_coefficient"],
        helix_lead_mm=known["rope.helix_lead_mm"],
        cable=CableSpec(**rope),
        motor=Motor(name=known["drive.motor"], **known.entry("motors", "drive.motor")),
        gearhead=known.gearhead,
        loads=Loads(test_torque_Nm=known["loads.test_torque_Nm"], peak_torque_Nm=known["loads.peak_torque_Nm"]),
        limits=replace(like.limits, tension_safety_factor=known["limits.tension_safety_factor"]),
    )
