"""A measurement file that fits its schema and the rules between its fields."""

import re
from collections.abc import Iterable, Iterator
from dataclasses import dataclass, replace
from pathlib import Path

from pydantic import ValidationError

from mbcdm_cad.design import yamltree
from mbcdm_cad.design.problems import schema_problems
from mbcdm_cad.design.yamltree import FieldPath, dotted, read_text
from mbcdm_cad.errors import InputError, Problem, did_you_mean, shortened
from mbcdm_cad.measurement import logformat, schema

_KIND = ("measurement file", "; docs/measurement-file.md shows how one is written")


# A broken rule between fields: the field, what is wrong, the remedy, then value and limit if there are.
Broken = tuple[FieldPath, str, str, *tuple[str, ...]]


@dataclass(frozen=True)
class MeasurementFile:
    """A measurement file that fits its schema, and the lines of its fields."""

    path: Path
    content: schema.Measurement
    tree: yamltree.Tree

    @property
    def asked(self) -> dict[str, schema.Column]:
        """The columns given, in the order in which the table holds them."""
        return self.content.columns.given() if self.content.columns is not None else {}

    def problem(self, field: FieldPath, what: str, value: str = "", limit: str = "", *, remedy: str) -> Problem:
        """A problem with one field."""
        return Problem(str(self.path), self.tree.line_of(field), dotted(field), what, value, limit, remedy)

    def refusal(self, field: FieldPath, what: str, value: str = "", limit: str = "", *, remedy: str) -> InputError:
        """The error of one problem with one field."""
        return InputError([self.problem(field, what, value, limit, remedy=remedy)])

    def problems(self, broken: Iterable[Broken]) -> list[Problem]:
        """The problems of broken rules."""
        return [self.problem(where, what, *more, remedy=remedy) for where, what, remedy, *more in broken]


def load_file(path: str | Path) -> MeasurementFile:
    """The measurement file without its data. Raises InputError."""
    return file_of(Path(path), read_text(Path(path), *_KIND))


def file_of(path: Path, text: str) -> MeasurementFile:
    """The measurement file of a text that is, or will be, at ``path``. Raises InputError."""
    if not _has_fields(text):
        remedy = "give the YAML file that says which column of the data is what" + _KIND[1]
        raise InputError([Problem(str(path), 1, "", "no measurement file: it has no fields", remedy=remedy)])
    tree = yamltree.parse(text, str(path), *_KIND)
    strange = _strange_columns(path, tree)
    try:
        content = schema.Measurement.model_validate(tree.data)
    except ValidationError as error:
        said = {problem.field for problem in strange}
        found = schema_problems(error, tree, str(path), schema.node_at)
        # What is said of a strange column is not said again of each of its fields.
        found = [problem for problem in found if ".".join(problem.field.split(".")[:2]) not in said]
        raise InputError(sorted([*strange, *found], key=lambda problem: problem.line)) from None
    file = MeasurementFile(path, content, tree)
    problems = strange or file.problems(_broken_rules(file))
    if problems:
        raise InputError(problems)
    return file


def with_ratio(file: MeasurementFile, ratio: float | None) -> MeasurementFile:
    """The file of a drive of which only ``ratio`` is known; the file itself for None. Raises InputError."""
    if ratio is None or file.content.published is not None or file.content.ratio == ratio:
        return file
    if file.content.ratio is not None:
        value, remedy = f"{file.content.ratio:g}", "keep one of the two"
        raise file.refusal(("ratio",), "another ratio than --ratio", value, f"{ratio:g}", remedy=remedy)
    found = replace(file, content=file.content.model_copy(update={"ratio": ratio}))
    if problems := found.problems(_broken_rules(found)):
        raise InputError(problems)
    return found


def describes_runs(path: Path) -> bool:
    """Whether a file given in the place of a design has the fields of a measurement file or of a study."""
    try:
        return re.search(r"^(columns|runs|published):", read_text(path, *_KIND), re.MULTILINE) is not None
    except InputError:
        return False


def _has_fields(text: str) -> bool:
    """Whether the text has fields; False for a logger's file given in place of its measurement file."""
    signs = ("#", "%", "---")
    first = next((line for line in text.splitlines() if line.strip() and not line.lstrip().startswith(signs)), "")
    return ":" in first or first.lstrip().startswith("{") or not first


def _strange_columns(path: Path, tree: yamltree.Tree) -> list[Problem]:
    """Columns that are neither a quantity nor an input, and the one of the output where it is missing."""
    columns = tree.data.get("columns") if isinstance(tree.data, dict) else None
    if not isinstance(columns, dict):
        return []
    known = [*schema.Columns.model_fields, "input_<name of an input of the design>"]
    unknown = [key for key in columns if not schema.is_column(str(key))]
    found = [(("columns", key), "unknown field", did_you_mean(str(key), known)) for key in unknown]
    if not {"output", "frequency"} & set(columns):
        remedy = "add it, for example output: {column: q_out, unit: rad}; or frequency, of an analyser's table"
        found.insert(0, (("columns", "output"), "missing", remedy))
    return [Problem(str(path), tree.line_of(at), dotted(at), what, remedy=remedy) for at, what, remedy in found]


TWO = "keep one of the two"


def _broken_rules(file: MeasurementFile) -> Iterator[Broken]:
    """Rules that concern several fields together."""
    content, asked = file.content, file.asked
    if content.published is not None:
        for key in ("data", "columns", "ratio"):
            if getattr(content, key) is not None:
                yield (key,), "given beside published", f"{TWO}: a run, or published figures"
        for index, item in enumerate(content.published):
            if logformat.unit_of(item.quantity, item.unit) is None:
                remedy = did_you_mean(item.unit, logformat.known_units(item.quantity))
                yield ("published", index, "unit"), f"no unit of {item.quantity}", remedy, shortened(item.unit)
        return
    for key in ("data", "columns"):
        if getattr(content, key) is None:
            yield (key,), "missing", f"add {key}, or published for figures of a paper"
    if content.columns is not None:
        yield from (_of_table if "frequency" in asked else _of_log)(content, asked)
        yield from _of_columns(content, asked)


def _of_log(content: schema.Measurement, asked: dict[str, schema.Column]) -> Iterator[Broken]:
    """Of a log over time: its load, times, currents and inputs, and fields of other kinds."""
    if content.load is not None and logformat.LOAD in asked:
        told = content.load if isinstance(content.load, str) else "pendulum"
        remedy = f"{TWO}: the measured torque, or what is known of the load"
        yield ("load",), f"given beside columns.{logformat.LOAD}", remedy, told
    rate: FieldPath = ("sample_rate_Hz",)
    if content.sample_rate_Hz is None:
        if "time" not in asked and content.kind != schema.TURNING_POINTS:  # whose rows count
            yield ("columns", "time"), "missing", "give its column, or sample_rate_Hz for rows at an even rate"
    elif "time" in asked:
        yield rate, "given beside columns.time", f"{TWO}: columns.time where there is one"
    elif content.broken_rows == "skip" or content.rows == "own_times" or content.channel_column is not None:
        remedy = "leave broken_rows, rows and channel_column out: every row is one step in time"
        yield rate, "given where rows are no steps in time", remedy
    inputs, currents = ([key for key in asked if logformat.kind_of(key) == kind] for kind in ("input", schema.CURRENT))
    if currents:
        yield from _of_currents(content, asked, inputs, currents)
    response = content.kind == schema.FREQUENCY_RESPONSE
    given: list[FieldPath] = [("columns", key) for key in ("excitation", *schema.TABLE) if key in asked]
    given += [(key,) for key in ("inertia_plate", "response") if getattr(content, key) is not None]
    remedy = f"say kind: {schema.FREQUENCY_RESPONSE} of a chirp, noise or an analyser's table; else leave it out"
    remedy = "give columns.frequency of an analyser's table; else leave it out" if response else remedy
    for where in given:
        if not response or where not in (("inertia_plate",), ("columns", "excitation")):
            yield where, f"has no effect on a run of kind {content.kind}" + " that is a log" * response, remedy
    named = [key for key in inputs if key != "input"]
    remedy = "give input for a drive that has one, else input_<name> for each input of the design, or left and right"
    if "input" in asked and named:
        yield ("columns", "input"), f"given beside {named[0]}", remedy
    # Of rows by hand the inputs may stand still.
    elif named in (["input_left"], ["input_right"]) or not (inputs or content.kind in schema.BY_HAND):
        yield ("columns",), "an input is missing", remedy


def _of_currents(
    content: schema.Measurement, asked: dict[str, schema.Column], inputs: list[str], currents: list[str]
) -> Iterator[Broken]:
    """Of the motors' currents: one for each input, in place of a measured load or beside it."""
    first: FieldPath = ("columns", currents[0])
    if content.load == "none":
        remedy = f"{TWO}; beside the currents a load of a weight on an arm may be stated, pendulum"
        yield first, "given beside load: none", remedy
    if logformat.LOAD in asked and content.kind != schema.MOTION:
        remedy = f"{TWO}: only a run of kind {schema.MOTION} compares them"
        yield first, f"given beside columns.{logformat.LOAD}", remedy
    if sorted(inputs) != sorted(key.replace(schema.CURRENT, "input", 1) for key in currents):
        remedy = "give the current of each input's motor, current_<name> for input_<name>"
        yield first, "currents are not those of the inputs", remedy, ", ".join(currents)
    needed = ("torque_constant_Nm_A", "gear_ratio", "efficiency", "rotor_inertia_kg_m2")
    lacking = ", ".join(name for name in needed if getattr(content.motor, name) is None)
    if content.ratio is not None and lacking:
        yield ("motor",), f"lacks {lacking}", "give it in the block motor: no design says it"


def _of_table(content: schema.Measurement, asked: dict[str, schema.Column]) -> Iterator[Broken]:
    """Of an analyser's table: fields that a log has in place of it, and what its gain is over."""
    if content.kind != schema.FREQUENCY_RESPONSE:
        remedy = f"say kind: {schema.FREQUENCY_RESPONSE}"
        yield ("kind",), "a table over frequency is of another kind", remedy, content.kind
    for key in ("gain", "phase"):
        if key not in asked:
            remedy = f"give its column: a table of an analyser has frequency, {key} and more"
            yield ("columns", key), "missing", remedy
    stated = sorted(content.model_fields_set & {"load", "motor", "sample_rate_Hz", "rows", "channel_column"})
    of_logs: list[FieldPath] = [("columns", key) for key in asked if key not in schema.TABLE]
    for where in (*of_logs, *((key,) for key in stated)):
        yield where, "given beside columns.frequency", f"{TWO}: a table over frequency, or a log over time"
    block = content.response or schema.ResponseBlock.model_construct()
    torque = block.over == "torque"
    if torque and content.ratio is not None:
        remedy = "give the design file: of a ratio alone nothing says what the torque turns"
        yield ("response", "over"), "torque, of a drive whose ratio alone is known", remedy
    for key in ("amplitude_rad", "turns") if torque else ("amplitude_Nm",):
        if getattr(block, key) is not None:
            yield ("response", key), f"given beside over: {block.over}", "leave it out, or correct over"
    for key, units in (
        ("gain", logformat.RATIO if torque else logformat.GIVE),
        ("amplitude", logformat.ANGLE if torque else logformat.TORQUE),
    ):
        if key in asked and asked[key].unit.strip() in units:
            what, remedy = f"not of a gain over {block.over}", "correct it, or response.over: inputs or torque"
            yield ("columns", key, "unit"), what, remedy, asked[key].unit
    given = [key for key in ("amplitude_rad", "amplitude_Nm") if getattr(block, key) is not None]
    if given and "amplitude" in asked:
        yield ("response", given[0]), "given beside columns.amplitude", TWO


# The fields for what a length or a force is measured at: what lacks it, how to give it, and why to leave it out.
_ARMS = {
    "lever_arm_mm": (
        "a force without its arm",
        "give lever_arm_mm, the distance from the drum's axis to the line of the force",
        "leave it out, or set unit: N if the load cell shows a force",
    ),
    "radius_mm": (
        "a length without its radius",
        "give radius_mm, the distance from the axis to where the length is measured",
        "leave it out, or set unit: mm if the sensor shows a length",
    ),
}


def _of_columns(content: schema.Measurement, asked: dict[str, schema.Column]) -> Iterator[Broken]:
    """Of the fields of each column, and of a column used for two quantities."""
    for quantity, column in asked.items():
        where, unit, kind = ("columns", quantity), column.unit.strip(), logformat.kind_of(quantity)
        angle, counts, wraps_at = kind in logformat.ENCODERS, unit in (logformat.COUNTS, "count"), column.wraps_at
        if column.side == "motor" and (kind != "input" or content.ratio is not None):
            what, remedy = "given beside ratio", ", and give the ratio from the encoder to the output"
            if kind != "input":
                what, remedy = f"given for {quantity}", ": only an input's encoder can sit before a gearhead"
            yield (*where, "side"), what, f"leave side out{remedy}", "motor", "drive"
        if wraps_at is not None and not (angle or kind == "time"):
            remedy = "leave wraps_at out: only an angle or a time begins again"
            yield (*where, "wraps_at"), f"given for {quantity}", remedy, f"{wraps_at:g}"
        arm = "lever_arm_mm" if quantity == logformat.LOAD and unit in logformat.FORCE else ""
        arm = "radius_mm" if angle and unit in logformat.LENGTH else arm
        for name, (missing, give, leave) in _ARMS.items():
            value = getattr(column, name)
            if name == arm and value is None:
                yield (*where, "unit"), missing, give, column.unit
            elif name != arm and value is not None:
                yield (*where, name), f"given beside unit {column.unit}", leave, f"{value:g}"
        if arm:
            continue
        if logformat.unit_of(quantity, column.unit, column.counts_per_turn) is None:
            known = did_you_mean(column.unit, logformat.known_units(quantity))
            what = "counts without counts_per_turn" if counts and angle else f"no unit of {quantity}"
            remedy = "give counts_per_turn too" if counts and angle else known
            yield (*where, "unit"), what, remedy, shortened(column.unit)
        elif column.counts_per_turn is not None and not counts:
            remedy = "set unit: counts if the figures are counts, else leave counts_per_turn out"
            yield (*where, "counts_per_turn"), "given beside another unit", remedy, column.unit, logformat.COUNTS
        if column.scale == 0.0:
            yield (*where, "scale"), "nothing is left", "give the factor", "0"
        if isinstance(column.column, int) and column.column < 1:
            yield (*where, "column"), "no column", "count the columns from 1", str(column.column), "1 or more"
    first = dict[tuple[str | int, str | None], str]()
    for quantity, column in asked.items():
        other = first.setdefault((column.column, column.channel), quantity)
        # Two inputs of one column are only noted, as one alone may be logged.
        if other != quantity and not (other.startswith("input") and quantity.startswith("input")):
            remedy, what = "give each quantity its own column", f"the column of {other} too"
            yield ("columns", quantity, "column"), what, remedy, shortened(column.column)
