"""Schema of the measurement file: the content of each column of a logger's file, or values printed in a paper."""

from __future__ import annotations

import re
from functools import cache
from typing import Any, Literal, get_args

from pydantic import ConfigDict

from mbcdm_cad.design.blocks import INERTIA_MAX_KG_M2
from mbcdm_cad.design.describe import Node
from mbcdm_cad.design.fieldpath import FieldPath
from mbcdm_cad.design.fields import Block, Integer, Number, Text
from mbcdm_cad.design.fields import quantity as figure

# The column of an input: input_ and the name that the design file gives it.
INPUT_COLUMN = r"^input_[a-z0-9][a-z0-9_-]{0,63}$"
# The current of its motor: the same with current, or current alone for a drive with one input.
CURRENT = "current"
CURRENT_COLUMN = INPUT_COLUMN.replace("input", CURRENT)
SENSORS = "data sheet"
LOGGER = "the logger's file"
ANALYSER = "the analyser's table"
BENCH = "bench"
# Columns of an analyser's table.
TABLE = ("frequency", "gain", "phase", "coherence", "amplitude")


def _figure(meaning: str, source: str, example: Any = None, default: Any = ..., **more: Any) -> Any:
    """A figure of the file; one without a default is needed."""
    return figure(meaning, source=source, example=example, **({} if default is ... else {"default": default}), **more)


def _choice(meaning: str, source: str, example: Any = None, default: Any = ..., **more: Any) -> Any:
    """The same of what has no unit."""
    return _figure(meaning, source, example, default, unit="-", **more)


class Column(Block):
    """One column of the data."""

    column: Text | Integer = _choice("name in the header, or number from 1", LOGGER, "q_left")
    unit: Text = _choice("unit of the numbers, after zero and scale are applied", LOGGER, "rad")
    scale: Number = _figure("factor on the numbers; -1 reverses the sign", LOGGER, -1.0, 1.0, ge=-1e12, le=1e12)
    zero: Number = _figure(
        "value that the sensor shows at zero; it is subtracted before scale is applied", LOGGER, 338.56, 0.0
    )
    wraps_at: Number | None = _figure(
        "figure at which an angle begins again at zero, as the sensor shows it: 360 for degrees, counts_per_turn "
        "of an absolute encoder, 65536 for a counter of 16 bits; whole turns are then counted. For a time that begins "
        "again every second, as the microseconds beside a column of seconds: 1000000",
        SENSORS,
        16384.0,
        None,
        gt=0.0,
        le=1e12,
    )
    side: Literal["drive", "motor"] = _choice(
        "place of an input encoder: motor if it sits before the gearhead, whose ratio is then taken from the design",
        LOGGER,
        "motor",
        "drive",
    )
    lever_arm_mm: Number | None = _figure(
        "arm of a load cell on the drum, for a load torque in a unit of force",
        "drawing of the bench",
        120.0,
        None,
        gt=0.0,
        le=1e5,
    )
    radius_mm: Number | None = _figure(
        "radius at which the length is measured, for an angle in a unit of length: that of a linear encoder's track, "
        "of a tape on the drum, or the arm of a dial gauge; angle = length / radius",
        "drawing of the bench",
        60.0,
        None,
        gt=0.0,
        le=1e5,
    )
    counts_per_turn: Number | None = _figure(
        "counts for one turn, if the unit is counts", SENSORS, 8192.0, None, unit="1/turn", gt=0.0, le=1e12
    )

    channel: Text | None = _choice(
        "name of its channel in channel_column, where each row holds one channel", LOGGER, "/joint/position", None
    )


class Columns(Block):
    """What was measured. Inputs are positive when they drive the drum positive.

    An input of any other name than left and right is ``input_<name>``, the name being that of the design file.
    """

    model_config = ConfigDict(extra="allow", frozen=True, defer_build=True)
    __pydantic_extra__: dict[str, Column]

    time: Column | None = _choice("time; left out where sample_rate_Hz is given", LOGGER, "{column: t, unit: s}", None)
    input_left: Column | None = _choice("angle of the input at -x", LOGGER, default=None)
    input_right: Column | None = _choice("angle of the input at +x", LOGGER, default=None)
    input: Column | None = _choice("angle of the input of a drive with one input", LOGGER, default=None)
    output: Column | None = _choice(
        "angle of the drum; needed but in an analyser's table", LOGGER, "{column: q_out, unit: rad}", None
    )
    load_torque: Column | None = _choice(
        "load on the drum, > 0 where it opposes positive rotation; without it, effects of the load cannot be tested",
        LOGGER,
        default=None,
    )
    temperature: Column | None = _choice("temperature at the drive", LOGGER, default=None)
    current: Column | None = _choice(
        "current of the motor, in place of load_torque, or beside it: the losses between both are then told from the "
        "gain of the sensor; current_<name>, as the inputs, where there are several",
        LOGGER,
        default=None,
    )

    excitation: Column | None = _choice(
        "what excites the drive in a run of kind frequency_response, in any unit: the command of angle, current or "
        "torque; with it, noise of the input does not bias the response",
        LOGGER,
        "{column: command, unit: rad}",
        None,
    )
    frequency: Column | None = _choice(
        "frequency of an analyser's table, in a run of kind frequency_response; the table then has gain and "
        "phase in place of time, inputs and output",
        ANALYSER,
        "{column: f, unit: Hz}",
        None,
    )
    gain: Column | None = _choice(
        "gain of the output's angle over what response.over says, as a figure or in dB",
        ANALYSER,
        "{column: mag, unit: dB}",
        None,
    )
    phase: Column | None = _choice(
        "phase of the same, 0 where the output goes with it", ANALYSER, "{column: ph, unit: deg}", None
    )
    coherence: Column | None = _choice("its coherence; rows below 0.5 are left out", ANALYSER, default=None)
    amplitude: Column | None = _choice(
        "amplitude of what the gain is over at each frequency: of the inputs as their encoders read, or of the torque",
        ANALYSER,
        default=None,
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

    input_resolution_rad: Number | None = _figure(
        "one step of the input encoders", SENSORS, 1.9175e-4, None, gt=0.0, le=1.0
    )
    output_resolution_rad: Number | None = _figure(
        "one step of the output encoder", SENSORS, 1.3635e-6, None, gt=0.0, le=1.0
    )
    input_noise_rad: Number | None = _figure(
        "RMS noise of the input encoders in addition to their steps", SENSORS, 5e-5, None, ge=0.0, le=1.0
    )
    output_noise_rad: Number | None = _figure(
        "RMS noise of the output encoder in addition to its steps", SENSORS, 2e-6, None, ge=0.0, le=1.0
    )
    torque_noise_Nm: Number | None = _figure("RMS noise of the torque sensor", SENSORS, 0.005, None, ge=0.0, le=1e6)
    torque_class_share: Number | None = _figure(
        "class of the torque sensor: largest error of its gain, and of its zero as a share of the largest load; within "
        "it an error is no effect of the drive; a usual class of 0.01 if left out",
        SENSORS,
        0.005,
        None,
        ge=0.0,
        le=0.5,
    )
    torque_lag_s: Number | None = _figure(
        "largest lag of the torque sensor behind the encoders, by its filter; 0.011 s, a filter of 15 Hz, if left out",
        SENSORS,
        0.003,
        None,
        ge=0.0,
        le=1.0,
    )


class Pendulum(Block):
    """A weight on an arm at the output."""

    mass_kg: Number = _figure("mass of the weight", BENCH, 2.0, gt=0.0, le=1e4)
    arm_mm: Number = _figure("distance of the weight's centre from the axis", BENCH, 150.0, gt=0.0, le=1e5)
    inertia_kg_m2: Number = _figure(
        "moment of inertia of arm, drum and coupling about the axis, without the weight at its arm",
        BENCH,
        0.002,
        0.0,
        ge=0.0,
        le=INERTIA_MAX_KG_M2,
    )
    vertical_deg: Number = _figure(
        "angle of the output, as its column reads after zero and scale, at which the weight hangs straight down; of a "
        "column in counts: counts / counts_per_turn * 360",
        BENCH,
        0.0,
        0.0,
        ge=-1e4,
        le=1e4,
    )


class MotorBlock(Block):
    """The motors whose currents are the load. What is left out is that of the design's catalogue entries."""

    torque_constant_Nm_A: Number | None = _figure(
        "torque over current at the motor's shaft", SENSORS, 0.0182, None, gt=0.0, le=1e3
    )
    torque_constant_share: Number = _figure(
        "standard deviation of the torque constant as a share; within two of them an error of the load is no effect",
        BENCH,
        0.05,
        0.05,
        ge=0.0,
        le=0.25,
    )
    gear_ratio: Number | None = _figure(
        "ratio of the gearhead between the motor and the input's encoder, 1 for none",
        SENSORS,
        76.0,
        None,
        gt=0.0,
        le=1e4,
    )
    efficiency: Number | None = _figure("efficiency of the gearhead", SENSORS, 0.65, None, gt=0.5, le=1.0)
    rotor_inertia_kg_m2: Number | None = _figure("moment of inertia of the rotor", SENSORS, 1e-7, None, ge=0.0, le=10.0)
    friction_Nm: Number = _figure("friction of the motor at its shaft", BENCH, 1e-4, 0.0, ge=0.0, le=100.0)


class KnownLoad(Block):
    """A load that no sensor measured but that is known."""

    pendulum: Pendulum = _choice("a weight on an arm", BENCH)


class CountedParts(Block):
    """What the prediction counts besides the cables, by the figures of the design."""

    structure: bool = _choice("drum, shafts, bearings and frame give with the load", BENCH, True, True)
    losses: bool = _choice("cables that bend, and bearings, hold the drum back", BENCH, True, True)
    output_at: Literal["drum", "payload"] = _choice(
        "place of the output encoder: the drum's shaft, or the payload", BENCH, "payload", "drum"
    )
    inputs_at: Literal["pulleys", "motors"] | None = _choice(
        "place of the input encoders; left out, as the side of their columns says", BENCH, "motors", None
    )


class InertiaPlate(Block):
    """What the bench makes the output turn besides the design's payload."""

    inertia_kg_m2: Number = _figure(
        "moment of inertia of plate and coupling about the axis", BENCH, 0.02, ge=0.0, le=INERTIA_MAX_KG_M2
    )
    inertia_share: Number = _figure(
        "standard deviation of all that the output turns, as a share; within two of them an error is no effect",
        BENCH,
        0.01,
        0.02,
        ge=0.0,
        le=0.5,
    )


class ResponseBlock(Block):
    """What the gain of an analyser's table is over."""

    over: Literal["inputs", "torque"] = _choice(
        "inputs: angle of the output over that of the inputs; torque: over a torque on it, inputs held, "
        "as of a hammer, a shaker or a motor there",
        BENCH,
        "torque",
        "inputs",
    )
    turns: Number | None = _figure(
        "turns of the inputs' encoders for one of the output; left out, the drive's ratio; 1 if the analyser "
        "divided by it, times the gearhead's ratio of encoders on the motors",
        BENCH,
        1.0,
        None,
        gt=0.0,
        le=1e7,
    )
    amplitude_rad: Number | None = _figure(
        "amplitude of the inputs as their encoders read, the same at all frequencies", BENCH, 0.01, None, gt=0.0, le=1e7
    )
    amplitude_Nm: Number | None = _figure(
        "amplitude of the torque on the output, the same at all frequencies", BENCH, 0.1, None, gt=0.0, le=1e7
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

    preload_N: Number | None = _figure("tension in every cable", "paper", 70.0, None, gt=0.0, le=1e5)
    load_torque_Nm: Number | None = _figure("load on the drum", "paper", 0.91, None, gt=0.0, le=1e5)
    half_travel_rad: Number | None = _figure("amplitude of the drum's motion", "paper", 0.05, None, gt=0.0, le=100.0)


class Published(Block):
    """One figure that was printed instead of a run."""

    quantity: Quantity = _choice("what was measured", "paper", "backlash")
    value: Number = _figure("measured value", "paper", 0.33, gt=0.0, le=1e12)
    unit: Text = _choice("unit of the value", "paper", "mrad")
    stated_theory: Number | None = _figure(
        "value that the authors expected, in the same unit", "paper", 3.9, None, gt=0.0, le=1e12
    )
    conditions: Conditions = _choice("conditions of the measurement", "paper", default=Conditions())
    where: Text = _choice("page, section or figure", "paper", "section 5.3")


class Measurement(Block):
    """A measurement file: ``data`` with ``columns``, or ``published``."""

    data: Text | None = _choice("the logger's file, its path relative to this file", LOGGER, "run.csv", None)
    kind: Kind = _choice(
        "what the rows are: motion, samples of a drive that moves; turning_points, one row where the motion or the "
        "load turns round, as written by hand; creep, readings at rest since a load was put on, at time 0; "
        "frequency_response, a log of a chirp, a multisine or noise by the drive's own motors",
        BENCH,
        "turning_points",
        "motion",
    )
    columns: Columns | None = _choice("what each column contains", LOGGER, default=None)
    sensors: SensorFigures = _choice("what the sensors resolve", SENSORS, default=SensorFigures())
    load: Literal["none"] | KnownLoad | None = _choice(
        "load that no sensor measured: none if nothing loads the output but its own bearings, or a pendulum, which "
        "beside the motors' currents gives their torque constant; leave it out where the load is not known",
        BENCH,
        "none",
        None,
    )
    parts: CountedParts | None = _choice(
        "what else than the cables the prediction counts; left out, all else is rigid and without friction, as in "
        "files from before this field",
        BENCH,
        default=None,
    )
    inertia_plate: InertiaPlate | None = _choice(
        "what the output turns besides the design's payload, in a run of kind frequency_response", BENCH, default=None
    )
    response: ResponseBlock | None = _choice("what the gain of an analyser's table is over", BENCH, default=None)
    motor: MotorBlock = _choice("the motors, where their currents are the load", SENSORS, default=MotorBlock())
    ratio: Number | None = _figure(
        "total ratio, for a drive of which nothing else is known; the design file is then not used",
        "data sheet of the drive",
        35.0,
        None,
        gt=0.0,
        le=1e6,
    )
    delimiter: Literal["auto", "comma", "semicolon", "tab", "space"] = _choice(
        "character between two columns", LOGGER, "semicolon", "auto"
    )
    decimal: Literal["point", "comma"] = _choice("decimal sign", LOGGER, "comma", "point")
    comment: Text = _choice("sign that begins a comment line", LOGGER, "%", "#")
    skip_rows: Integer = _figure(
        "number of lines to skip at the start of the file", LOGGER, 2, 0, unit="lines", ge=0, le=100_000
    )
    header: Literal["auto", "row", "comment", "none"] = _choice(
        "place of the names: row (first row), comment (last comment line before the data) or none; auto finds it",
        LOGGER,
        "comment",
        "auto",
    )
    sample_rate_Hz: Number | None = _figure(
        "samples a second of a table without a column of times, each row one step later than the row before",
        LOGGER,
        100.0,
        None,
        gt=0.0,
        le=1e7,
    )
    broken_rows: Literal["refuse", "skip"] = _choice(
        "rows of another length, with text or with NaN: refuse the file, or skip up to one row in fifty and report it; "
        "skip also leaves out rows that repeat the time of the row before",
        LOGGER,
        "skip",
        "refuse",
    )
    rows: Literal["full", "own_times"] = _choice(
        "own_times: a row holds only some of the quantities, at their own times, and its other cells are empty; each "
        "is interpolated onto the times of the output",
        LOGGER,
        "own_times",
        "full",
    )
    channel_column: Text | Integer | None = _choice(
        "column with the name of the channel whose figure is in the row; then give the channel of each quantity",
        LOGGER,
        "topic",
        None,
    )
    published: tuple[Published, ...] | None = _choice(
        "values printed in a paper, in place of data", "paper", default=None, min_length=1, max_length=100
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
