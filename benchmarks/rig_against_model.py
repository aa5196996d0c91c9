"""Compare the quasi-static rig with the analytic model: agreement, differences and convergence.

    python benchmarks/rig_against_model.py [--write docs/rig.md]

Prints tables in Markdown; ``--write`` writes them between the marks of that page. E = 60 GPa on the metallic area, as
for the figures of the model's page.
"""

import argparse
from dataclasses import dataclass, replace
from itertools import pairwise
from pathlib import Path
from typing import Any

import numpy as np

from mbcdm_cad.design.drive import Drive
from mbcdm_cad.layouts.loader import layout_of, load_design
from mbcdm_cad.model import capability, hysteresis, stiffness
from mbcdm_cad.rig import chain, quasistatic
from mbcdm_cad.rig.bench import cables_of
from mbcdm_cad.rig.motion import brake

ROOT = Path(__file__).resolve().parents[1]
TORQUE_NM = 0.91
BEGIN, END = "<!-- figures begin -->", "<!-- figures end -->"


def stiff_rope(drive: Drive) -> Drive:
    """The drive with E = 60 GPa on the metallic area."""
    return replace(drive, cable=replace(drive.cable, modulus_GPa=60.0, modulus_area="metallic"))


def rig_drum_rad(drive: Drive, inputs_rad: Any, load_Nm: Any, **options: Any) -> tuple[Any, Any]:
    """Drum angle (n,) and input torques (n_inputs, n) of the bare rig for these input angles and this load."""
    cables = cables_of(drive)
    inputs, load = np.ascontiguousarray(inputs_rad, dtype=float), np.ascontiguousarray(load_Nm, dtype=float)
    predicted = np.mean([inputs[c.input_index] * c.input_radius_m / c.drum_radius_m for c in cables], axis=0)
    state = chain.chains(cables, **{"transport": False, **options})
    n_cables, n = len(cables), load.size
    pulleys, drum, tension = np.empty_like(inputs), np.empty(n), np.empty((n_cables, n))
    gears = np.array([[np.inf, 0.0]] * inputs.shape[0])
    zero = np.zeros((n_cables, n))
    input_of = np.array([c.input_index for c in cables])
    course = quasistatic.QuasistaticCourse(
        input_of,
        gears,
        inputs,
        zero,
        zero,
        predicted,
        load,
        np.zeros((n_cables, 3, 0)),
        np.zeros((0, 2), dtype=np.int64),
        np.zeros(n_cables),
        np.zeros(n),
    )
    failed = quasistatic.run(state, course, pulleys, drum, tension)
    if failed >= 0:
        raise RuntimeError(f"no balance at sample {failed}")
    torque = np.zeros_like(inputs)
    for c, pull in zip(cables, tension, strict=True):
        torque[c.input_index] += c.sigma * c.input_radius_m * pull
    return drum, torque


def held(drive: Drive, load_Nm: Any, **options: Any) -> tuple[Any, Any]:
    """As :func:`rig_drum_rad` with the inputs held at zero."""
    return rig_drum_rad(drive, np.zeros((len(drive.input_names), np.size(load_Nm))), load_Nm, **options)


def to_and_fro(amplitude_rad: float, samples: int, sweeps: int) -> tuple[Any, Any]:
    """Input angles of a triangle of the drum at 9 turns, and the load of a brake on it; ``samples`` a quarter."""
    corners = [0.0] + [amplitude_rad * (-1.0) ** k for k in range(sweeps)]
    legs = [
        np.linspace(a, b, samples * (1 if k == 0 else 2), endpoint=False) for k, (a, b) in enumerate(pairwise(corners))
    ]
    drum = np.concatenate(legs)
    # The flank is the same share of a sweep at any fineness, and short.
    return np.stack([9.0 * drum] * 2), brake(drum, np.full(drum.size, TORQUE_NM), amplitude_rad / 50.0)


def extremes_urad(error_rad: Any) -> float:
    """Half of the spread over the last two sweeps, urad."""
    last = error_rad[-2 * (error_rad.size // 9) * 2 :]
    return float(np.ptp(last) / 2.0 * 1e6)


@dataclass(frozen=True)
class Row:
    """One figure: the model's, the rig's, and the largest difference allowed (None where they are to part)."""

    name: str
    unit: str
    model: float
    rig: float
    tolerance: float | None

    @property
    def difference(self) -> float:
        """Rig over model, less one."""
        return self.rig / self.model - 1.0


def agreement(drive: Drive, piece_rad: float = chain.PIECE_RAD) -> list[Row]:
    """Where the model's assumptions hold."""
    d = layout_of(drive).si
    ramp = np.linspace(0.0, TORQUE_NM, 200)
    turn = np.concatenate([ramp, np.linspace(TORQUE_NM, -TORQUE_NM, 400), np.linspace(-TORQUE_NM, TORQUE_NM, 400)])
    still = np.zeros((2, turn.size))
    model = hysteresis.simulate(d, still, turn).drum_angle_rad
    rig, _ = held(drive, turn, piece_rad=piece_rad)
    rows = [
        Row("turn at first loading to 0.91 N m", "urad", -model[199] * 1e6, -rig[199] * 1e6, 1e-3),
        Row("swing at the reversal", "urad", (model[599] - model[199]) * 1e6, (rig[599] - rig[199]) * 1e6, 1e-3),
    ]
    at = np.array([0.0, 1e-6, TORQUE_NM - 1e-3, TORQUE_NM + 1e-3])
    steps, _ = held(drive, np.concatenate([at[:2], np.linspace(0.01, at[2], 400), at[3:]]), piece_rad=piece_rad)
    rows += [
        Row(
            "stiffness while all sticks",
            "N m/rad",
            float(stiffness.sticking_stiffness_Nm_rad(d)),
            -1e-6 / (steps[1] - steps[0]),
            1e-3,
        ),
        Row(
            "stiffness at 0.91 N m, loading",
            "N m/rad",
            float(stiffness.tangent_stiffness_Nm_rad(d, TORQUE_NM)),
            -2e-3 / (steps[-1] - steps[-2]),
            1e-2,
        ),
    ]
    limit = drive.motor.rated_torque_mNm * 1e-3 * drive.gearhead.ratio
    for sign in (1, -1):
        load = sign * np.linspace(0.0, 5.0, 2001)
        _, torque = held(drive, load, piece_rad=piece_rad, drum_wrap_rad=6.0)
        first = int(np.argmax(np.abs(torque).max(axis=0) >= limit))
        peak = np.abs(torque).max(axis=0)
        reached = np.interp(limit, peak[first - 1 : first + 1], np.abs(load[first - 1 : first + 1]))
        modelled = np.abs(capability.torque_at_input_limit_Nm(d, limit, sign)).min()
        rows.append(
            Row(
                f"load at which an input reaches {limit:.4f} N m, {'+' if sign > 0 else '-'}",
                "N m",
                float(modelled),
                float(reached),
                1e-3,
            )
        )
    return rows


def winding(drive: Drive, piece_rad: float = chain.PIECE_RAD) -> list[Row]:
    """The rig's carried rope beside the model's own winding history, a different formula for the same physics.

    The third motion is a sine whose brake turns over within a sixth of the largest speed.
    """
    d, rows = layout_of(drive).si, []
    phase = np.linspace(0.0, 9.0 * np.pi, 9000)
    soft = TORQUE_NM * np.tanh(6.0 * np.cos(phase)) * np.minimum(phase, 1.0)
    motions = {
        "triangle +-50 mrad": to_and_fro(0.05, 500, 9),
        "triangle +-600 mrad": to_and_fro(0.6, 500, 9),
        "sine +-50 mrad, soft brake": (np.stack([9.0 * 0.05 * np.sin(phase)] * 2), soft),
    }
    for name, (inputs, load) in motions.items():
        modelled = hysteresis.simulate(d, inputs, load, winding=True).drum_angle_rad - inputs[0] / 9.0
        carried, _ = rig_drum_rad(drive, inputs, load, piece_rad=piece_rad, transport=True)
        rows.append(
            Row(
                f"extremes, {name}, both with rope carried along",
                "urad",
                extremes_urad(modelled),
                extremes_urad(carried - inputs[0] / 9.0),
                1e-3,
            )
        )
    return rows


def parting(drive: Drive, piece_rad: float = chain.PIECE_RAD, samples: int = 500) -> list[Row]:
    """Where the rig's physics goes beyond the model's: rope carried along, slip on the guide."""
    d = layout_of(drive).si
    rows = []
    for travel in (0.05, 0.6):
        inputs, load = to_and_fro(travel, samples, 9)
        declared = hysteresis.simulate(d, inputs, load).drum_angle_rad - inputs[0] / 9.0
        carried, _ = rig_drum_rad(drive, inputs, load, piece_rad=piece_rad, transport=True)
        rows.append(
            Row(
                f"extremes at +-{travel * 1e3:.0f} mrad, rope carried along",
                "urad",
                extremes_urad(declared),
                extremes_urad(carried - inputs[0] / 9.0),
                None,
            )
        )
    ramp = np.linspace(0.0, TORQUE_NM, 200)
    still = hysteresis.simulate(d, np.zeros((2, 200)), ramp).drum_angle_rad
    slipping, _ = held(drive, ramp, piece_rad=piece_rad, passed_slip=True)
    rows.append(Row("turn at first loading, slip on the guide", "urad", -still[-1] * 1e6, -slipping[-1] * 1e6, None))
    return rows


def convergence(drive: Drive) -> str:
    """Figures against piece length and time step, as two tables."""
    lines = [
        "| piece (mrad) | first loading (urad) | swing (urad) | extremes at +-50 mrad, carried (urad) |",
        "| --- | --- | --- | --- |",
    ]
    for piece in (0.08, 0.04, 0.02, 0.01, 0.005):
        fit, beyond = agreement(drive, piece), parting(drive, piece)
        lines.append(f"| {piece * 1e3:.0f} | {fit[0].rig:.4f} | {fit[1].rig:.4f} | {beyond[0].rig:.3f} |")
    lines += ["", "| samples a sweep | extremes at +-50 mrad, carried (urad) | at +-600 mrad |", "| --- | --- | --- |"]
    for samples in (50, 100, 250, 500, 1000, 2000):
        beyond = parting(drive, samples=samples)
        lines.append(f"| {2 * samples} | {beyond[0].rig:.3f} | {beyond[1].rig:.3f} |")
    return "\n".join(lines)


def table(rows: list[Row]) -> str:
    """The rows in Markdown."""
    lines = ["| figure | unit | model | rig | difference | tolerance |", "| --- | --- | --- | --- | --- | --- |"]
    for row in rows:
        limit = "none: they differ" if row.tolerance is None else f"{row.tolerance:.1%}"
        lines.append(f"| {row.name} | {row.unit} | {row.model:.5g} | {row.rig:.5g} | {row.difference:+.3%} | {limit} |")
    return "\n".join(lines)


def page(drive: Drive) -> str:
    """All tables."""
    return "\n\n".join(
        [
            "### Where the assumptions hold",
            table(agreement(drive) + winding(drive)),
            "### Where they differ on purpose",
            table(parting(drive)),
            "### Convergence",
            convergence(drive),
        ]
    )


def main() -> None:
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("--write", type=Path, help="page whose figures are to be replaced")
    arguments = parser.parse_args()
    text = page(stiff_rope(load_design(ROOT / "params" / "mbcdm.yaml").drive))
    print(text)
    if arguments.write:
        before, _, rest = arguments.write.read_text("utf-8").partition(BEGIN)
        arguments.write.write_text(f"{before}{BEGIN}\n{text}\n{END}{rest.partition(END)[2]}", "utf-8")


if __name__ == "__main__":
    main()
