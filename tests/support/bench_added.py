"""Effects that change the reading of the output encoder but not the cables: what each adds to the reading, in rad.

Each function takes its sizes, the true signals, the drum angle and a random stream. Sensor effects come first, then
physical causes that no name of the vocabulary covers.
"""

from collections.abc import Callable

import numpy as np
from scipy.interpolate import CubicSpline

from tests.support.bench_motion import Bench

Sizes = dict[str, float]
Added = Callable[[Sizes, Bench, np.ndarray, np.random.Generator], np.ndarray]


def output_scale(p: Sizes, bench: Bench, drum: np.ndarray, rng: np.random.Generator) -> np.ndarray:
    """The output encoder's scale is off."""
    return p["share"] * drum


def output_encoder(p: Sizes, bench: Bench, drum: np.ndarray, rng: np.random.Generator) -> np.ndarray:
    """The output encoder's disc is off centre."""
    return p["amplitude_rad"] * (np.cos(drum + p["phase_rad"]) - np.cos(p["phase_rad"]))


def division(p: Sizes, bench: Bench, drum: np.ndarray, rng: np.random.Generator) -> np.ndarray:
    """A periodic error of the output encoder or of a gear."""
    return p["amplitude_rad"] * np.cos(p["cycles_per_output_rev"] * drum + p["phase_rad"])


def shaft_compliance(p: Sizes, bench: Bench, drum: np.ndarray, rng: np.random.Generator) -> np.ndarray:
    """A soft shaft between drum and load."""
    return -p["compliance_rad_Nm"] * bench.load_Nm


def latency(p: Sizes, bench: Bench, drum: np.ndarray, rng: np.random.Generator) -> np.ndarray:
    """The output is read late."""
    return CubicSpline(bench.time_s, drum)(bench.time_s - p["delay_s"]) - drum


def output_play(p: Sizes, bench: Bench, drum: np.ndarray, rng: np.random.Generator) -> np.ndarray:
    """Play in the coupling to the load, behind which the output is read: the load presses one face or the other."""
    return -0.5 * p["play_rad"] * np.tanh(bench.load_Nm / 0.01)


def warming(p: Sizes, bench: Bench, drum: np.ndarray, rng: np.random.Generator) -> np.ndarray:
    """The mount of the encoder turns as it warms."""
    return p["turn_rad_K"] * (bench.air_degC - bench.air_degC[0])


def settling(p: Sizes, bench: Bench, drum: np.ndarray, rng: np.random.Generator) -> np.ndarray:
    """The ropes settle."""
    return p["amplitude_rad"] * np.log1p(bench.time_s / p["time_s"])


def mount_jump(p: Sizes, bench: Bench, drum: np.ndarray, rng: np.random.Generator) -> np.ndarray:
    """The mount of the encoder slips once."""
    return p["step_rad"] * (0.5 + 0.5 * np.tanh((bench.time_s - p["at_s"]) / 0.04))


def damaged_strand(p: Sizes, bench: Bench, drum: np.ndarray, rng: np.random.Generator) -> np.ndarray:
    """A thick place of the rope runs onto the drum's tangent point: a bump at one place of the travel."""
    return p["height_rad"] * np.exp(-0.5 * ((drum - p["at_rad"]) / p["width_rad"]) ** 2)


def climbing(p: Sizes, bench: Bench, drum: np.ndarray, rng: np.random.Generator) -> np.ndarray:
    """The rope climbs the edge of a land beyond one place of the travel and comes back later than it went."""
    up = p["height_rad"] * (0.5 + 0.5 * np.tanh((drum - p["at_rad"]) / 0.012))
    down = p["height_rad"] * (0.5 + 0.5 * np.tanh((drum - p["at_rad"] + p["lag_rad"]) / 0.012))
    return np.where(bench.speed_rad_s >= 0.0, up, down)


def worn_land(p: Sizes, bench: Bench, drum: np.ndarray, rng: np.random.Generator) -> np.ndarray:
    """A stretch of the land is worn: the radius is smaller there, so the drum runs ahead and stays ahead."""
    return p["share"] * np.clip(drum - p["from_rad"], 0.0, p["length_rad"])


def hardening(p: Sizes, bench: Bench, drum: np.ndarray, rng: np.random.Generator) -> np.ndarray:
    """A compliance that grows with load."""
    return -p["compliance_rad_Nm2"] * bench.load_Nm * np.abs(bench.load_Nm)


def one_sided_square(p: Sizes, bench: Bench, drum: np.ndarray, rng: np.random.Generator) -> np.ndarray:
    """A frame that bends with the square of the load, whichever way it pulls."""
    return -p["compliance_rad_Nm2"] * bench.load_Nm**2


def speed_squared(p: Sizes, bench: Bench, drum: np.ndarray, rng: np.random.Generator) -> np.ndarray:
    """An error that grows with the square of the speed."""
    return p["coefficient_rad_s2"] * bench.speed_rad_s**2


def stick_slip(p: Sizes, bench: Bench, drum: np.ndarray, rng: np.random.Generator) -> np.ndarray:
    """The load judders: saw teeth whose length in angle never repeats."""
    run = np.cumsum(np.abs(np.gradient(drum)))
    teeth = np.concatenate(
        [[0.0], np.cumsum(rng.exponential(p["pitch_rad"], size=int(run[-1] / p["pitch_rad"] * 2 + 50)))]
    )
    k = np.searchsorted(teeth, run) - 1
    k = np.clip(k, 0, teeth.size - 2)
    share = (run - teeth[k]) / (teeth[k + 1] - teeth[k])
    return -p["height_rad"] * (share - 0.5) * np.sign(bench.speed_rad_s)


def wander(p: Sizes, bench: Bench, drum: np.ndarray, rng: np.random.Generator) -> np.ndarray:
    """The reading wanders in time and never the same way twice."""
    n, keep = bench.time_s.size, np.exp(-0.01 / p["memory_s"])
    steps = rng.normal(0.0, np.sqrt(1.0 - keep * keep), n)
    out = np.empty(n)
    now = 0.0
    for i in range(n):
        now = keep * now + steps[i]
        out[i] = now
    smooth = np.convolve(out, np.full(51, 1.0 / 51.0), mode="same")
    return p["rms_rad"] * smooth


def texture(p: Sizes, bench: Bench, drum: np.ndarray, rng: np.random.Generator) -> np.ndarray:
    """The grain of the surfaces: small, the same at every pass, of many wavelengths."""
    orders = rng.uniform(4.0, 120.0, size=25)
    waves = [np.sin(order * drum + rng.uniform(0.0, 2.0 * np.pi)) * rng.rayleigh() for order in orders]
    total = np.sum(waves, axis=0)
    return p["rms_rad"] * total / np.sqrt(np.mean(total**2))


ADDED: dict[str, Added] = {
    function.__name__: function
    for function in (
        output_scale,
        output_encoder,
        division,
        shaft_compliance,
        latency,
        output_play,
        warming,
        settling,
        mount_jump,
        damaged_strand,
        climbing,
        worn_land,
        hardening,
        one_sided_square,
        speed_squared,
        stick_slip,
        wander,
        texture,
    )
}
