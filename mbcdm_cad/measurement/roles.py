"""Find which column of a logger's table is which quantity: by the data first, then by names.

No angle is a column that runs with the time, numbers the rows, equals another, is its rate or the path that it
travelled. A column that begins again after N figures has N to a turn. Of the pairs that are left, output and input are
the one whose slope meets the drive's ratio in units that its figures may have, with the least scatter, and for which
the names speak most. A column whose name says speed, current, command or flag is an angle only if no other pair is one.
"""

import re
import tomllib
from collections.abc import Callable, Collection, Mapping, Sequence
from dataclasses import dataclass, field, replace
from itertools import permutations
from math import inf, log, log10, pi, radians
from pathlib import Path

import numpy as np

from mbcdm_cad.design.drive import Drive
from mbcdm_cad.measurement import logformat
from mbcdm_cad.measurement.vet_signals import LEAST_AGREEMENT, robust_slope
from mbcdm_cad.routes import Floats

# Relative miss of a ratio or a number of counts up to which it counts as met, and up to which it is still near.
MET, NEAR = 0.03, 0.1
# Share of the rows in which the time must rise: a logger may write each row several times.
LEAST_RISING = 0.1
# Share of the rows in which a time may begin anew; reading the draft then says where.
RESETS = 0.002
# Lines or counts a turn that encoders are sold with, times 1 or 4 for edges.
LINES = (100, 125, 128, 200, 250, 256, 300, 360, 400, 500, 512, 600, 720, 900, 1000, 1024, 1250, 2000, 2048, 2500, 3600)
MORE_LINES = (5000, 9000, 10_000, 18_000)
# Steppers take 200 steps a turn, divided by up to 256.
STEPS = {200 << k for k in range(9)}
# Motors commutate six times for each pair of poles.
COMMUTATIONS = set(range(12, 150, 6))
COUNTS_SOLD = sorted(
    {n * edges for n in LINES + MORE_LINES for edges in (1, 4)} | {2**k for k in range(8, 27)} | STEPS | COMMUTATIONS
)
# Counters of so many figures begin again after no turn: those of 8, 16 and 32 bits.
REGISTERS = (2.0**8, 2.0**16, 2.0**32)
# Whole numbers within a smaller span are states or flags, no counter.
LEAST_COUNTED = 50.0
# A column of fewer figures than this is hardly an angle where another fits.
FEWEST_LEVELS = 20
# How near a clock runs to one of the units of time, and two columns are to one.
SAME_RATE, SAME = 2e-3, 1e-6
# A column that turns by less than this share of the design's travel is hardly the drum.
LEAST_TRAVEL = 0.02
# What is said of a pair that does not follow each other.
UNRELATED = -4.0
# Figures of a turn by unit, units that are tried, and factors between two columns of one angle.
TURNS = {unit: 2.0 * pi / logformat.ANGLE[unit].factor for unit in ("deg", "rad", "turn")}
TRIED = ("rad", "deg", "mrad", "turn")
_FACTORS = {logformat.ANGLE[a].factor / logformat.ANGLE[b].factor for a in TRIED for b in TRIED}
# Figures of one second in ms, us and ns.
SECONDS = (1e3, 1e6, 1e9)
# Times counted from 1970 are above these in each unit; steps of seconds, in whole numbers or not, are below those.
EPOCHS = {"ns": 1e17, "us": 1e14, "ms": 1e11}
WHOLE_SECONDS, SPLIT_SECONDS = 0.5, 10.0
# Word of names of columns whose figures are turns: pos_estimate.
TURN_WORD = "estimate"


# Words of the names of columns, by what they mean.
_WORDS = {
    meant: frozenset(words.split())
    for meant, words in tomllib.loads(Path(__file__).with_name("words.toml").read_text("utf-8")).items()
}
TIME_WORDS, _ANGLE, _NO_ANGLE = _WORDS["time"], _WORDS["angle"], _WORDS["no_angle"]
_LOAD, _TEMPERATURE, _OUTPUT, _INPUT = (_WORDS[meant] for meant in ("load", "temperature", "output", "input"))
# Long words that also stand inside a word, as in Motorwinkel.
_INSIDE = {"motor": _INPUT, "antrieb": _INPUT, "abtrieb": _OUTPUT, "winkel": _ANGLE, "moment": _LOAD, "torque": _LOAD}


# Roles in an analyser's table, in the order in which they are looked for, with words of their names and units.
_RESPONSE: tuple[tuple[str, frozenset[str], Collection[str]], ...] = (
    ("phase", _WORDS["phase"], ()),
    ("coherence", _WORDS["coherence"], ()),
    ("frequency", _WORDS["frequency"], tuple(logformat.FREQUENCY)),
    ("gain", _WORDS["gain"], (logformat.DECIBEL, *logformat.GIVE)),
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
    def of_drive(cls, drive: Drive) -> "Expected":
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
    def of_ratio(cls, ratio: float) -> "Expected":
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
class Scale:
    """A unit of an angle: its fields, rad per figure, and why. ``miss``: logarithm of its slope over the ratio."""

    fields: dict[str, object]
    rad: float
    reason: str = ""
    miss: float = 0.0


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


def assign(columns: Sequence[Guess], expected: Expected) -> tuple[Scale | None, list[str]]:
    """Give each column its role; the output's scale, None where no two angles follow each other, and why others are no
    angles, a sentence each."""
    moving = [c for c in columns if float(np.ptp(c.values)) > 0.0]
    _assign(columns, "time", lambda c: (c.unit in logformat.TIME or c.says(TIME_WORDS)) and _rises(c))
    if all(c.role != "time" for c in columns) and len(moving) > 2:
        # Of several the one with the most even steps, as shafts may turn one way too.
        counts = [c for c in moving if c.says(_WORDS["number"]) and bool(np.all(np.diff(c.values) == 1.0))]
        rising = [c for c in moving if _rises(c) and c not in counts]
        rising.sort(key=lambda c: float(np.mean(np.abs(np.diff(c.values, 2))) / np.ptp(c.values)))
        _assign(rising[:1], "time", lambda c: True, "it rises in every row")
    time = next((c for c in columns if c.role == "time"), None)
    if time is not None:
        _time_unit(time)
    _assign(columns, "temperature", lambda c: c.unit in logformat.TEMPERATURE or c.says(_TEMPERATURE))
    no_load = [c for c in columns if c.says(_NO_ANGLE) or "wraps_at" in c.fields]
    torques = {**logformat.TORQUE, **logformat.FORCE}
    called = [c for c in columns if stated_unit(c, torques)[0] or (c.says(_LOAD) and not c.says(_ANGLE))]
    _assign([c for c in called if c not in no_load], "load_torque", lambda c: True)
    moving = [c for c in moving if not c.role]
    why = {id(c): reason for c in moving if (reason := _no_angle(c, moving, time, expected))}
    moving = [c for c in moving if id(c) not in why]
    angles = [c for c in moving if not c.says(_NO_ANGLE) and not _is_rate(c, moving)]
    scale, needed = None, 1 + len(expected.input_names)
    for among, fewest in ((angles, needed), (moving, 2)):
        if scale is None and len(among) >= fewest:
            scale = _angles(among, expected)
    return scale, [*why.values(), *(f"{c.name} moves" for c in angles)]


def _assign(columns: Sequence[Guess], role: str, fits: Callable[[Guess], bool], reason: str = "") -> None:
    """The first free column that fits gets the role."""
    for column in columns:
        if not column.role and fits(column):
            column.role = role
            named = column.says(TIME_WORDS | _TEMPERATURE | _LOAD)
            column.reasons.append(reason or ("by its name" if named else "by the unit in its header"))
            return


def _rises(column: Guess) -> bool:
    """Whether the column rises but for a few resets."""
    steps = np.diff(column.values)
    return float(np.mean(steps < 0.0)) <= RESETS and float(np.mean(steps > 0.0)) > LEAST_RISING


def _time_unit(column: Guess) -> None:
    """Draft the unit of the time: as stated, by where it begins again, or by the size of its steps."""
    unit, reason = stated_unit(column, logformat.TIME)
    begins_again = column.fields.get("wraps_at")
    if not unit and begins_again in SECONDS:
        unit = ("ms", "us", "ns")[SECONDS.index(float(str(begins_again)))]
        reason = f"{begins_again:g} of them are a second: {unit}?"
    if not unit:
        steps = np.diff(column.values)
        step = float(np.median(steps[steps > 0.0]))
        since_1970 = next((u for u, least in EPOCHS.items() if float(column.values[0]) > least), "")
        # Clocks of milliseconds and less write whole numbers.
        whole = bool(np.all(column.values == np.round(column.values)))
        seconds = WHOLE_SECONDS if whole else SPLIT_SECONDS
        unit = since_1970 or next(
            (u for u, most in {"s": seconds, "ms": 100.0, "us": 5e5}.items() if step < most), "ns"
        )
        reason = f"counted from 1970: {unit}?" if since_1970 else f"steps of {step:.4g}: {unit}?"
    column.fields["unit"] = unit
    column.reasons.append(reason)


def _no_angle(column: Guess, moving: Sequence[Guess], time: Guess | None, expected: Expected) -> str:
    """Why the data of a column are no angle of their own, as a sentence; empty where they may be one."""
    own, change = column.values, np.diff(column.values)
    rises = bool(np.all(change >= 0.0))
    if bool(np.all(change == 1.0)) and not column.says(_ANGLE | _INPUT):
        return f"{column.name} numbers the rows"
    if time is not None and rises and not column.says(_ANGLE):
        seconds = time.values * logformat.TIME[str(time.fields["unit"])].factor
        rate = float(np.ptp(own) / np.ptp(seconds))
        even = float(np.ptp(own - rate * seconds)) < 4.0 * change.max()
        if even and min(abs(log(rate / unit)) for unit in (1.0, *SECONDS)) < SAME_RATE:
            return f"{column.name} is a clock"
    for other in moving:
        steps = np.diff(other.values)
        to_and_fro = float(steps.min()) < 0.0 < float(steps.max())
        if rises and to_and_fro and float(np.abs(change - np.abs(steps)).mean()) < 0.05 * np.abs(steps).mean():
            return f"{column.name} is the path that {other.name} travelled"
    # An angle may be written twice, in two units, and the first stays; two inputs may be equal.
    before = next(k for k, c in enumerate(moving) if c is column)
    for other in moving[:before] if expected.one_input else ():
        factor = float(np.ptp(own) / np.ptp(other.values))
        unlike = min(float(np.ptp(own - f * other.values)) for f in (factor, -factor))
        if any(abs(log(factor / f)) < SAME for f in _FACTORS) and unlike < 10.0 * SAME * float(np.ptp(own)):
            return f"{column.name} equals {other.name}"
    return ""


def _is_rate(column: Guess, others: Sequence[Guess]) -> bool:
    """Whether the column follows the change of another one: a speed beside its angle."""
    own = column.values[1:]
    changes = [np.diff(other.values) for other in others if other is not column] if np.ptp(own) else []
    # An angle that swings follows the change of its speed too, with the other sign.
    return any(float(np.corrcoef(own, change)[0, 1]) > 0.99 for change in changes if np.ptp(change))


def _angles(among: list[Guess], expected: Expected) -> Scale | None:
    """Output and inputs: the choice with the largest sum of what slopes and names say; the output's scale.

    None where the best of them do not follow each other.
    """
    best, chosen = -inf, None
    for output in among:
        others = [c for c in among if c is not output]
        fits = {id(c): _fit(c, output, expected) for c in others}
        for inputs in permutations(others, min(len(expected.input_names), len(others))):
            score = _said_output(output) + sum(
                fits[id(c)] + _said_input(c, name, output)
                for c, name in zip(inputs, expected.input_names, strict=False)
            )
            if score > best + 1e-9 and any(fits[id(c)] > UNRELATED for c in inputs):
                best, chosen = score, (output, inputs)
    if chosen is None:
        return None
    output, found = chosen
    output.role = "output"
    scale = output_scale(output, found, expected)
    output.fields |= scale.fields
    named = _said_output(output) > 0.0
    output.reasons += ["by its name" if named else "it turns slower than the input by the ratio", scale.reason]
    for column, name in zip(found, expected.input_names, strict=False):
        column.role = expected.column_of(name)
        if expected.one_input:
            column.reasons.append("by its name" if column.says(_INPUT) else "by its slope against the output")
        elif name.lower() in str(column.name).lower():
            column.reasons.append(f"its name contains that of the input {name}")
        else:
            column.reasons.append("in the order of the design's inputs: check which is which")
        slope, _ = robust_slope(output.values * scale.rad, column.values)
        told = stated_scale(output) is not None
        mine = input_scale(column, slope, expected, told) if slope else Scale({"unit": "rad"}, 1.0)
        column.fields |= mine.fields | ({"scale": -1} if slope < 0.0 else {})
        column.reasons.append(mine.reason or "does not follow the output: is it the right column?")
    return scale


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


def _fit(column: Guess, output: Guess, expected: Expected) -> float:
    """What the slope says for an input: high where it meets the ratio in a unit that the figures may have."""
    slope, agreement = robust_slope(output.values, column.values)
    if slope == 0.0 or agreement < LEAST_AGREEMENT:
        return UNRELATED
    left = column.values - slope * output.values
    scatter = float(np.median(np.abs(left - np.median(left)))) / float(np.ptp(column.values))
    few = sum(np.unique(c.values).size < FEWEST_LEVELS for c in (column, output))
    scattered = 0.2 * max(log10(scatter + 1e-5), -5.0) + 2.0 * few
    # Both angles in one unit, whichever it is, are more likely than two units.
    if not (stated_scale(column) or stated_scale(output)) and abs(log(abs(slope) / expected.ratio)) < MET:
        return 5.0 - scattered
    scale = output_scale(output, [column], expected)
    mine = input_scale(column, slope / scale.rad, expected)
    miss = max(scale.miss, mine.miss)
    # Counts that a column shows itself tell more than any that meet the ratio, and of those the fewer more.
    for one, of in ((scale, output), (mine, column)):
        counts = one.fields.get("counts_per_turn") if stated_scale(of) is None else None
        scattered += 0.3 + 0.1 * log10(counts) if isinstance(counts, float) else 0.0
    return (4.0 if miss < MET else 2.0 if miss < NEAR else 0.0) - scattered


def stated_scale(column: Guess) -> Scale | None:
    """The unit that the header states, or that where a column begins again shows; None without either."""
    unit, reason = stated_unit(column, logformat.ANGLE)
    begins_again = column.fields.get("wraps_at")
    if not unit and TURN_WORD in column.words:
        unit, reason = "turn", "ODrive's estimates of a position are in turns"
    if not unit and isinstance(begins_again, float) and begins_again not in REGISTERS:
        unit = "" if column.whole else next((u for u in TURNS if abs(TURNS[u] - begins_again) < 1e-3), "")
        reason = f"{begins_again:g} to a turn"
        if not unit:
            return _counted(begins_again, reason)
    return Scale({"unit": unit}, logformat.ANGLE[unit].factor, reason) if unit else None


def _counted(per_turn: float, reason: str, miss: float = 0.0) -> Scale:
    return Scale({"unit": logformat.COUNTS, "counts_per_turn": per_turn}, 2.0 * pi / per_turn, reason, miss)


def _nearest(column: Guess, rad: float) -> Scale:
    """The unit in which a figure of the column is nearest to ``rad``."""
    if not column.whole:
        unit = min(("rad", "deg", "turn", "mrad"), key=lambda u: abs(log(logformat.ANGLE[u].factor / rad)))
        return Scale({"unit": unit}, logformat.ANGLE[unit].factor, "", abs(log(logformat.ANGLE[unit].factor / rad)))
    wanted = 2.0 * pi / rad
    begins_again = column.fields.get("wraps_at")
    if isinstance(begins_again, float) and abs(log(wanted / begins_again)) < NEAR:
        return _counted(begins_again, "")
    per_turn = sold(wanted)
    # Few lines a turn are more usual on a motor, many on a shaft, as in encoder catalogues.
    return _counted(per_turn, "", abs(log(wanted / per_turn)) + (0.0 if per_turn in COUNTS_SOLD else MET))


def output_scale(column: Guess, inputs: Sequence[Guess], expected: Expected) -> Scale:
    """The output's scale: as it states, else as an input that states its own meets the ratio, else by its span."""
    if (stated := stated_scale(column)) is not None:
        return stated
    begins_again, most = column.fields.get("wraps_at"), expected.travel_rad
    if column.whole and expected.output_counts is not None and begins_again is None:
        n = expected.output_counts
        return _counted(n, f"whole numbers; {n:g} a turn is the design's drum encoder")
    for follows in inputs if column.whole else ():
        own = stated_scale(follows)
        slope, _ = robust_slope(column.values, follows.values)
        if own is None or not slope:
            continue
        rad = own.rad * abs(slope) / expected.ratio
        # The same encoder twice is more likely than any other near it.
        same = abs(log(own.rad / rad)) < MET and own.fields["unit"] == logformat.COUNTS
        found = replace(own, miss=0.0) if same else _nearest(column, rad)
        if found.miss <= NEAR:
            n = float(str(found.fields["counts_per_turn"]))
            return _counted(n, f"whole numbers; with {n:g} a turn the ratio is met to {MET:.0%}", found.miss)
    span = float(np.ptp(column.values))
    if isinstance(begins_again, float):
        return _counted(begins_again, f"whole numbers that begin again after {begins_again:g}")
    if column.whole:
        enough = float(next((n for n in COUNTS_SOLD if n >= span and n & (n - 1) == 0), COUNTS_SOLD[-1]))
        return _counted(enough, f"whole numbers that span {span:g}: put the counts a turn of the encoder in place")
    travel = inf if most is None else most
    fits = [u for u in TRIED if LEAST_TRAVEL * travel < span * logformat.ANGLE[u].factor <= 1.05 * travel]
    unit = fits[0] if fits else "rad" if most is not None or span < 4.0 * pi else "deg"
    stops = "" if most is None else f", the design {most:.3g} rad between its stops"
    return Scale({"unit": unit}, logformat.ANGLE[unit].factor, f"spans {span:.4g}{stops}: {unit}?")


def input_scale(column: Guess, slope: float, expected: Expected, told: bool = False) -> Scale:
    """The input's unit and the place of its encoder with which the ratio is met best; ``slope``: figures per rad of the
    output, whose unit is ``told`` by its column."""
    own, found = stated_scale(column), list[Scale]()
    gearhead = {} if expected.gearhead_ratio is None else {"motor": expected.ratio * expected.gearhead_ratio}
    for side, turns in ({"drive": expected.ratio} | gearhead).items():
        rad = turns / abs(slope)
        one = _nearest(column, rad) if own is None else replace(own, miss=abs(log(own.rad / rad)))
        reason = f"{one.reason}; " * bool(one.reason) + f"{abs(slope):.6g} of its figures to a rad of the output"
        if side == "motor":
            reason += f": before the gearhead of {expected.gearhead_ratio:g}"
            one = replace(one, fields=one.fields | {"side": side})
        found.append(replace(one, reason=reason))
    best = min(found, key=lambda one: one.miss)
    if best.miss <= MET:
        return best
    off = f"no unit gives the ratio {expected.ratio:g} to a few percent"
    if own is not None and told:
        off = f"by these units the ratio is {abs(slope) * own.rad:.4g} and not {expected.ratio:g}"
    return replace(best, reason=f"{best.reason}; {off}: check")


def stated_unit(column: Guess, units: Mapping[str, logformat.Unit]) -> tuple[str, str]:
    """The unit that the header or the end of the name states, and which of them does; empty where neither does."""
    if column.unit in units:
        return column.unit, "unit as its header says"
    ending = str(column.name).rsplit("_", 1)[-1]
    # As it is written first: N is a newton, n is none.
    unit = next((word for word in (ending, ending.lower()) if word in units), "")
    return (unit, "unit by the end of its name") if unit and "_" in str(column.name) else ("", "")
