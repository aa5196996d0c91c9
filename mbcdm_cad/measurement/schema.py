"""Schema of the measurement file: the content of each column of a logger's file, or values printed in a paper."""

from __future__ import annotations

import re
from functools import cache
from typing import Any, Literal, get_args

from pydantic import ConfigDict

from mbcdm_cad.design.blocks import INERTIA_MAX_KG_M2
from mbcdm_cad.design.describe import Node
from mbcdm_cad.design.fieldpath import FieldPath
from mbcdm_cad.design.fields import Block, Integer, Number, Text, choice
from mbcdm_cad.design.fields import quantity as figure

# The column of an input: input_ and the name that the design file gives it.
INPUT_COLUMN = r"^input_[a-z0-9][a-z0-9_-]{0,63}$"
# The current of its motor: the same with current, or current alone for a drive with one input.
CURRENT = "current"
CURRENT_COLUMN = INPUT_COLUMN.replace("input", CURRENT)
SENSORS = "data sheet"
LOGGER = "the logger's file"
ANALYSER = "the analyser's table"
# Columns of an analyser's table.
TABLE = ("frequency", "gain", "phase", "coherence", "amplitude")


class Column(Block):
    """One column of the data."""

    column: Text | Integer = choice("name in the header, or number from 1", source=LOGGER, example="q_left")
    unit: Text = choice("unit of the numbers, after zero and scale are applied", source=LOGGER, example="rad")
    scale: Number = figure(
        "factor on the numbers; -1 reverses the sign", source=LOGGER, example=-1.0, default=1.0, ge=-1e12, le=1e12
    )
    zero: Number = figure(
        "value that the sensor shows at zero; it is subtracted before scale is applied",
        source=LOGGER,
        example=338.56,
        default=0.0,
    )
    wraps_at: Number | None = figure(
        "figure at which an angle begins again at zero, as the sensor shows it: 360 for degrees, counts_per_turn "
        "of an absolute encoder, 65536 for a counter of 16 bits; whole turns are then counted. For a time that begins "
        "again every second, as the microseconds beside a column of seconds: 1000000",
        source=SENSORS,
        example=16384.0,
        default=None,
        gt=0.0,
        le=1e12,
    )
    side: Literal["drive", "motor"] = choice(
        "place of an input encoder: motor if it sits before the gearhead, whose ratio is then taken from the design",
        source=LOGGER,
        example="motor",
        default="drive",
    )
    lever_arm_mm: Number | None = figure(
        "arm of a load cell on the drum, for a load torque in a unit of force",
        source="drawing of the bench",
        example=120.0,
        default=None,
        gt=0.0,
        le=1e5,
    )
    radius_mm: Number | None = figure(
        "radius at which the length is measured, for an angle in a unit of length: that of a linear encoder's track, "
        "of a tape on the drum, or the arm of a dial gauge; angle = length / radius",
        source="drawing of the bench",
        example=60.0,
        default=None,
        gt=0.0,
        le=1e5,
    )
    counts_per_turn: Number | None = figure(
        "counts for one turn, if the unit is counts",
        unit="1/turn",
        source=SENSORS,
        example=8192.0,
        default=None,
        gt=0.0,
        le=1e12,
    )

    channel: Text | None = choice(
        "name of its channel in channel_column, where each row holds one channel",
        source=LOGGER,
        default=None,
        example="/joint/position",
    )


class Columns(Block):
    """What was measured. Inputs are positive when they drive the drum positive.

    An input of any other name than left and right is ``input_<name>``, the name being that of the design file.
    """

    model_config = ConfigDict(extra="allow", frozen=True, defer_build=True)
    __pydantic_extra__: dict[str, Column]

    time: Column | None = choice(
        "time; left out where sample_rate_Hz is given", source=LOGGER, example="{column: t, unit: s}", default=None
    )
    input_left: Column | None = choice("angle of the input at -x", source=LOGGER, default=None)
    input_right: Column | None = choice("angle of the input at +x", source=LOGGER, default=None)
    input: Column | None = choice("angle of the input of a drive with one input", source=LOGGER, default=None)
    output: Column | None = choice(
        "angle of the drum; needed but in an analyser's table",
        source=LOGGER,
        example="{column: q_out, unit: rad}",
        default=None,
    )
    load_torque: Column | None = choice(
        "load on the drum, > 0 where it opposes positive rotation; without it, effects of the load cannot be tested",
        source=LOGGER,
        default=None,
    )
    temperature: Column | None = choice("temperature at the drive", source=LOGGER, default=None)
    current: Column | None = choice(
        "current of the motor, in place of load_torque, or beside it: the losses between both are then told from the "
        "gain of the sensor; current_<name>, as the inputs, where there are several",
        source=LOGGER,
        default=None,
    )

    excitation: Column | None = choice(
        "what excites the drive in a run of kind frequency_response, in any unit: the command of angle, current or "
        "torque; with it, noise of the input does not bias the response",
        source=LOGGER,
        example="{column: command, unit: rad}",
        default=None,
    )
    frequency: Column | None = choice(
        "frequency of an analyser's table, in a run of kind frequency_response; the table then has gain and "
        "phase in place of time, inputs and output",
        source=ANALYSER,
        example="{column: f, unit: Hz}",
        default=None,
    )
    gain: Column | None = choice(
        "gain of the output's angle over what response.over says, as a figure or in dB",
        source=ANALYSER,
        example="{column: mag, unit: dB}",
        default=None,
    )
    phase: Column | None = choice(
        "phase of the same, 0 where the output goes with it",
        source=ANALYSER,
        example="{column: ph, unit: deg}",
        default=None,
    )
    coherence: Column | None = choice("its coherence; rows below 0.5 are left out", source=ANALYSER, default=None)
    amplitude: Column | None = choice(
        "amplitude of what the gain is over at each frequency: of the inputs as their encoders read, or of the torque",
        source=ANALYSER,
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

    input_resolution_rad: Number | None = figure(
        "one step of the input encoders", source=SENSORS, example=1.9175e-4, default=None, gt=0.0, le=1.0
    )
    output_resolution_rad: Number | None = figure(
        "one step of the output encoder", source=SENSORS, example=1.3635e-6, default=None, gt=0.0, le=1.0
    )
    input_noise_rad: Number | None = figure(
        "RMS noise of the input encoders in addition to their steps",
        source=SENSORS,
        example=5e-5,
        default=None,
        ge=0.0,
        le=1.0,
    )
    output_noise_rad: Number | None = figure(
        "RMS noise of the output encoder in addition to its steps",
        source=SENSORS,
        example=2e-6,
        default=None,
        ge=0.0,
        le=1.0,
    )
    torque_noise_Nm: Number | None = figure(
        "RMS noise of the torque sensor", source=SENSORS, example=0.005, default=None, ge=0.0, le=1e6
    )
    torque_class_share: Number | None = figure(
        "class of the torque sensor: largest error of its gain, and of its zero as a share of the largest load; within "
        "it an error is no effect of the drive; a usual class of 0.01 if left out",
        source=SENSORS,
        example=0.005,
        default=None,
        ge=0.0,
        le=0.5,
    )
    torque_lag_s: Number | None = figure(
        "largest lag of the torque sensor behind the encoders, by its filter; 0.011 s, a filter of 15 Hz, if left out",
        source=SENSORS,
        example=0.003,
        default=None,
        ge=0.0,
        le=1.0,
    )


BENCH = "bench"


def _of_bench(meaning: str, example: float, default: float | None = None, optional: bool = False, **bounds: Any) -> Any:
    """A figure of the bench; one without a default is needed, unless it is ``optional``."""
    given: dict[str, Any] = {} if default is None and not optional else {"default": default}
    return figure(meaning, source=BENCH, example=example, **given, **bounds)


class Pendulum(Block):
    """A weight on an arm at the output."""

    mass_kg: Number = _of_bench("mass of the weight", 2.0, gt=0.0, le=1e4)
    arm_mm: Number = _of_bench("distance of the weight's centre from the axis", 150.0, gt=0.0, le=1e5)
    inertia_kg_m2: Number = _of_bench(
        "moment of inertia of arm, drum and coupling about the axis, without the weight at its arm",
        0.002,
        0.0,
        ge=0.0,
        le=INERTIA_MAX_KG_M2,
    )
    vertical_deg: Number = _of_bench(
        "angle of the output, as its column reads after zero and scale, at which the weight hangs straight down; of a "
        "column in counts: counts / counts_per_turn * 360",
        0.0,
        0.0,
        ge=-1e4,
        le=1e4,
    )


class MotorBlock(Block):
    """The motors whose currents are the load. What is left out is that of the design's catalogue entries."""

    torque_constant_Nm_A: Number | None = figure(
        "torque over current at the motor's shaft", source=SENSORS, example=0.0182, default=None, gt=0.0, le=1e3
    )
    torque_constant_share: Number = _of_bench(
        "standard deviation of the torque constant as a share; within two of them an error of the load is no effect",
        0.05,
        0.05,
        ge=0.0,
        le=0.25,
    )
    gear_ratio: Number | None = figure(
        "ratio of the gearhead between the motor and the input's encoder, 1 for none",
        source=SENSORS,
        example=76.0,
        default=None,
        gt=0.0,
        le=1e4,
    )
    efficiency: Number | None = figure(
        "efficiency of the gearhead", source=SENSORS, example=0.65, default=None, gt=0.5, le=1.0
    )
    rotor_inertia_kg_m2: Number | None = figure(
        "moment of inertia of the rotor", source=SENSORS, example=1e-7, default=None, ge=0.0, le=10.0
    )
    friction_Nm: Number = _of_bench("friction of the motor at its shaft", 1e-4, 0.0, ge=0.0, le=100.0)


class KnownLoad(Block):
    """A load that no sensor measured but that is known."""

    pendulum: Pendulum = choice("a weight on an arm", source=BENCH)


class CountedParts(Block):
    """What the prediction counts besides the cables, by the figures of the design."""

    structure: bool = choice(
        "drum, shafts, bearings and frame give with the load", source=BENCH, example=True, default=True
    )
    losses: bool = choice(
        "cables that bend, and bearings, hold the drum back", source=BENCH, example=True, default=True
    )
    output_at: Literal["drum", "payload"] = choice(
        "place of the output encoder: the drum's shaft, or the payload", source=BENCH, example="payload", default="drum"
    )
    inputs_at: Literal["pulleys", "motors"] | None = choice(
        "place of the input encoders; left out, as the side of their columns says",
        source=BENCH,
        example="motors",
        default=None,
    )


class InertiaPlate(Block):
    """What the bench makes the output turn besides the design's payload."""

    inertia_kg_m2: Number = _of_bench(
        "moment of inertia of plate and coupling about the axis", 0.02, ge=0.0, le=INERTIA_MAX_KG_M2
    )
    inertia_share: Number = _of_bench(
        "standard deviation of all that the output turns, as a share; within two of them an error is no effect",
        0.01,
        0.02,
        ge=0.0,
        le=0.5,
    )


# A figure above zero that may be left out.
_LEFT_OUT: dict[str, Any] = {"optional": True, "gt": 0.0, "le": 1e7}


class ResponseBlock(Block):
    """What the gain of an analyser's table is over."""

    over: Literal["inputs", "torque"] = choice(
        "inputs: angle of the output over that of the inputs; torque: over a torque on it, inputs held, "
        "as of a hammer, a shaker or a motor there",
        source=BENCH,
        example="torque",
        default="inputs",
    )
    turns: Number | None = _of_bench(
        "turns of the inputs' encoders for one of the output; left out, the drive's ratio; 1 if the analyser "
        "divided by it, times the gearhead's ratio of encoders on the motors",
        1.0,
        **_LEFT_OUT,
    )
    amplitude_rad: Number | None = _of_bench(
        "amplitude of the inputs as their encoders read, the same at all frequencies", 0.01, **_LEFT_OUT
    )
    amplitude_Nm: Number | None = _of_bench(
        "amplitude of the torque on the output, the same at all frequencies", 0.1, **_LEFT_OUT
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

    preload_N: Number | None = figure(
        "tension in every cable", source="paper", example=70.0, default=None, gt=0.0, le=1e5
    )
    load_torque_Nm: Number | None = figure(
        "load on the drum", source="paper", example=0.91, default=None, gt=0.0, le=1e5
    )
    half_travel_rad: Number | None = figure(
        "amplitude of the drum's motion", source="paper", example=0.05, default=None, gt=0.0, le=100.0
    )


class Published(Block):
    """One figure that was printed instead of a run."""

    quantity: Quantity = choice("what was measured", source="paper", example="backlash")
    value: Number = figure("measured value", source="paper", example=0.33, gt=0.0, le=1e12)
    unit: Text = choice("unit of the value", source="paper", example="mrad")
    stated_theory: Number | None = figure(
        "value that the authors expected, in the same unit", source="paper", example=3.9, default=None, gt=0.0, le=1e12
    )
    conditions: Conditions = choice("conditions of the measurement", source="paper", default=Conditions())
    where: Text = choice("page, section or figure", source="paper", example="section 5.3")


class Measurement(Block):
    """A measurement file: ``data`` with ``columns``, or ``published``."""

    data: Text | None = choice(
        "the logger's file, its path relative to this file", source=LOGGER, example="run.csv", default=None
    )
    kind: Kind = choice(
        "what the rows are: motion, samples of a drive that moves; turning_points, one row where the motion or the "
        "load turns round, as written by hand; creep, readings at rest since a load was put on, at time 0; "
        "frequency_response, a log of a chirp, a multisine or noise by the drive's own motors",
        source=BENCH,
        example="turning_points",
        default="motion",
    )
    columns: Columns | None = choice("what each column contains", source=LOGGER, default=None)
    sensors: SensorFigures = choice("what the sensors resolve", source=SENSORS, default=SensorFigures())
    load: Literal["none"] | KnownLoad | None = choice(
        "load that no sensor measured: none if nothing loads the output but its own bearings, or a pendulum, which "
        "beside the motors' currents gives their torque constant; leave it out where the load is not known",
        source=BENCH,
        example="none",
        default=None,
    )
    parts: CountedParts | None = choice(
        "what else than the cables the prediction counts; left out, all else is rigid and without friction, as in "
        "files from before this field",
        source=BENCH,
        default=None,
    )
    inertia_plate: InertiaPlate | None = choice(
        "what the output turns besides the design's payload, in a run of kind frequency_response",
        source=BENCH,
        default=None,
    )
    response: ResponseBlock | None = choice("what the gain of an analyser's table is over", source=BENCH, default=None)
    motor: MotorBlock = choice("the motors, where their currents are the load", source=SENSORS, default=MotorBlock())
    ratio: Number | None = figure(
        "total ratio, for a drive of which nothing else is known; the design file is then not used",
        source="data sheet of the drive",
        example=35.0,
        default=None,
        gt=0.0,
        le=1e6,
    )
    delimiter: Literal["auto", "comma", "semicolon", "tab", "space"] = choice(
        "character between two columns", source=LOGGER, example="semicolon", default="auto"
    )
    decimal: Literal["point", "comma"] = choice("decimal sign", source=LOGGER, example="comma", default="point")
    comment: Text = choice("sign that begins a comment line", source=LOGGER, example="%", default="#")
    skip_rows: Integer = figure(
        "number of lines to skip at the start of the file",
        unit="lines",
        source=LOGGER,
        example=2,
        default=0,
        ge=0,
        le=100_000,
    )
    header: Literal["auto", "row", "comment", "none"] = choice(
        "place of the names: row (first row), comment (last comment line before the data) or none; auto finds it",
        source=LOGGER,
        example="comment",
        default="auto",
    )
    sample_rate_Hz: Number | None = figure(
        "samples a second of a table without a column of times, each row one step later than the row before",
        source=LOGGER,
        example=100.0,
        default=None,
        gt=0.0,
        le=1e7,
    )
    broken_rows: Literal["refuse", "skip"] = choice(
        "rows of another length, with text or with NaN: refuse the file, or skip up to one row in fifty and report it; "
        "skip also leaves out rows that repeat the time of the row before",
        source=LOGGER,
        example="skip",
        default="refuse",
    )
    rows: Literal["full", "own_times"] = choice(
        "own_times: a row holds only some of the quantities, at their own times, and its other cells are empty; each "
        "is interpolated onto the times of the output",
        source=LOGGER,
        example="own_times",
        default="full",
    )
    channel_column: Text | Integer | None = choice(
        "column with the name of the channel whose figure is in the row; then give the channel of each quantity",
        source=LOGGER,
        example="topic",
        default=None,
    )
    published: tuple[Published, ...] | None = choice(
        "values printed in a paper, in place of data", source="paper", default=None, min_length=1, max_length=100
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
