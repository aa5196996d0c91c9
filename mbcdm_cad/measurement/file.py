"""A measurement file that fits its schema and the rules between its fields."""

from __future__ import annotations

import re
from dataclasses import dataclass, replace
from pathlib import Path

from pydantic import ValidationError

from mbcdm_cad.design import yamltree
from mbcdm_cad.design.fieldpath import FieldPath, dotted
from mbcdm_cad.design.problems import schema_problems
from mbcdm_cad.design.source import read_text
from mbcdm_cad.errors import InputError, Problem, did_you_mean, shortened
from mbcdm_cad.measurement.logformat import (
    ANGLE,
    COUNTS,
    ENCODERS,
    FORCE,
    GIVE,
    LENGTH,
    LOAD,
    RATIO,
    TORQUE,
    kind_of,
    known_units,
    unit_of,
)
from mbcdm_cad.measurement.schema import (
    BY_HAND,
    CURRENT,
    FREQUENCY_RESPONSE,
    MOTION,
    TABLE,
    TURNING_POINTS,
    Column,
    Columns,
    Measurement,
    ResponseBlock,
    is_column,
    node_at,
)

_KIND = ("measurement file", "; docs/measurement-file.md shows how one is written")


@dataclass(frozen=True)
class MeasurementFile:
    """A measurement file that fits its schema, and the lines of its fields."""

    path: Path
    content: Measurement
    tree: yamltree.Tree

    @property
    def asked(self) -> dict[str, Column]:
        """The columns given, in the order in which the table holds them."""
        return self.content.columns.given() if self.content.columns is not None else {}

    def problem(self, field: FieldPath, what: str, value: str = "", limit: str = "", *, remedy: str) -> Problem:
        """A problem with one field."""
        return Problem(str(self.path), self.tree.line_of(field), dotted(field), what, value, limit, remedy)


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
        content = Measurement.model_validate(tree.data)
    except ValidationError as error:
        said = {problem.field for problem in strange}
        found = [p for p in schema_problems(error, tree, str(path), node_at) if _top(p.field) not in said]
        raise InputError(sorted([*strange, *found], key=lambda problem: problem.line)) from None
    file = MeasurementFile(path, content, tree)
    problems = strange or _broken_rules(file)
    if problems:
        raise InputError(problems)
    return file


def with_ratio(file: MeasurementFile, ratio: float | None) -> MeasurementFile:
    """The file of a drive of which only ``ratio`` is known; the file itself for None. Raises InputError."""
    if ratio is None or file.content.published is not None or file.content.ratio == ratio:
        return file
    if file.content.ratio is not None:
        value, remedy = f"{file.content.ratio:g}", "keep one of the two"
        raise InputError([file.problem(("ratio",), "another ratio than --ratio", value, f"{ratio:g}", remedy=remedy)])
    found = replace(file, content=file.content.model_copy(update={"ratio": ratio}))
    if problems := _broken_rules(found):
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
    strange = [key for key in columns if not is_column(str(key))] if isinstance(columns, dict) else []
    known = [*Columns.model_fields, "input_<name of an input of the design>"]
    missing = []
    if isinstance(columns, dict) and not {"output", "frequency"} & set(columns):
        remedy = "add it, for example output: {column: q_out, unit: rad}; or frequency, of an analyser's table"
        where: FieldPath = ("columns", "output")
        missing = [Problem(str(path), tree.line_of(where), dotted(where), "missing", remedy=remedy)]
    return missing + [
        Problem(
            str(path),
            tree.line_of(("columns", key)),
            dotted(("columns", key)),
            "unknown field",
            remedy=did_you_mean(str(key), known),
        )
        for key in strange
    ]


def _top(field: str) -> str:
    """The column that a field is of."""
    return ".".join(field.split(".")[:2])


def _broken_rules(file: MeasurementFile) -> list[Problem]:
    """Problems that concern several fields together."""
    content = file.content
    if content.published is not None:
        extra = [key for key in ("data", "columns", "ratio") if getattr(content, key) is not None]
        remedy = "keep one of the two: a run, or published figures"
        problems = [file.problem((key,), "given beside published", remedy=remedy) for key in extra]
        for index, item in enumerate(content.published):
            if unit_of(item.quantity, item.unit) is None:
                remedy = did_you_mean(item.unit, known_units(item.quantity))
                what = f"no unit of {item.quantity}"
                problems.append(file.problem(("published", index, "unit"), what, shortened(item.unit), remedy=remedy))
        return problems
    problems = [
        file.problem((key,), "missing", remedy=f"add {key}, or published for figures of a paper")
        for key in ("data", "columns")
        if getattr(content, key) is None
    ]
    if content.columns is None:
        return problems
    asked = file.asked
    if "frequency" in asked:
        return [*problems, *_broken_table(file, asked), *_broken_columns(file, asked)]
    if content.load is not None and LOAD in asked:
        remedy = "keep one of the two: the measured torque, or what is known of the load"
        told = content.load if isinstance(content.load, str) else "pendulum"
        problems.append(file.problem(("load",), f"given beside columns.{LOAD}", told, remedy=remedy))
    problems += [*_broken_times(file), *_broken_currents(file, asked), *_of_another_kind(file)]
    named = [key for key in asked if key.startswith("input_")]
    remedy = "give input for a drive that has one, else input_<name> for each input of the design, or left and right"
    if "input" in asked and named:
        problems.append(file.problem(("columns", "input"), f"given beside {named[0]}", remedy=remedy))
    elif "input" not in asked and not named and content.kind in BY_HAND:
        pass  # the inputs stand still
    elif "input" not in asked and (not named or named in (["input_left"], ["input_right"])):
        problems.append(file.problem(("columns",), "an input is missing", remedy=remedy))
    return [*problems, *_broken_columns(file, asked)]


def _broken_columns(file: MeasurementFile, asked: dict[str, Column]) -> list[Problem]:
    """Problems with the fields of each column."""
    content, problems = file.content, list[Problem]()
    for quantity, column in asked.items():
        where: FieldPath = ("columns", quantity)
        if column.side == "motor" and kind_of(quantity) != "input":
            remedy = "leave side out: only an input's encoder can sit before a gearhead"
            problems.append(file.problem((*where, "side"), f"given for {quantity}", "motor", "drive", remedy=remedy))
        elif column.side == "motor" and content.ratio is not None:
            remedy = "leave side out, and give the ratio from the encoder to the output"
            problems.append(file.problem((*where, "side"), "given beside ratio", "motor", "drive", remedy=remedy))
        if column.wraps_at is not None and kind_of(quantity) not in (*ENCODERS, "time"):
            remedy = "leave wraps_at out: only an angle or a time begins again"
            value = f"{column.wraps_at:g}"
            problems.append(file.problem((*where, "wraps_at"), f"given for {quantity}", value, remedy=remedy))
        problems += _broken_arm(file, quantity, column)
        if _arm(quantity, column):
            continue
        if unit_of(quantity, column.unit, column.counts_per_turn) is None:
            counts = column.unit.strip() in (COUNTS, "count") and kind_of(quantity) in ENCODERS
            remedy = "give counts_per_turn too" if counts else did_you_mean(column.unit, known_units(quantity))
            what = "counts without counts_per_turn" if counts else f"no unit of {quantity}"
            problems.append(file.problem((*where, "unit"), what, shortened(column.unit), remedy=remedy))
        elif column.counts_per_turn is not None and column.unit.strip() not in (COUNTS, "count"):
            remedy = "set unit: counts if the figures are counts, else leave counts_per_turn out"
            what = "given beside another unit"
            problems.append(file.problem((*where, "counts_per_turn"), what, column.unit, COUNTS, remedy=remedy))
        if column.scale == 0.0:
            problems.append(file.problem((*where, "scale"), "nothing is left", "0", remedy="give the factor"))
        if isinstance(column.column, int) and column.column < 1:
            remedy = "count the columns from 1"
            problems.append(
                file.problem((*where, "column"), "no column", str(column.column), "1 or more", remedy=remedy)
            )
    return problems + _asked_twice(file, asked)


def _of_another_kind(file: MeasurementFile) -> list[Problem]:
    """Problems with fields that have no effect on a log of this kind."""
    content = file.content
    given: list[FieldPath] = [("columns", key) for key in ("excitation", *TABLE) if key in file.asked]
    given += [(key,) for key in ("inertia_plate", "response") if getattr(content, key) is not None]
    of_logs: list[FieldPath] = (
        [("inertia_plate",), ("columns", "excitation")] if content.kind == FREQUENCY_RESPONSE else []
    )
    remedies = {
        True: "give columns.frequency of an analyser's table; else leave it out",
        False: f"say kind: {FREQUENCY_RESPONSE} of a chirp, noise or an analyser's table; else leave it out",
    }
    remedy = remedies[content.kind == FREQUENCY_RESPONSE]
    what = f"has no effect on a run of kind {content.kind}" + " that is a log" * (content.kind == FREQUENCY_RESPONSE)
    return [file.problem(where, what, remedy=remedy) for where in given if where not in of_logs]


def _broken_table(file: MeasurementFile, asked: dict[str, Column]) -> list[Problem]:
    """Problems with an analyser's table: fields that a log has in place of it, and what its gain is over."""
    content, problems = file.content, list[Problem]()
    if content.kind != FREQUENCY_RESPONSE:
        remedy = f"say kind: {FREQUENCY_RESPONSE}"
        problems.append(
            file.problem(("kind",), "a table over frequency is of another kind", content.kind, remedy=remedy)
        )
    for key in ("gain", "phase"):
        if key not in asked:
            remedy = f"give its column: a table of an analyser has frequency, {key} and more"
            problems.append(file.problem(("columns", key), "missing", remedy=remedy))
    other: list[FieldPath] = [("columns", key) for key in asked if key not in TABLE]
    stated = content.model_fields_set & {"load", "motor", "sample_rate_Hz", "rows", "channel_column"}
    remedy = "keep one of the two: a table over frequency, or a log over time"
    for where in [*other, *((key,) for key in sorted(stated))]:
        problems.append(file.problem(where, "given beside columns.frequency", remedy=remedy))
    block = content.response or ResponseBlock.model_construct()
    over_torque = block.over == "torque"
    if over_torque and content.ratio is not None:
        remedy = "give the design file: of a ratio alone nothing says what the torque turns"
        problems.append(
            file.problem(("response", "over"), "torque, of a drive whose ratio alone is known", remedy=remedy)
        )
    wrong = ("amplitude_rad", "turns") if over_torque else ("amplitude_Nm",)
    problems += [
        file.problem(("response", key), f"given beside over: {block.over}", remedy="leave it out, or correct over")
        for key in wrong
        if getattr(block, key) is not None
    ]
    kinds = {"gain": RATIO if over_torque else GIVE, "amplitude": ANGLE if over_torque else TORQUE}
    for key, units in kinds.items():
        if key in asked and asked[key].unit.strip() in units:
            remedy = "correct it, or response.over: inputs or torque"
            what = f"not of a gain over {block.over}"
            problems.append(file.problem(("columns", key, "unit"), what, asked[key].unit, remedy=remedy))
    given = [key for key in ("amplitude_rad", "amplitude_Nm") if getattr(block, key) is not None]
    if given and "amplitude" in asked:
        remedy = "keep one of the two"
        problems.append(file.problem(("response", given[0]), "given beside columns.amplitude", remedy=remedy))
    return problems


def _broken_currents(file: MeasurementFile, asked: dict[str, Column]) -> list[Problem]:
    """Problems with the motors' currents: one for each input, in place of a measured load or beside it."""
    currents = [key for key in asked if kind_of(key) == CURRENT]
    if not currents:
        return []
    first: FieldPath = ("columns", currents[0])
    problems = []
    if file.content.load == "none":
        remedy = "keep one of the two; beside the currents a load of a weight on an arm may be stated, pendulum"
        problems.append(file.problem(first, "given beside load: none", remedy=remedy))
    if LOAD in asked and file.content.kind != MOTION:
        remedy = f"keep one of the two: only a run of kind {MOTION} compares them"
        problems.append(file.problem(first, f"given beside columns.{LOAD}", remedy=remedy))
    inputs = sorted(key.removeprefix("input").lstrip("_") for key in asked if kind_of(key) == "input")
    if inputs != sorted(key.removeprefix(CURRENT).lstrip("_") for key in currents):
        remedy = "give the current of each input's motor, current_<name> for input_<name>"
        problems.append(file.problem(first, "currents are not those of the inputs", ", ".join(currents), remedy=remedy))
    if file.content.ratio is not None:
        motor = file.content.motor
        needed = ("torque_constant_Nm_A", "gear_ratio", "efficiency", "rotor_inertia_kg_m2")
        missing = [name for name in needed if getattr(motor, name) is None]
        if missing:
            remedy = "give it in the block motor: no design says it"
            problems.append(file.problem(("motor",), f"lacks {', '.join(missing)}", remedy=remedy))
    return problems


def _broken_times(file: MeasurementFile) -> list[Problem]:
    """Problems with the time: a column of it, or the rate of the rows."""
    content, rate = file.content, ("sample_rate_Hz",)
    if content.columns is None:
        return []
    if content.columns.time is None and content.sample_rate_Hz is None:
        if content.kind == TURNING_POINTS:
            return []  # the rows count
        remedy = "give its column, or sample_rate_Hz for rows at an even rate"
        return [file.problem(("columns", "time"), "missing", remedy=remedy)]
    if content.sample_rate_Hz is None:
        return []
    if content.columns.time is not None:
        remedy = "keep one of the two: columns.time where there is one"
        return [file.problem(rate, "given beside columns.time", remedy=remedy)]
    if content.broken_rows == "skip" or content.rows == "own_times" or content.channel_column is not None:
        remedy = "leave broken_rows, rows and channel_column out: every row is one step in time"
        return [file.problem(rate, "given where rows are no steps in time", remedy=remedy)]
    return []


# The fields for what a length or a force is measured at, with their remedies.
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


def _arm(quantity: str, column: Column) -> str:
    """The field that the unit of the column needs: the arm of a force, the radius of a length; empty for neither."""
    unit = column.unit.strip()
    if quantity == LOAD and unit in FORCE:
        return "lever_arm_mm"
    return "radius_mm" if kind_of(quantity) in ENCODERS and unit in LENGTH else ""


def _broken_arm(file: MeasurementFile, quantity: str, column: Column) -> list[Problem]:
    """Problems with the arm of a force and the radius of a length: other quantities have none."""
    where: FieldPath = ("columns", quantity)
    needed, problems = _arm(quantity, column), []
    for name, (missing, give, leave) in _ARMS.items():
        value = getattr(column, name)
        if name == needed and value is None:
            problems.append(file.problem((*where, "unit"), missing, column.unit, remedy=give))
        elif name != needed and value is not None:
            what = f"given beside unit {column.unit}"
            problems.append(file.problem((*where, name), what, f"{value:g}", remedy=leave))
    return problems


def _asked_twice(file: MeasurementFile, asked: dict[str, Column]) -> list[Problem]:
    """Problems with a column used for two quantities; for two inputs only a note, as one alone may be logged."""
    problems, first = [], dict[tuple[str | int, str | None], str]()
    for quantity, column in asked.items():
        other = first.setdefault((column.column, column.channel), quantity)
        if other != quantity and not (other.startswith("input") and quantity.startswith("input")):
            where: FieldPath = ("columns", quantity, "column")
            what, remedy = f"the column of {other} too", "give each quantity its own column"
            problems.append(file.problem(where, what, shortened(column.column), remedy=remedy))
    return problems
