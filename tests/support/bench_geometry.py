"""Pulleys, spans and levers of a drive, from the design file alone (millimetres become metres here).

Seen from +z with the guide's axis at the origin; the inputs stand at (side * L, 0). A cable that leaves the guide
towards ``drum_side`` turns the drum about +y with sense ``-drum_side``, and its free span is the internal tangent.
"""

from dataclasses import dataclass

import numpy as np

from mbcdm_cad.design.drive import Drive


@dataclass(frozen=True)
class Chain:
    """One row a cable: radii (m), preload (N), span (m), unit vectors; scalars: friction, EA (N)."""

    sense: np.ndarray
    input_of: np.ndarray
    r_in: np.ndarray
    r_guide: np.ndarray
    r_drum: np.ndarray
    preload: np.ndarray
    span: np.ndarray
    to_input: np.ndarray  # unit vector in the x-y plane, from the guide's tangent point to the input's
    to_drum: np.ndarray  # +-1 along x, from the guide to where the cable lies on the drum
    friction: float
    stiffness: float  # E A in N


def chain_of(drive: Drive) -> Chain:
    """The chain of a design."""
    sense, input_of, spans, units = [], [], [], []
    for run in drive.cables:
        index = drive.input_names.index(run.input_name)
        centre = np.array([run.input_side * drive.centre_distance_mm * 1e-3, 0.0])
        r_g, r_i = run.guide_radius_mm * 1e-3, run.input_radius_mm * 1e-3
        # The cable ends at the top (+y) of the guide and goes off along x: going round clockwise it leaves towards +x.
        clockwise = run.drum_side > 0
        guide_point, input_point = _internal_tangent(centre, r_g, r_i, clockwise)
        reach = input_point - guide_point
        spans.append(float(np.hypot(*reach)))
        units.append(reach / spans[-1])
        sense.append(-float(run.drum_side))
        input_of.append(index)
    metre = 1e-3
    return Chain(
        sense=np.array(sense),
        input_of=np.array(input_of, dtype=np.int64),
        r_in=np.array([run.input_radius_mm for run in drive.cables]) * metre,
        r_guide=np.array([run.guide_radius_mm for run in drive.cables]) * metre,
        r_drum=np.array([run.drum_radius_mm for run in drive.cables]) * metre,
        preload=np.array([run.preload_N for run in drive.cables]),
        span=np.array(spans),
        to_input=np.array(units),
        to_drum=np.array([float(run.drum_side) for run in drive.cables]),
        friction=drive.friction_coefficient,
        stiffness=drive.cable.modulus_GPa * 1e9 * drive.cable.area_mm2 * 1e-6,
    )


def _internal_tangent(centre: np.ndarray, r_g: float, r_i: float, clockwise: bool) -> tuple[np.ndarray, np.ndarray]:
    """Tangent points on guide and input pulley of a crossed belt on whose guide the cable goes round ``clockwise``.

    The cable comes in from the input at the guide's tangent point and moves on round the guide to its top.
    """
    distance = float(np.hypot(*centre))
    bearing = np.arctan2(centre[1], centre[0])
    half = np.arccos((r_g + r_i) / distance)
    for side in (1.0, -1.0):
        normal = np.array([np.cos(bearing + side * half), np.sin(bearing + side * half)])
        on_guide, on_input = r_g * normal, centre - r_i * normal
        towards_guide = on_guide - on_input
        turns_clockwise = (normal[0] * towards_guide[1] - normal[1] * towards_guide[0]) < 0.0
        if turns_clockwise == clockwise:
            return on_guide, on_input
    raise ValueError("no crossed tangent: centre distance is too short")


def path_of_eccentric(chain: Chain, stage: str, e_m: float, phase_rad: float, shaft_angle: np.ndarray) -> np.ndarray:
    """Change of each cable's path (m), shape (cables, n), when the pulley's centre runs round its axis.

    The centre is off by ``e_m`` at the direction ``shaft_angle + phase``, measured from +x in the plane of rotation
    (for the drum: from +x towards the transfer point's outward direction). Zero where every shaft is at zero.
    """

    def offset(angle: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
        return e_m * np.cos(angle + phase_rad), e_m * np.sin(angle + phase_rad)

    def path(angle: np.ndarray) -> np.ndarray:
        x, y = offset(angle)
        rows = np.zeros((chain.sense.size, np.size(angle)))
        for j in range(chain.sense.size):
            if stage == "drum":
                rows[j] = chain.to_drum[j] * x
            elif stage == "guide":
                # Both spans that touch it: moving away from where a span leads makes that span longer.
                rows[j] = -(chain.to_input[j, 0] * x + chain.to_input[j, 1] * y) - chain.to_drum[j] * x
            elif stage == f"input_{chain.input_of[j]}":
                rows[j] = chain.to_input[j, 0] * x + chain.to_input[j, 1] * y
        return rows

    return path(np.asarray(shaft_angle)) - path(np.zeros(1))
