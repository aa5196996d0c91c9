"""One measured run in SI units, as every later step uses it, its half sweeps, and one note of its vetting."""

from collections.abc import Iterable, Sequence
from dataclasses import dataclass, field
from functools import cached_property
from typing import Literal, get_args

import numpy as np
from numpy.typing import NDArray
from scipy.ndimage import uniform_filter1d

from mbcdm_cad.design.yamltree import FieldPath
from mbcdm_cad.measurement.schema import MOTION, NO_PLATE, CountedParts, InertiaPlate, Kind, MotorBlock
from mbcdm_cad.routes import Complex, Floats
from mbcdm_cad.storage.compiled import compiled

Level = Literal["refused", "doubt", "fact"]


# What a load comes from that no sensor measured.
KNOWN_LOAD, MOTORS_CURRENT = "known load", "motors' current"


@dataclass(frozen=True)
class TorqueClass:
    """Largest errors of a torque sensor in its class: gain as a share, zero as a share of the range, lag in s.

    The defaults are those of usual sensors with a filter of 15 Hz or more; ``stated``: the measurement file gives them;
    ``what`` the load comes from. ``zero_share`` is that of the gain if it is None. ``gain_sigma`` is the standard
    deviation of the gain where more than its bound is known.
    """

    share: float = 0.01
    lag_s: float = 0.011
    stated: bool = False
    what: str = "torque sensor"
    zero_share: float | None = None
    gain_sigma: float | None = None

    @classmethod
    def of_motors(cls, constant_sigma: float) -> "TorqueClass":
        """Of motors' currents: the torque constant's spread is one of the gain, a zero is the amplifiers' alone."""
        return cls(2.0 * constant_sigma, 0.0, what=MOTORS_CURRENT, zero_share=cls.share, gain_sigma=constant_sigma)

    @property
    def of_known(self) -> bool:
        """Whether no sensor measured the load, but it is known."""
        return self.what == KNOWN_LOAD

    @property
    def of_currents(self) -> bool:
        """Whether it is that of the motors' currents."""
        return self.what == MOTORS_CURRENT

    @property
    def zero(self) -> float:
        """Largest zero as a share of the range."""
        return self.share if self.zero_share is None else self.zero_share

    @property
    def words(self) -> str:
        """The class in words."""
        source = "as stated" if self.stated else "usual, none is stated"
        lag = f", lag {1e3 * self.lag_s:.3g} ms" if self.lag_s else ""
        sizes = f"{self.share:.3g} of gain and range"
        if self.zero != self.share:
            sizes = f"{self.share:.3g} of gain, {self.zero:.3g} of the range"
        return f"{sizes}{lag}, {source}"


@dataclass(frozen=True)
class BesideSensor:
    """What motors carry beside a torque sensor: ``gain`` times its torque (with standard deviation), and by the sense
    of the motion a constant, a share of its size, and at the usual speed what is viscous.

    ``told``: the share of the sensor's torque that does not go with the motion; ``of_design_Nm``: the constant by the
    design's figures, None without one; ``used``: how much the loop weighs the currents' gain beside the sensor's.
    """

    gain: float
    gain_sigma: float
    dry_Nm: float
    share: float
    viscous_Nm: float
    told: float
    of_design_Nm: float | None = None
    used: float = 0.0


@dataclass(frozen=True, eq=False)
class ResponseTable:
    """An analyser's table, (n,) each: the angle of the output over ``over``, "inputs" as their encoders read or
    "torque", and the amplitude of that.

    ``turns`` of the inputs for one of the output, None for the drive's ratio; coherence, amplitude: None if not given.
    """

    frequency_Hz: Floats
    value: Complex
    over: str
    turns: float | None
    coherence: Floats | None
    amplitude: Floats | None


@dataclass(frozen=True)
class Sensors:
    """Resolution and noise of the sensors; None where the measurement file does not state them."""

    input_resolution_rad: float | None = None
    output_resolution_rad: float | None = None
    torque_noise_Nm: float | None = None
    input_noise_rad: float | None = None
    output_noise_rad: float | None = None
    torque_class: TorqueClass = TorqueClass()


@dataclass(frozen=True)
class PartsSeen:
    """What the parts besides the cables do to a run, by the figures of the design.

    ``give_rad_Nm``: how far the reading turns with the load, for 1 N m; ``friction_Nm``: what holds the drum back
    against its motion; ``friction_factor``: one standard deviation of its logarithm, as a factor. ``play_rad``: of a
    belt or gears between each input's encoder and its pulley.
    """

    give_rad_Nm: float
    give_sigma_rad_Nm: float
    friction_Nm: float
    friction_factor: float
    play_rad: float = 0.0


@dataclass(frozen=True)
class ZerosFound:
    """Zeros of the inputs that were taken from the data, rad: largest difference between two inputs that was removed,
    how wrong that may be, and the angle of all inputs that was removed."""

    apart_rad: float
    apart_unsure_rad: float
    centre_rad: float


@dataclass(frozen=True, eq=False)
class Run:
    """A measured run. Arrays have one column a sample; inputs are positive when they drive the drum positive.

    Shapes: ``time_s`` (n,), ``input_rad`` (n_inputs, n), ``output_rad`` (n,), ``load_Nm`` and ``temperature_C`` (n,) or
    None. ``load_Nm`` > 0 opposes positive rotation. ``ratio`` is the total ratio of a drive of which nothing else is
    known, else None. ``motor_side`` says of each input whether its encoder sits on the motor, before the gearhead:
    then its angle is the motor's until the run is compared with a design (:func:`mbcdm_cad.measurement.vet.arranged`).
    ``zeros``: those of the inputs that the file does not give (:mod:`mbcdm_cad.measurement.vet`). ``counted``: what the
    file lets the prediction count besides the cables; ``parts``: its figures, once the run is compared with a design.
    ``current_A`` (n_inputs, n) are the motors' currents, ``motor`` their figures: the load follows from them where the
    run is compared with a design, or with its ratio, and is ``beside`` a sensor's where there is one. ``kind`` is what
    the rows are; where inputs stand still and have no columns, they are at zero. ``expected_creep``: of a run at rest,
    the creep of the rope for each decade of time by its catalogue entry, over its elastic stretch. ``excitation`` (n,),
    in any unit, and ``plate``: of a frequency response what excites it, and what the output turns; ``table``: of one
    that an analyser wrote, and ``time_s`` then counts its rows.
    """

    time_s: Floats
    input_rad: Floats
    output_rad: Floats
    load_Nm: Floats | None = None
    temperature_C: Floats | None = None
    sensors: Sensors = field(default_factory=Sensors)
    input_names: tuple[str, ...] = ("left", "right")
    source: str = ""
    sha256: str = ""
    ratio: float | None = None
    motor_side: tuple[bool, ...] = ()
    zeros: ZerosFound | None = None
    counted: CountedParts | None = None
    parts: PartsSeen | None = None
    current_A: Floats | None = None
    motor: MotorBlock | None = None
    beside: BesideSensor | None = None
    kind: Kind = MOTION
    expected_creep: float = 0.0
    excitation: Floats | None = None
    plate: InertiaPlate = NO_PLATE
    table: ResponseTable | None = None

    @cached_property
    def step_s(self) -> float:
        """Time between samples, s: the median."""
        return float(np.median(np.diff(self.time_s)))

    def quiet(self, values: Floats) -> Floats:
        """Values (n,) smoothed over the window in which a speed is computed."""
        return smoothed(values, SPEED_WINDOW_S, self.step_s)

    @cached_property
    def half_sweep(self) -> NDArray[np.int64]:
        """Number of the half sweep at each sample, from 0, (n,)."""
        return half_sweeps(self.quiet(self.output_rad))


@dataclass(frozen=True)
class VettingNote:
    """One sentence about a run, found before any residual is computed.

    ``kind`` identifies it for programs; ``field`` is the field of the measurement file that it concerns.

    ``refused``: the run cannot be judged as it is declared. ``doubt``: it is judged, but the result may be wrong.
    ``fact``: what the experiment can and cannot show.
    """

    kind: str
    level: Level
    text: str
    remedy: str = ""
    field: FieldPath = ()

    def __str__(self) -> str:
        """Sentence and remedy on one line."""
        return self.text + (f"; {self.remedy}" if self.remedy else "")


def refused(kind: str, text: str, remedy: str = "", *field: str | int) -> VettingNote:
    """A note because of which the run cannot be judged."""
    return VettingNote(kind, "refused", text, remedy, field)


def doubt(kind: str, text: str, remedy: str = "", *field: str | int) -> VettingNote:
    """A note that the result may be wrong."""
    return VettingNote(kind, "doubt", text, remedy, field)


def fact(kind: str, text: str, remedy: str = "", *field: str | int) -> VettingNote:
    """A note on what the run shows."""
    return VettingNote(kind, "fact", text, remedy, field)


def gravest_first(findings: Iterable[VettingNote]) -> list[VettingNote]:
    """Refusals, then doubts, then facts."""
    return sorted(findings, key=lambda finding: get_args(Level).index(finding.level))


def doubts(notes: Sequence[str], findings: Sequence[VettingNote]) -> list[str]:
    """Reasons to doubt a result: notes of the reading and doubts of the vetting."""
    return [*notes, *(str(finding) for finding in findings if finding.level == "doubt")]


def column_of(input_name: str) -> FieldPath:
    """Field of the measurement file that describes one input."""
    return ("columns", "input" if input_name == "input" else f"input_{input_name}")


# A reversal counts if the output has moved back by this share of its travel.
REVERSAL_SHARE = 0.1
# Window over which a speed is computed, s.
SPEED_WINDOW_S = 0.1


@compiled
def _turns(output: Floats, reach: float, out: NDArray[np.int64]) -> int:
    """Fill ``out`` with the samples at which the output turns; their number."""
    found, rising = 0, 0
    low = high = output[0]
    low_at = high_at = 0
    for k in range(output.size):
        value = output[k]
        if rising >= 0 and value > high:
            high, high_at = value, k
        if rising <= 0 and value < low:
            low, low_at = value, k
        if rising >= 0 and high - value > reach:
            out[found] = high_at
            found += 1
            rising, low, low_at = -1, value, k
        elif rising <= 0 and value - low > reach:
            out[found] = low_at
            found += 1
            rising, high, high_at = 1, value, k
    return found


def half_sweeps(output_rad: Floats) -> NDArray[np.int64]:
    """Number of the half sweep at each sample, from 0; shape (n,). A turn counts after a tenth of the travel."""
    out, reach = np.empty(output_rad.size + 1, dtype=np.int64), REVERSAL_SHARE * float(np.ptp(output_rad))
    turns = out[: _turns(np.ascontiguousarray(output_rad), reach, out)]
    # There is no reversal before the first motion.
    if turns.size and abs(output_rad[turns[0]] - output_rad[0]) <= reach:
        turns = turns[1:]
    return np.asarray(np.searchsorted(turns, np.arange(output_rad.size), side="right"), dtype=np.int64)


def smoothed(values: Floats, window_s: float, step_s: float) -> Floats:
    """Two passes of a centred moving mean: a triangle ``window_s`` wide; the ends are held."""
    width = 2 * round(window_s / (4.0 * step_s)) + 1
    if width == 1:
        return values
    once = uniform_filter1d(values, width, axis=-1, mode="nearest")
    return np.asarray(uniform_filter1d(once, width, axis=-1, mode="nearest"))


def smoothed_at(values: Floats, time_s: Floats, window_s: float, step_s: float) -> Floats:
    """As ``smoothed``, for a moving signal whose samples are not evenly spaced in time.

    A mean belongs to the mean time of its samples. Where a logger jitters, loses samples or ends, that is not the time
    of the middle sample; the slope takes the mean there.
    """
    mean, at = smoothed(values, window_s, step_s), smoothed(time_s, window_s, step_s)
    return np.asarray(mean + np.gradient(mean, at, axis=-1) * (time_s - at))
