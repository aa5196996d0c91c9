"""Schema of the measurement file: the content of each column of a logger's file, or values printed in a paper."""

import re
from functools import cache, partial
from typing import Any, Literal, get_args

from pydantic import ConfigDict

from mbcdm_cad.design.blocks import INERTIA_MAX_KG_M2
from mbcdm_cad.design.describe import Node
from mbcdm_cad.design.fields import Block, Integer, Number, Text, quantity
from mbcdm_cad.design.yamltree import FieldPath

# The column of an input: input_ and the name that the design file gives it.
INPUT_COLUMN = r"^input_[a-z0-9][a-z0-9_-]{0,63}$"
# The current of its motor: the same with current, or current alone for a drive with one input.
CURRENT = "current"
CURRENT_COLUMN = INPUT_COLUMN.replace("input", CURRENT)
# Columns of an analyser's table.
TABLE = ("frequency", "gain", "phase", "coherence", "amplitude")


def _figure(meaning: str, example: Any = None, within: str = "", **more: Any) -> Any:
    """A field of the file with an example; ``within``: its bounds, as in "(0, 1]"."""
    return quantity(meaning, within, example=example, **more)


# Fields by where their values stand.
_logger, _sheet = partial(_figure, source="the logger's file"), partial(_figure, source="data sheet")
_analyser, _bench = partial(_figure, source="the analyser's table"), partial(_figure, source="bench")
_paper = partial(_figure, source="paper")


class Column(Block):
    """One column of the data."""

    column: Text | Integer = _logger("name in the header, or number from 1", "q_left")
    unit: Text = _logger("unit of the numbers, after zero and scale are applied", "rad")
    scale: Number = _logger("factor on the numbers; -1 reverses the sign", -1.0, "[-1e12, 1e12]", default=1.0)
    zero: Number = _logger(
        "value that the sensor shows at zero; it is subtracted before scale is applied", 338.56, default=0.0
    )
    wraps_at: Number | None = _sheet(
        "figure at which an angle begins again at zero, as the sensor shows it: 360 for degrees, counts_per_turn "
        "of an absolute encoder, 65536 for a counter of 16 bits; whole turns are then counted. For a time that begins "
        "again every second, as the microseconds beside a column of seconds: 1000000",
        16384.0,
        "(0, 1e12]",
    )
    side: Literal["drive", "motor"] = _logger(
        "place of an input encoder: motor if it sits before the gearhead, whose ratio is then taken from the design",
        "motor",
        default="drive",
    )
    lever_arm_mm: Number | None = _bench(
        "arm of a load cell on the drum, for a load torque in a unit of force",
        120.0,
        "(0, 1e5]",
        source="drawing of the bench",
    )
    radius_mm: Number | None = _bench(
        "radius at which the length is measured, for an angle in a unit of length: that of a linear encoder's track, "
        "of a tape on the drum, or the arm of a dial gauge; angle = length / radius",
        60.0,
        "(0, 1e5]",
        source="drawing of the bench",
    )
    counts_per_turn: Number | None = _sheet(
        "counts for one turn, if the unit is counts", 8192.0, "(0, 1e12]", unit="1/turn"
    )
    channel: Text | None = _logger(
        "name of its channel in channel_column, where each row holds one channel", "/joint/position"
    )


class Columns(Block):
    """What was measured. Inputs are positive when they drive the drum positive.

    An input of any other name than left and right is ``input_<name>``, the name being that of the design file.
    """

    model_config = ConfigDict(extra="allow", frozen=True, defer_build=True)
    __pydantic_extra__: dict[str, Column]

    time: Column | None = _logger("time; left out where sample_rate_Hz is given", "{column: t, unit: s}")
    input_left: Column | None = _logger("angle of the input at -x")
    input_right: Column | None = _logger("angle of the input at +x")
    input: Column | None = _logger("angle of the input of a drive with one input")
    output: Column | None = _logger(
        "angle of the drum; needed but in an analyser's table", "{column: q_out, unit: rad}"
    )
    load_torque: Column | None = _logger(
        "load on the drum, > 0 where it opposes positive rotation; without it, effects of the load cannot be tested"
    )
    temperature: Column | None = _logger("temperature at the drive")
    current: Column | None = _logger(
        "current of the motor, in place of load_torque, or beside it: the losses between both are then told from the "
        "gain of the sensor; current_<name>, as the inputs, where there are several"
    )

    excitation: Column | None = _logger(
        "what excites the drive in a run of kind frequency_response, in any unit: the command of angle, current or "
        "torque; with it, noise of the input does not bias the response",
        "{column: command, unit: rad}",
    )
    frequency: Column | None = _analyser(
        "frequency of an analyser's table, in a run of kind frequency_response; the table then has gain and "
        "phase in place of time, inputs and output",
        "{column: f, unit: Hz}",
    )
    gain: Column | None = _analyser(
        "gain of the output's angle over what response.over says, as a figure or in dB", "{column: mag, unit: dB}"
    )
    phase: Column | None = _analyser("phase of the same, 0 where the output goes with it", "{column: ph, unit: deg}")
    coherence: Column | None = _analyser("its coherence; rows below 0.5 are left out")
    amplitude: Column | None = _analyser(
        "amplitude of what the gain is over at each frequency: of the inputs as their encoders read, or of the torque"
    )

    def given(self) -> dict[str, Column]:
        """The columns given, in the order in which a table holds them: time, inputs, output, the rest."""
        extra = self.__pydantic_extra__ or {}
        named = {key: column for key, column in extra.items() if not key.startswith(CURRENT)}
        currents = {key: column for key, column in extra.items() if key.startswith(CURRENT)} | {CURRENT: self.current}
        inputs = {key: getattr(self, key) for key in ("input_left", "input_right")} | named | {"input": self.input}
        rest = {key: getattr(self, key) for key in ("output", "load_torque", "temperature", "excitation", *TABLE)}
        found: dict[str, Column | None] = {"time": self.time, **inputs, **rest, **currents}
        return {key: column for key, column in found.items() if column is not None}


def is_column(key: str) -> bool:
    """Whether a measurement file may have a column of this name."""
    return key in Columns.model_fields or re.match(f"{INPUT_COLUMN}|{CURRENT_COLUMN}", key) is not None


class SensorFigures(Block):
    """What the sensors resolve: a lower bound of the noise floor, which comes from the data.

    Counts give the resolution where it is left out.
    """

    input_resolution_rad: Number | None = _sheet("one step of the input encoders", 1.9175e-4, "(0, 1]")
    output_resolution_rad: Number | None = _sheet("one step of the output encoder", 1.3635e-6, "(0, 1]")
    input_noise_rad: Number | None = _sheet(
        "RMS noise of the input encoders in addition to their steps", 5e-5, "[0, 1]"
    )
    output_noise_rad: Number | None = _sheet("RMS noise of the output encoder in addition to its steps", 2e-6, "[0, 1]")
    torque_noise_Nm: Number | None = _sheet("RMS noise of the torque sensor", 0.005, "[0, 1e6]")
    torque_class_share: Number | None = _sheet(
        "class of the torque sensor: largest error of its gain, and of its zero as a share of the largest load; within "
        "it an error is no effect of the drive; a usual class of 0.01 if left out",
        0.005,
        "[0, 0.5]",
    )
    torque_lag_s: Number | None = _sheet(
        "largest lag of the torque sensor behind the encoders, by its filter; 0.011 s, a filter of 15 Hz, if left out",
        0.003,
        "[0, 1]",
    )


class Pendulum(Block):
    """A weight on an arm at the output."""

    mass_kg: Number = _bench("mass of the weight", 2.0, "(0, 1e4]")
    arm_mm: Number = _bench("distance of the weight's centre from the axis", 150.0, "(0, 1e5]")
    inertia_kg_m2: Number = _bench(
        "moment of inertia of arm, drum and coupling about the axis, without the weight at its arm",
        0.002,
        f"[0, {INERTIA_MAX_KG_M2}]",
        default=0.0,
    )
    vertical_deg: Number = _bench(
        "angle of the output, as its column reads after zero and scale, at which the weight hangs straight down; of a "
        "column in counts: counts / counts_per_turn * 360",
        0.0,
        "[-1e4, 1e4]",
        default=0.0,
    )


class MotorBlock(Block):
    """The motors whose currents are the load. What is left out is that of the design's catalogue entries."""

    torque_constant_Nm_A: Number | None = _sheet("torque over current at the motor's shaft", 0.0182, "(0, 1e3]")
    torque_constant_share: Number = _bench(
        "standard deviation of the torque constant as a share; within two of them an error of the load is no effect",
        0.05,
        "[0, 0.25]",
        default=0.05,
    )
    gear_ratio: Number | None = _sheet(
        "ratio of the gearhead between the motor and the input's encoder, 1 for none", 76.0, "(0, 1e4]"
    )
    efficiency: Number | None = _sheet("efficiency of the gearhead", 0.65, "(0.5, 1]")
    rotor_inertia_kg_m2: Number | None = _sheet("moment of inertia of the rotor", 1e-7, "[0, 10]")
    friction_Nm: Number = _bench("friction of the motor at its shaft", 1e-4, "[0, 100]", default=0.0)


class KnownLoad(Block):
    """A load that no sensor measured but that is known."""

    pendulum: Pendulum = _bench("a weight on an arm")


class CountedParts(Block):
    """What the prediction counts besides the cables, by the figures of the design."""

    structure: bool = _bench("drum, shafts, bearings and frame give with the load", True, default=True)
    losses: bool = _bench("cables that bend, and bearings, hold the drum back", True, default=True)
    output_at: Literal["drum", "payload"] = _bench(
        "place of the output encoder: the drum's shaft, or the payload", "payload", default="drum"
    )
    inputs_at: Literal["pulleys", "motors"] | None = _bench(
        "place of the input encoders; left out, as the side of their columns says", "motors"
    )


class InertiaPlate(Block):
    """What the bench makes the output turn besides the design's payload."""

    inertia_kg_m2: Number = _bench(
        "moment of inertia of plate and coupling about the axis", 0.02, f"[0, {INERTIA_MAX_KG_M2}]"
    )
    inertia_share: Number = _bench(
        "standard deviation of all that the output turns, as a share; within two of them an error is no effect",
        0.01,
        "[0, 0.5]",
        default=0.02,
    )


class ResponseBlock(Block):
    """What the gain of an analyser's table is over."""

    over: Literal["inputs", "torque"] = _bench(
        "inputs: angle of the output over that of the inputs; torque: over a torque on it, inputs held, "
        "as of a hammer, a shaker or a motor there",
        "torque",
        default="inputs",
    )
    turns: Number | None = _bench(
        "turns of the inputs' encoders for one of the output; left out, the drive's ratio; 1 if the analyser "
        "divided by it, times the gearhead's ratio of encoders on the motors",
        1.0,
        "(0, 1e7]",
    )
    amplitude_rad: Number | None = _bench(
        "amplitude of the inputs as their encoders read, the same at all frequencies", 0.01, "(0, 1e7]"
    )
    amplitude_Nm: Number | None = _bench(
        "amplitude of the torque on the output, the same at all frequencies", 0.1, "(0, 1e7]"
    )


# Nothing besides the design's payload, known as well as usual.
NO_PLATE = InertiaPlate.model_construct(inertia_kg_m2=0.0)


Kind = Literal["motion", "turning_points", "creep", "frequency_response"]
MOTION, TURNING_POINTS, CREEP, FREQUENCY_RESPONSE = get_args(Kind)
# Kinds of which a person may have written the few rows, and whose inputs may stand still.
BY_HAND: tuple[Kind, ...] = (TURNING_POINTS, CREEP)

Quantity = Literal["peak_torque", "mass", "backlash", "ripple_amplitude", "ripple_order"]


class Conditions(Block):
    """Conditions of a published measurement."""

    preload_N: Number | None = _paper("tension in every cable", 70.0, "(0, 1e5]")
    load_torque_Nm: Number | None = _paper("load on the drum", 0.91, "(0, 1e5]")
    half_travel_rad: Number | None = _paper("amplitude of the drum's motion", 0.05, "(0, 100]")


class Published(Block):
    """One figure that was printed instead of a run."""

    quantity: Quantity = _paper("what was measured", "backlash")
    value: Number = _paper("measured value", 0.33, "(0, 1e12]")
    unit: Text = _paper("unit of the value", "mrad")
    stated_theory: Number | None = _paper("value that the authors expected, in the same unit", 3.9, "(0, 1e12]")
    conditions: Conditions = _paper("conditions of the measurement", default=Conditions())
    where: Text = _paper("page, section or figure", "section 5.3")


class Measurement(Block):
    """A measurement file: ``data`` with ``columns``, or ``published``."""

    data: Text | None = _logger("the logger's file, its path relative to this file", "run.csv")
    kind: Kind = _bench(
        "what the rows are: motion, samples of a drive that moves; turning_points, one row where the motion or the "
        "load turns round, as written by hand; creep, readings at rest since a load was put on, at time 0; "
        "frequency_response, a log of a chirp, a multisine or noise by the drive's own motors",
        "turning_points",
        default="motion",
    )
    columns: Columns | None = _logger("what each column contains")
    sensors: SensorFigures = _sheet("what the sensors resolve", default=SensorFigures())
    load: Literal["none"] | KnownLoad | None = _bench(
        "load that no sensor measured: none if nothing loads the output but its own bearings, or a pendulum, which "
        "beside the motors' currents gives their torque constant; leave it out where the load is not known",
        "none",
    )
    parts: CountedParts | None = _bench(
        "what else than the cables the prediction counts; left out, all else is rigid and without friction, as in "
        "files from before this field"
    )
    inertia_plate: InertiaPlate | None = _bench(
        "what the output turns besides the design's payload, in a run of kind frequency_response"
    )
    response: ResponseBlock | None = _bench("what the gain of an analyser's table is over")
    motor: MotorBlock = _sheet("the motors, where their currents are the load", default=MotorBlock())
    ratio: Number | None = _sheet(
        "total ratio, for a drive of which nothing else is known; the design file is then not used",
        35.0,
        "(0, 1e6]",
        source="data sheet of the drive",
    )
    delimiter: Literal["auto", "comma", "semicolon", "tab", "space"] = _logger(
        "character between two columns", "semicolon", default="auto"
    )
    decimal: Literal["point", "comma"] = _logger("decimal sign", "comma", default="point")
    comment: Text = _logger("sign that begins a comment line", "%", default="#")
    skip_rows: Integer = _logger(
        "number of lines to skip at the start of the file", 2, default=0, unit="lines", ge=0, le=100_000
    )
    header: Literal["auto", "row", "comment", "none"] = _logger(
        "place of the names: row (first row), comment (last comment line before the data) or none; auto finds it",
        "comment",
        default="auto",
    )
    sample_rate_Hz: Number | None = _logger(
        "samples a second of a table without a column of times, each row one step later than the row before",
        100.0,
        "(0, 1e7]",
    )
    broken_rows: Literal["refuse", "skip"] = _logger(
        "rows of another length, with text or with NaN: refuse the file, or skip up to one row in fifty and report it; "
        "skip also leaves out rows that repeat the time of the row before",
        "skip",
        default="refuse",
    )
    rows: Literal["full", "own_times"] = _logger(
        "own_times: a row holds only some of the quantities, at their own times, and its other cells are empty; each "
        "is interpolated onto the times of the output",
        "own_times",
        default="full",
    )
    channel_column: Text | Integer | None = _logger(
        "column with the name of the channel whose figure is in the row; then give the channel of each quantity",
        "topic",
    )
    published: tuple[Published, ...] | None = _paper(
        "values printed in a paper, in place of data", min_length=1, max_length=100
    )


@cache
def json_schema() -> Node:
    """JSON Schema of the measurement file with every reference written out; do not change it."""
    schema: Node = Measurement.model_json_schema()
    definitions = schema.pop("$defs", {})
    written: Node = _written_out(schema, definitions)
    # The load is a word or a block: both are written out as one node, of no type.
    written["properties"]["load"] |= {"properties": {"pendulum": _written_out(definitions["Pendulum"], definitions)}}
    columns = written["properties"]["columns"]
    columns["patternProperties"] = dict.fromkeys((INPUT_COLUMN, CURRENT_COLUMN), columns["properties"]["time"])
    columns["additionalProperties"] = False
    return written


def _written_out(node: Any, definitions: dict[str, Node]) -> Any:
    """``$ref`` replaced by what it refers to, and the branch that is not null by itself."""
    if isinstance(node, list):
        return [_written_out(item, definitions) for item in node]
    if not isinstance(node, dict):
        return node
    merged = {key: _written_out(value, definitions) for key, value in node.items() if key not in ("$ref", "anyOf")}
    branches = [branch for branch in node.get("anyOf", []) if branch.get("type") != "null"]
    if "$ref" in node:
        branches = [definitions[node["$ref"].rsplit("/", 1)[1]]]
    if len(branches) == 1:
        return {**_written_out(branches[0], definitions), **merged}
    return merged


def node_at(path: FieldPath) -> Node | None:
    """The schema's node for a field path; None if unknown."""
    node: Node | None = json_schema()
    for part in path:
        if node is None:
            return None
        if isinstance(part, int):
            node = node.get("items")
            continue
        patterns = node.get("patternProperties", {})
        named = next((found for pattern, found in patterns.items() if re.match(pattern, part)), None)
        node = node.get("properties", {}).get(part, named)
    return node
