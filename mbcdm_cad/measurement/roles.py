"""Guess which column of a logger's table is which quantity: from names, from slopes between columns, from units.

The angles are found together: of all pairs of columns that move, input and output are the pair whose names and whose
slope against the drive's ratio speak for it most. A column whose name says speed, current, command or flag, or that is
the rate of another column, is an angle only if nothing else is left.
"""

from __future__ import annotations

import re
from collections.abc import Callable, Collection, Iterator, Mapping, Sequence
from dataclasses import dataclass, field
from itertools import permutations
from math import inf, log, pi, radians

import numpy as np

from mbcdm_cad.design.drive import Drive
from mbcdm_cad.measurement.logformat import ANGLE, DECIBEL, FORCE, FREQUENCY, GIVE, TEMPERATURE, TIME, TORQUE, Unit
from mbcdm_cad.measurement.vet_columns import LEAST_AGREEMENT, robust_slope
from mbcdm_cad.routes import Floats

# Relative miss of a ratio or a number of counts up to which it counts as met, and up to which it is still near.
MET, NEAR = 0.03, 0.1
# Share of the rows in which the time must rise: a logger may write each row several times.
LEAST_RISING = 0.1
# Lines or counts a turn that encoders are sold with, times 1 or 4 for edges.
LINES = (100, 125, 128, 200, 250, 256, 300, 360, 400, 500, 512, 600, 720, 900, 1000, 1024, 1250, 2000, 2048, 2500, 3600)
# Steppers take 200 steps a turn, divided by up to 256.
STEPS = {200 << k for k in range(9)}
COUNTS_SOLD = sorted({n * edges for n in LINES for edges in (1, 4)} | {2**k for k in range(8, 27)} | STEPS)
# Whole numbers within a smaller span are states or flags, no counter.
LEAST_COUNTED = 50.0


def _words(text: str) -> frozenset[str]:
    return frozenset(text.split())


# Words of a name, whole: a name is divided at signs, at capitals and between letters and digits.
TIME_WORDS = _words("t time timestamp stamp sec secs seconds clock zeit tick ticks ms us")
# Names of columns that number the rows.
_NUMBER = _words("frame frames sample samples scan row index idx counter seq number no line n")
_TEMPERATURE = _words("temp temperature temperatur degc °c")
_LOAD = _words("tau torque torq moment drehmoment load cell loadcell force kraft f trq")
_ANGLE = _words(
    "pos position angle ang enc encoder theta phi q rad deg resolver pot potentiometer potmeter winkel counts "
    "count cnt steps turns estimate magnet hall"
)
_NO_ANGLE = _words(
    "controller vel velocity speed omega rpm w rate dq qd geschwindigkeit acc accel acceleration cur curr current amp "
    "amps i iq id strom cmd command commanded demand target set setpoint desired des goal sp reference soll flag state "
    "status mode error err fault timeout volt volts voltage pwm duty power effort index idx counter seq sample "
    "gyro imu frame frames scan row line"
)
_OUTPUT = _words(
    "out output drum joint link load ank ankle knee hip elbow wrist tip arm end tool second secondary driven "
    "abtrieb abtriebs last resolver pot potentiometer l low slave lever side elevation"
)
_INPUT = _words("in input mot motor m servo first primary actuator drive driving rotor antrieb steps stepper")
# Long words that also stand inside a word, as in Motorwinkel.
_INSIDE = {"motor": _INPUT, "antrieb": _INPUT, "abtrieb": _OUTPUT, "winkel": _ANGLE, "moment": _LOAD, "torque": _LOAD}


# Roles in an analyser's table, in the order in which they are looked for, with words of their names and units.
_RESPONSE: tuple[tuple[str, frozenset[str], Collection[str]], ...] = (
    ("phase", _words("phase ph phi arg argument phasengang"), ()),
    ("coherence", _words("coherence coh coherency kohärenz gamma"), ()),
    ("frequency", _words("frequency freq frequenz f omega"), tuple(FREQUENCY)),
    ("gain", _words("gain mag magnitude amplitude betrag abs h amp"), (DECIBEL, *GIVE)),
)


@dataclass(eq=False)
class Guess:
    """A column of figures with its role, the fields of its entry in the measurement file, and the reasons for them."""

    name: str | int
    unit: str
    values: Floats
    role: str = ""
    fields: dict[str, object] = field(default_factory=dict)
    reasons: list[str] = field(default_factory=list)

    @property
    def words(self) -> tuple[str, ...]:
        """The words of the name in small letters; none where the file has no names."""
        if isinstance(self.name, int):
            return ()
        # A unit in brackets is left out, an index in brackets is not.
        plain = re.sub(r"[\[(](?!\d+\]).*", "", self.name)
        parts = re.findall(r"[A-ZÄÖÜ]+(?![a-zäöü])|[A-ZÄÖÜ]?[a-zäöüß°]+|\d+", plain)
        return tuple(part.lower() for part in parts)

    def says(self, words: frozenset[str]) -> bool:
        """Whether the name has one of the words, or a long one of them inside a word."""
        own = self.words
        return any(word in words for word in own) or any(
            inside in word and meant is words for word in own for inside, meant in _INSIDE.items()
        )

    @property
    def whole(self) -> bool:
        """Whether its figures are whole numbers that span as much as those of a counter."""
        return bool(np.all(self.values == np.round(self.values))) and float(np.ptp(self.values)) > LEAST_COUNTED


@dataclass(frozen=True)
class Expected:
    """What is known of the drive: names of its inputs, ratio to the drum; None what only a design file tells.

    ``travel_rad``: full travel between the stops. ``output_counts``: counts a turn of the design's drum encoder.
    """

    name: str
    input_names: tuple[str, ...]
    ratio: float
    gearhead_ratio: float | None = None
    travel_rad: float | None = None
    output_counts: float | None = None

    @classmethod
    def of_drive(cls, drive: Drive) -> Expected:
        """From a design."""
        return cls(
            drive.name,
            drive.input_names,
            float(np.mean([run.drum_radius_mm / run.input_radius_mm for run in drive.cables])),
            drive.reduction.ratio,
            2.0 * radians(drive.half_travel_deg + drive.stop_clearance_deg),
            None if drive.drum_encoder.absent else sold(2.0 * pi / (drive.drum_encoder.resolution_urad * 1e-6)),
        )

    @classmethod
    def of_ratio(cls, ratio: float) -> Expected:
        """From the total ratio of a drive with one input, of which nothing else is known."""
        return cls("", ("input",), ratio)

    @property
    def one_input(self) -> bool:
        """Whether the drive has one input, which then needs no name."""
        return len(self.input_names) == 1

    @property
    def known_from(self) -> str:
        """Where this is known from, in words."""
        return f"the ratio {self.ratio:g}" if self.travel_rad is None else f"the design {self.name}"

    def column_of(self, input_name: str) -> str:
        """Name of an input's column in a measurement file."""
        return "input" if self.one_input else f"input_{input_name}"


@dataclass(frozen=True)
class Turns:
    """A unit of an input's angle and the place of its encoder; ``miss``: logarithm of its slope over the ratio."""

    miss: float
    side: str
    fields: dict[str, object]


def sold(counts: float) -> float:
    """The nearest number of counts a turn that encoders are sold with; the figure itself where none is near."""
    near = min(COUNTS_SOLD, key=lambda n: abs(log(counts / n)))
    return float(near) if abs(log(counts / near)) < MET else float(max(round(counts), 1))


def response_columns(columns: Sequence[Guess]) -> dict[str, Guess] | None:
    """Frequency, gain, phase and coherence of an analyser's table, by name and unit; None if it is none."""
    found = dict[str, Guess]()
    for role, words, units in _RESPONSE:
        for column in columns:
            steps = np.diff(column.values)
            one_way = bool(np.all(steps > 0.0) or np.all(steps < 0.0))
            fits = column.unit in units or column.says(words) or any(str(column.name).endswith(f"_{u}") for u in units)
            # Of several gains the first that is not that of a reference channel; phases have a gain's word too.
            if fits and np.ptp(column.values) and (role != "frequency" or one_way) and column not in found.values():
                found.setdefault(role, column)
    if not {"frequency", "gain", "phase"} <= set(found):
        return None
    return {role: found[role] for role in ("frequency", "gain", "phase", "coherence") if role in found}


def assign(columns: Sequence[Guess], expected: Expected, output_rad: Callable[[Guess], float]) -> None:
    """Give each column its role. ``output_rad``: rad per figure of a column, if it is the output."""
    _assign(columns, "time", lambda c: (c.unit in TIME or c.says(TIME_WORDS)) and _rises(c))
    if all(c.role != "time" for c in columns):
        _assign(columns, "time", lambda c: _rises(c) and not _numbers_rows(c), "it rises in every row")
    _assign(columns, "temperature", lambda c: c.unit in TEMPERATURE or c.says(_TEMPERATURE))
    _assign(columns, "load_torque", _is_load)
    moving = [c for c in columns if not c.role and float(np.ptp(c.values)) > 0.0]
    angles = [c for c in moving if not c.says(_NO_ANGLE) and not _is_rate(c, moving)]
    for among in (angles, moving):
        if len(among) >= 1 + len(expected.input_names) or (among is moving and len(among) >= 2):
            _angles(among, expected, output_rad)
            return
    # One column alone may still be the output; a person finds the rest.
    for column in moving[:1]:
        column.role = "output"
        column.reasons.append("the only column that moves")


def _assign(columns: Sequence[Guess], role: str, fits: Callable[[Guess], bool], reason: str = "") -> None:
    """The first free column that fits gets the role."""
    for column in columns:
        if not column.role and fits(column):
            column.role = role
            named = column.says(TIME_WORDS | _TEMPERATURE | _LOAD)
            column.reasons.append(reason or ("by its name" if named else "by the unit in its header"))
            return


def _rises(column: Guess) -> bool:
    steps = np.diff(column.values)
    return bool(np.all(steps >= 0.0)) and float(np.mean(steps > 0.0)) > LEAST_RISING


def _numbers_rows(column: Guess) -> bool:
    """Whether the column counts the rows or frames one by one, which is no time."""
    return column.says(_NUMBER) and bool(np.all(np.diff(column.values) == 1.0))


def _is_load(column: Guess) -> bool:
    if column.says(_NO_ANGLE):
        return False
    return bool(stated_unit(column, {**TORQUE, **FORCE})[0]) or (column.says(_LOAD) and not column.says(_ANGLE))


def _is_rate(column: Guess, others: Sequence[Guess]) -> bool:
    """Whether the column follows the change of another one: a speed beside its angle."""
    own = column.values[1:]
    for other in others:
        change = np.diff(other.values)
        if other is column or float(np.ptp(change)) == 0.0 or float(np.ptp(own)) == 0.0:
            continue
        if abs(float(np.corrcoef(own, change)[0, 1])) > 0.99:
            return True
    return False


def _angles(among: list[Guess], expected: Expected, output_rad: Callable[[Guess], float]) -> None:
    """Output and inputs: the choice with the largest sum of what names and slopes say."""
    best, chosen = -inf, (among[0], tuple(among[1:2]))
    for output in among:
        others = [c for c in among if c is not output]
        counts = min(len(expected.input_names), len(others))
        fits = {id(c): _fit(c, output, expected, output_rad(output)) for c in others}
        for inputs in permutations(others, counts):
            score = _said_output(output) + sum(
                fits[id(c)] + _said_input(c, name, output)
                for c, name in zip(inputs, expected.input_names, strict=False)
            )
            if score > best + 1e-9:
                best, chosen = score, (output, inputs)
    output, found = chosen
    output.role = "output"
    output.reasons.append(
        "by its name" if _said_output(output) > 0.0 else "it turns slower than the input by the ratio"
    )
    for column, name in zip(found, expected.input_names, strict=False):
        column.role = expected.column_of(name)
        own = name.lower() in str(column.name).lower()
        column.reasons.append(
            f"its name contains that of the input {name}"
            if own and not expected.one_input
            else "by its name"
            if expected.one_input and column.says(_INPUT)
            else "by its slope against the output"
            if expected.one_input
            else "in the order of the design's inputs: check which is which"
        )


def _said_output(column: Guess) -> float:
    says = column.says(_OUTPUT)
    return 2.0 * says - 1.5 * (column.says(_INPUT) and not says) + 0.5 * column.says(_ANGLE)


def _said_input(column: Guess, input_name: str, output: Guess) -> float:
    says = column.says(_INPUT)
    own = input_name.lower() in str(column.name).lower()
    number, other = _number(column), _number(output)
    before = number is not None and other is not None and number[0] == other[0] and number[1] < other[1]
    return (
        3.0 * own
        + 2.0 * says
        - 1.5 * (column.says(_OUTPUT) and not says and not own)
        + 0.5 * column.says(_ANGLE)
        + 1.0 * before
    )


def _number(column: Guess) -> tuple[tuple[str, ...], int] | None:
    """The name without its first number, and this number: encoder 1 is more often at the motor than encoder 2."""
    words = column.words
    at = next((k for k, word in enumerate(words) if word.isdigit()), None)
    return None if at is None else ((*words[:at], *words[at + 1 :]), int(words[at]))


def _fit(column: Guess, output: Guess, expected: Expected, rad: float) -> float:
    """What the slope says for an input: high where it meets the ratio in a unit that the figures may have."""
    slope, agreement = robust_slope(output.values * rad, column.values)
    if slope == 0.0 or agreement < LEAST_AGREEMENT:
        return -4.0
    unit, _ = stated_unit(column, ANGLE)
    # Both angles in one unit, whichever it is, are more likely than two units.
    if not unit and abs(log(abs(slope) * rad / expected.ratio)) < MET:
        return 5.0
    met = min(turns.miss for turns in ways(column, abs(slope), expected, unit))
    return 4.0 if met < MET else 2.0 if met < NEAR else 0.0


def ways(column: Guess, slope: float, expected: Expected, unit: str) -> Iterator[Turns]:
    """Units and places of an input's encoder with the miss of the ratio; ``slope``: figures per rad of the output.

    ``unit`` is what the header says; empty where it says nothing.
    """
    sides = [("drive", expected.ratio)]
    if expected.gearhead_ratio is not None:
        sides.append(("motor", expected.ratio * expected.gearhead_ratio))
    for side, turns in sides:
        for word in [unit] if unit else [] if column.whole else ["rad", "deg", "turn", "mrad"]:
            yield Turns(abs(log(slope * ANGLE[word].factor / turns)), side, {"unit": word})
        if not unit and column.whole:
            wanted = slope * 2.0 * pi / turns
            begins_again = column.fields.get("wraps_at")
            if isinstance(begins_again, float) and abs(log(wanted / begins_again)) < NEAR:
                yield Turns(0.0, side, {"unit": "counts", "counts_per_turn": begins_again})
            per_turn = sold(wanted)
            # Few lines a turn are more usual on a motor, many on a shaft, as in encoder catalogues.
            known = 0.0 if per_turn in COUNTS_SOLD else MET
            yield Turns(abs(log(wanted / per_turn)) + known, side, {"unit": "counts", "counts_per_turn": per_turn})


def stated_unit(column: Guess, units: Mapping[str, Unit]) -> tuple[str, str]:
    """The unit that the header or the end of the name states, and which of them does; empty where neither does."""
    if column.unit in units:
        return column.unit, "unit as its header says"
    ending = str(column.name).rsplit("_", 1)[-1]
    # As it is written first: N is a newton, n is none.
    unit = next((word for word in (ending, ending.lower()) if word in units), "")
    return (unit, "unit by the end of its name") if unit and "_" in str(column.name) else ("", "")
