"""A drive behind its inputs as a linear chain: what a frequency response of output over inputs shows of it.

Output over inputs does not depend on motors, gearheads and position loops, as far as the inputs' encoders see them: its
poles are the modes with the inputs held. Behind them the cables, whose wraps slip the more the higher the torque, and
the parts turn drum and payload. The cables' law is linearised at the torque that each frequency carries. A slip that
goes with the square of the torque (Masing) has the part 1 - 4i/(3 pi) of its compliance in the first harmonic, so that
softening and hysteresis are one figure.
"""

from collections.abc import Mapping
from dataclasses import dataclass, replace

import numpy as np

from mbcdm_cad.design.drive import Drive
from mbcdm_cad.layouts.base import NoFigureError
from mbcdm_cad.layouts.lumped import compliance_of
from mbcdm_cad.layouts.registry import layout_of
from mbcdm_cad.layouts.structure import structure_of
from mbcdm_cad.layouts.turns import modes_of
from mbcdm_cad.measurement.response import FrequencyResponse
from mbcdm_cad.measurement.run import Run
from mbcdm_cad.model.si import ModelError
from mbcdm_cad.model.stiffness import drum_backlash
from mbcdm_cad.model.structure.causes import sigma_urad_Nm
from mbcdm_cad.routes import Complex, Floats

# Part of the slip's compliance out of phase with the torque.
HYSTERESIS = 4.0 / (3.0 * np.pi)
# Amplitudes at which the cables' law is computed; the least and the most of them, of the largest torque of the run.
AMPLITUDES, LEAST_AMPLITUDE, MOST_AMPLITUDE = 32, 1e-3, 2.5

# Figures of suspects and of what is always free, by name; one that is left out is zero.
Values = Mapping[str, float]


@dataclass(frozen=True, eq=False)
class BehindInputs:
    """A drive behind its inputs: compliances in rad/(N m) and inertias in kg m2 at the output.

    ``cables_rad_Nm`` over the amplitude of the torque ``torque_Nm``; ``before_drum`` and ``behind_drum`` of the parts,
    ``seen`` what the encoder sees of the latter; ``sigma_rad_Nm`` of the parts together.
    """

    torque_Nm: Floats
    cables_rad_Nm: Floats
    before_drum: float = 0.0
    behind_drum: float = 0.0
    seen: float = 0.0
    sigma_rad_Nm: float = 0.0
    drum_kg_m2: float = 0.0
    payload_kg_m2: float = 1.0

    def at(self, amplitude_Nm: float) -> "BehindInputs":
        """The same with the cables linear as they are at this amplitude, without their hysteresis."""
        cables = float(np.interp(amplitude_Nm, self.torque_Nm, self.cables_rad_Nm))
        return replace(self, torque_Nm=np.zeros(1), cables_rad_Nm=np.full(1, cables))


# Of a drive of which only the ratio is known: rigid, with a payload of 1.
RIGID_DRIVE = BehindInputs(np.zeros(1), np.zeros(1))


def behind_inputs(drive: Drive, run: Run, most_rad_s2: float) -> BehindInputs:
    """The design behind the inputs of a run whose output accelerates by ``most_rad_s2`` at most."""
    d, layout = layout_of(drive).si, layout_of(drive)
    try:
        bodies, routes = layout.inertias_kg_m2, layout.routed.routes
    except NoFigureError as error:
        raise ModelError(f"no inertia of {layout.name}: {error}") from None
    drum = bodies[routes.drum.name] + sum(bodies[b.name] * b.turns_per_drum**2 for b in routes.passed)
    payload = drive.loads.carried.about_axis_kg_m2 + run.plate.inertia_kg_m2
    torque = np.geomspace(LEAST_AMPLITUDE, MOST_AMPLITUDE, AMPLITUDES) * most_rad_s2 * (drum + payload)
    cables = drum_backlash(d, torque).reversal_swing_rad / (2.0 * torque)
    held = BehindInputs(torque, cables, drum_kg_m2=drum, payload_kg_m2=payload)
    if run.counted is None or not run.counted.structure:
        return held
    try:
        structure = structure_of(layout)
    except NoFigureError:
        return held
    if structure is None:
        return held
    chain, give = structure.chain, compliance_of(drive)
    motors = structure.motor_encoders or any(run.motor_side) or run.counted.inputs_at == "motors"
    before = chain.before_drum + (chain.before_inputs if motors else 0.0)
    inside = give.land_to_encoder - chain.before_drum - (chain.before_inputs if structure.motor_encoders else 0.0)
    seen = chain.in_drum if run.counted.output_at == "payload" else float(np.clip(inside, 0.0, chain.in_drum))
    sigma = 1e-6 * sigma_urad_Nm(structure.at_payload)
    return replace(held, before_drum=before, behind_drum=chain.in_drum, seen=seen, sigma_rad_Nm=sigma)


def predicted(held: BehindInputs, v: Values, seen: FrequencyResponse) -> tuple[Complex, Complex]:
    """Output over inputs, or over a torque on it, and twist over torque in rad/(N m); ``v``: figures of suspects and
    nuisances."""

    def of(name: str) -> float:
        return v.get(name, 0.0)

    s: Complex = np.asarray(2j * np.pi * seen.frequency_Hz, dtype=complex)
    payload, drum = held.payload_kg_m2 * (1.0 + of("inertia")), held.drum_kg_m2
    torque = carried_Nm(seen, payload + drum)
    before, behind, inside = _gives(held, v, torque, np.asarray(s.imag, dtype=float))
    arm, front, share = _swing(v, "arm", s), _swing(v, "front", s), 1.0 - of("front_share")
    swung = payload * (1.0 - of("arm_share") * arm / (1.0 + arm))
    hub = 1.0 / (1.0 + behind * swung * s**2)
    turned = before * (drum + swung * hub) * s**2
    land = 1.0 / (1.0 + turned + front * (1.0 / share + turned))
    read = land * (1.0 - inside * swung * hub * s**2)
    sensor = np.exp(-s * of("load_lag")) * (1.0 + of("load_gain"))
    if seen.over_torque:
        # What the drum gives for a torque from behind it; the payload's own inertia carries the rest of it.
        before = before * (share + (1.0 - share) / (1.0 + front / share))
        drum_gives = before / (1.0 + before * drum * s**2)
        read = (drum_gives + inside) / (1.0 + (drum_gives + behind) * swung * s**2) / sensor
    read = read * (1.0 + of("gain") + of("scale")) * np.exp(-s * of("delay")) / (1.0 + s * of("lag"))
    return read, (1.0 - read) / (swung * s**2 * hub * land * sensor)


def _swing(v: Values, what: str, s: Complex) -> Complex:
    """Torque of a mass over that of the spring that holds it, at its frequency ``what``_Hz; 0 where there is none.

    Of an arm ``arm_share`` is its part of the payload. The frame that carries the drive gives the same form: its
    inertia swings against all that the output turns. Of a mass in front of the drum ``front_share`` is the part of the
    compliance in front of it.
    """
    rate = 2.0 * np.pi * v.get(f"{what}_Hz", 0.0)
    return np.asarray(s**2 / (rate**2 + 2.0 * v[f"{what}_damping"] * rate * s) if rate else 0.0 * s)


def own_modes_Hz(held: BehindInputs, drive: Drive) -> list[float]:
    """Modes that the design has besides the first: payload against drum, and those with the rotors free."""
    payload, behind = held.payload_kg_m2, held.behind_drum
    before = float(held.cables_rad_Nm[0]) + held.before_drum
    roots = np.roots(
        [behind * payload * before * held.drum_kg_m2, -(behind * payload + before * (held.drum_kg_m2 + payload)), 1.0]
    )
    found = [float(np.sqrt(max(abs(roots)))) / (2.0 * np.pi)] if roots.size > 1 else []
    return sorted([*found, *modes_of(layout_of(drive)).inputs_free_Hz])


def carried_Nm(seen: FrequencyResponse, inertia_kg_m2: float) -> Floats:
    """Amplitude of the torque in the cables at each frequency, (n,), behind which the output turns this inertia."""
    if not (seen.over_torque and seen.levelled):
        return inertia_kg_m2 * seen.acceleration_rad_s2
    turned = 1.0 + inertia_kg_m2 * (2.0 * np.pi * seen.frequency_Hz) ** 2 * seen.output.value
    return np.asarray(seen.input_rad * np.abs(turned))


def _gives(held: BehindInputs, v: Values, torque_Nm: Floats, rate_rad_s: Floats) -> tuple[Complex, Complex, Complex]:
    """Complex compliance up to the drum, behind it, and of the latter in front of the encoder.

    Of the loss factor one part hangs on no frequency, one is in proportion to it.
    """

    def of(name: str) -> float:
        return v.get(name, 0.0)

    lossy, sticking = 1.0 / (1.0 + 1j * (of("loss") + of("viscous_s") * rate_rad_s)), held.cables_rad_Nm[0]
    slip = np.interp(torque_Nm / (1.0 + of("preload")), held.torque_Nm, held.cables_rad_Nm) - sticking
    slip = slip * (1.0 + of("slip")) + of("softening") * torque_Nm
    cables = sticking * lossy + slip * (1.0 - 1j * HYSTERESIS)
    before = cables / (1.0 + of("modulus")) + (held.before_drum + of("series") + of("structure") + of("mode")) * lossy
    before = before * (1.0 + of("law"))
    behind = (held.behind_drum + of("behind")) * lossy
    return before, np.asarray(behind), np.asarray(held.seen * lossy)


def first_mode(held: BehindInputs, v: Values, torque_Nm: float) -> tuple[float, float]:
    """Frequency in Hz and damping ratio of the lowest mode with the inputs held, at an amplitude of the torque."""
    payload, drum = held.payload_kg_m2 * (1.0 + v.get("inertia", 0.0)), held.drum_kg_m2
    rate = 0.0
    for _ in range(3):  # what is viscous hangs on the frequency
        gives = _gives(held, v, np.array([torque_Nm]), np.array([rate]))
        before, behind, _ = (complex(one[0]) for one in gives)
        # (1 - behind payload x) (1 - before drum x) = before payload x, x the square of the angular frequency
        roots = np.roots([behind * payload * before * drum, -(behind * payload + before * (drum + payload)), 1.0])
        square = min(roots, key=abs) if roots.size else 1e18 + 0j
        rate = float(np.sqrt(max(square.real, 1e-9)))
    return rate / (2.0 * np.pi), float(0.5 * square.imag / rate**2)
