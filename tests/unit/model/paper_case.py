"""The paper's drive (Tables 1 and 2) directly in SI, so that these tests need no design file."""

from dataclasses import replace
from typing import Any

import numpy as np

from mbcdm_cad.layouts.miso_bevel.cable_path import BevelGeometry
from mbcdm_cad.model.si import DriveSI

GEOMETRY = BevelGeometry(
    cable_names=("cable_1", "cable_2", "cable_3", "cable_4"),
    input_names=("left", "right"),
    input_of=(0, 0, 1, 1),
    input_side=(-1, 1),
    drum_side=(1, -1, -1, 1),
)


def paper_drive(**changes: Any) -> DriveSI:
    """MBCDM with T_pre = 70 N, mu = 0.15, E = 60 GPa on 0.3117 mm^2; ``changes`` replace fields or lengths."""
    drive = DriveSI(
        geometry=GEOMETRY,
        parameters={
            "input_radius_m": np.array([6.0, 6.4, 6.8, 7.2]) * 1e-3,
            "guide_radius_m": np.array([9.0, 9.6, 10.2, 10.8]) * 1e-3,
            "drum_radius_m": np.array([54.0, 57.6, 61.2, 64.8]) * 1e-3,
            "centre_distance_m": np.asarray(34.6e-3),
        },
        preload_N=np.full(4, 70.0),
        friction_coefficient=np.asarray(0.15),
        modulus_Pa=np.asarray(60e9),
        area_m2=np.asarray(0.3117e-6),
        input_wrap_rad=np.full(4, np.inf),
        drum_wrap_rad=np.full(4, np.inf),
        passed_wrap_rad=(np.zeros(4),),
        anchor_m_N=np.zeros(4),
    )
    return drive.with_(**changes) if changes else drive


def turned_round(d: DriveSI) -> DriveSI:
    """The same drive with the sense of every cable turned round."""
    geometry = d.geometry
    assert isinstance(geometry, BevelGeometry)
    return replace(d, geometry=replace(geometry, drum_side=tuple(-side for side in geometry.drum_side)))


def some_cables(d: DriveSI, which: list[int]) -> DriveSI:
    """A drive with only these cables of ``d``, in this order, and only the inputs that they run from."""
    geometry = d.geometry
    assert isinstance(geometry, BevelGeometry)
    inputs = list(dict.fromkeys(geometry.input_of[j] for j in which))
    fewer = BevelGeometry(
        tuple(geometry.cable_names[j] for j in which),
        tuple(geometry.input_names[i] for i in inputs),
        tuple(inputs.index(geometry.input_of[j]) for j in which),
        tuple(geometry.input_side[i] for i in inputs),
        tuple(geometry.drum_side[j] for j in which),
    )
    return replace(d.mapped(lambda v: v[which], lambda v: v), geometry=fewer)
