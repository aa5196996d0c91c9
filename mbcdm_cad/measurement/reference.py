"""The reference page of the measurement file in Markdown, written from its schema and the table of units."""

from __future__ import annotations

from collections.abc import Iterator

from mbcdm_cad.design.describe import Node, flow, limit_text
from mbcdm_cad.measurement.datafile import MOST_BROKEN
from mbcdm_cad.measurement.kinds import FEWEST_SAMPLES, FEWEST_STEPS
from mbcdm_cad.measurement.logformat import known_units
from mbcdm_cad.measurement.schema import json_schema

_INTRO = f"""\
# The measurement file

Written by `mbcdm schema --measurement --reference` from the schema; do not edit by hand. `mbcdm schema --measurement`
gives the JSON Schema for completion in an editor.

The measurement file is a small YAML file beside a logger's data. It says what each column contains, so the data file
stays as the logger wrote it. `mbcdm measurement-init` drafts it.

```yaml
data: run.csv                 # path relative to this file
columns:
  time:        {{column: t,       unit: s}}
  input_left:  {{column: q_left,  unit: rad}}
  input_right: {{column: q_right, unit: rad}}
  output:      {{column: q_out,   unit: rad}}
  load_torque: {{column: tau,     unit: N*m}}   # optional; > 0 opposes positive rotation of the drum
sensors:                                      # optional; the noise floor follows from them
  input_resolution_rad: 1.9175e-4
  output_resolution_rad: 1.3635e-6
```

The next example describes a logger whose last comment line has the names of the columns. The encoders are in counts,
one of them has the opposite sign, the torque sensor shows a value at zero load, and some rows are incomplete.

```yaml
data: log.txt
comment: "%"
header: comment
broken_rows: skip
columns:
  time:        {{column: 1, unit: s}}
  input:       {{column: 9, unit: counts, counts_per_turn: 4096, scale: -1}}
  output:      {{column: 2, unit: counts, counts_per_turn: 8192}}
  load_torque: {{column: 3, unit: N*m, zero: 338.56, scale: -3.9811e-5}}
ratio: 35                     # only the ratio of this drive is known
```

A drive with one input has the column `input`. A drive with several inputs has a column `input_<name>` for each input,
with the name that the design file gives it. `input_left` and `input_right` always mean the inputs at -x and at +x,
whatever their names are.

Each number of a column becomes `(number - zero) * scale` in the column's unit. Inputs are positive when they drive the
drum positive.

Counters of the inputs may begin anywhere. If the inputs are so far apart that a cable would gain or lose half of its
preload, their zeros are taken from the run, as if the inputs agreed on average. If they lie far outside the travel,
zero is the middle of their range. Both are listed as facts of the run. Where the true zeros are known, give them as
`zero`: the run then also shows a difference that the servos hold.

The data file may have comments and blank lines anywhere, cells in quotes, and the line ends of any system. Bytes beyond
ASCII matter only in names. A row of units below the names is left out. Where this row, or brackets in a name, state
another unit than the measurement file, the loop reports a doubt.

A table without a column of times needs `sample_rate_Hz`. Rows as serial plotters take them, `motor:1.25,joint:0.16`,
with or without a time of day and an arrow before them, have the names before the colons. Counts in hexadecimal digits
are written with 0x: 0x0FF3.

Logs with a JSON object a line (`{{"ts": 0.01, "motor": {{"count": 2089}}}}`) are read too; names inside others are
divided by `/`: `motor/count`. Frames of a CAN bus are not: decode them with the bus's DBC file, to a row a figure
(time, name, figure), which `channel_column` reads. Where ROS writes the time in two columns, take the one of the rest:
`time: {{column: nanosec, unit: ns, wraps_at: 1000000000}}`.

Binary logs are read too, by the libraries of `pip install 'mbcdm-cad[logs]'`: MCAP (messages in JSON or of ROS), bags
of ROS 1 and 2 (a bag of ROS 2 is a folder), Parquet, files of MATLAB, TDMS and HDF5. Their columns have names such as
`/joint_states/elbow/position`, `bench/motor_pos`, `angles/motor`; `mbcdm measurement-init` lists them. Logs of messages
have two columns more for the time: `header_stamp`, which the messages carry, and `log_time`, when they were recorded.
Every quantity is then interpolated from its own times onto those of the output.

A length is an angle with its radius: `output: {{column: gauge_mm, unit: mm, radius_mm: 80}}`.

The following is refused, with file, line and remedy:

- a spreadsheet, or another file that is neither text nor one of these logs; an unknown unit;
- a column that does not exist, exists twice, or is used for two quantities;
- in a cell that is used: text, NaN, a date, or an overload (9.9e37); decimal commas that are not declared;
- a row of another length;
- time that runs backwards or stands still, fewer than {FEWEST_SAMPLES} samples;
- single numbers far from all others;
- an input or output that turns by less than {FEWEST_STEPS} of its encoder's steps.

With `broken_rows: skip` broken rows are left out and counted. More than {MOST_BROKEN:.0%} of them means that the
format is another one, and the file is refused.
"""


def measurement_page() -> str:
    """The whole page."""
    schema = json_schema()
    blocks = schema["properties"]
    columns, load, item = blocks["columns"], blocks["load"]["properties"]["pendulum"], blocks["published"]["items"]
    said = {name: node["description"].capitalize() for name, node in blocks.items() if "description" in node}
    top = {name: node for name, node in blocks.items() if "properties" not in node and name != "published"}
    lines = [_INTRO, "## Top level", "", *_table(schema | {"properties": top})]
    lines += ["## columns", "", "| quantity | needed | meaning |", "| --- | --- | --- |"]
    for key, node in columns["properties"].items():
        needed = "yes" if key in ("time", "output") else "one for each input" if key.startswith("input") else "no"
        lines.append(f"| `{key}` | {needed} | {node.get('description', '')} |")
    lines += ["", "Each is a block of these fields:", "", *_table(columns["properties"]["time"]), "### Units", ""]
    kinds = {"time": "time", "angles": "output", "torque": "load_torque"}
    kinds |= {word: word for word in ("temperature", "current", "excitation", "frequency", "gain", "amplitude")}
    lines += [*_units(kinds), "## sensors", ""]
    lines += _table(blocks["sensors"])
    lines += ["## parts", "", f"{said['parts']}.", "", *_table(blocks["parts"])]
    lines += ["## load", "", "`load: none`, or `load: {pendulum: {...}}` with", "", *_table(load)]
    for name in ("inertia_plate", "response"):
        lines += [f"## {name}", "", f"{said[name]}.", "", *_table(blocks[name])]
    lines += ["## motor", "", f"{said['motor']}; columns `current` or "]
    lines[-1] += (
        "`current_<name>`, positive where they drive the drum positive. What is left out is that of the design."
    )
    lines += ["", *_table(blocks["motor"]), "## published", "", f"{said['published']}: a list of", ""]
    plain = {key: node for key, node in item["properties"].items() if key != "conditions"}
    lines += [*_table(item | {"properties": plain}), "### conditions", "", *_table(item["properties"]["conditions"])]
    lines += ["### Units of published figures", ""]
    lines += _units({f"`{quantity}`": quantity for quantity in item["properties"]["quantity"]["enum"]})
    return "\n".join(lines).rstrip() + "\n"


def _units(quantities: dict[str, str]) -> list[str]:
    """A list of the units of each quantity, and an empty line."""
    known = ((word, (f"`{unit}`" for unit in known_units(quantity))) for word, quantity in quantities.items())
    return [*(f"- {word}: {', '.join(units)}" for word, units in known), ""]


def _table(block: Node) -> Iterator[str]:
    yield "| field | unit | limits | default | example | meaning |"
    yield "| --- | --- | --- | --- | --- | --- |"
    for key, node in block["properties"].items():
        given = node.get("default")
        default = "needed" if key in block.get("required", []) else "" if given is None else f"`{flow(given)}`"
        example = f"`{flow(node['examples'][0])}`" if node.get("examples") else ""
        cells = (f"`{key}`", node.get("unit", "-"), limit_text(node), default, example, node.get("description", ""))
        yield "| " + " | ".join(" ".join(str(cell).split()).replace("|", "\\|") for cell in cells) + " |"
    yield ""
