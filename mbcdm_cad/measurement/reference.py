"""The reference page of the measurement file in Markdown, written from its schema and the table of units."""

from __future__ import annotations

from collections.abc import Iterator

from mbcdm_cad.design.describe import Node, flow, limit_text
from mbcdm_cad.measurement.datafile import MOST_BROKEN
from mbcdm_cad.measurement.schema import json_schema
from mbcdm_cad.measurement.units import known_units
from mbcdm_cad.measurement.unusable import FEWEST_SAMPLES, FEWEST_STEPS

_INTRO = f"""\
# The measurement file

Written by `mbcdm schema --measurement --reference` from the schema; do not edit by hand. `mbcdm schema --measurement`
gives the JSON Schema for completion in an editor.

A small YAML file beside a logger's data. It says which column is what; the data stay as the logger wrote them.

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

A logger as it is: names in the last of its comment lines, encoders in counts, one of them the wrong way round, a
torque sensor with a tare, rows that broke off.

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

A drive with one input has `input`; one with more has a column `input_<name>` for each, by the names that the design
file gives its inputs. `input_left` and `input_right` may also stand for the inputs at -x and at +x, whatever they are
called.

A figure becomes `(figure - zero) * scale` in the column's unit. Inputs are positive when they drive the drum positive.
Rows are told from their file: comments and blank lines may stand anywhere, cells may be in quotes, line ends may be of
any system, bytes beyond ASCII matter only in names. Rows of units below the names are left out; where they, or
brackets in a name, say another unit than this file, that is told as a doubt.

Refused, with file, line and remedy: a file that is no text, a column that is not there or is there twice or serves for
two quantities, an unknown unit, a row of another length, text, NaN, a date or an overload (9.9e37) in a cell that is
used, decimal commas not declared, time that runs backwards or stands still, fewer than {FEWEST_SAMPLES} samples, single
figures far from all others, an input or output that turns by less than {FEWEST_STEPS} of its steps. With `broken_rows:
skip` broken rows are left out and counted; more than {MOST_BROKEN:.0%} of them is taken for another format and refused.
"""


def measurement_page() -> str:
    """The whole page."""
    schema = json_schema()
    columns = schema["properties"]["columns"]
    top = {key: node for key, node in schema["properties"].items() if "properties" not in node and key != "published"}
    lines = [_INTRO, "## Top level", "", *_table(top, schema)]
    lines += ["## columns", "", "| quantity | needed | meaning |", "| --- | --- | --- |"]
    for key, node in columns["properties"].items():
        needed = "yes" if key in columns["required"] else "one or two inputs" if key.startswith("input") else "no"
        lines.append(f"| `{key}` | {needed} | {node.get('description', '')} |")
    lines += ["", "Each is a block of these fields:", ""]
    lines += _table(columns["properties"]["time"]["properties"], columns["properties"]["time"])
    lines += ["### Units", ""]
    lines += [
        f"- {word}: " + ", ".join(f"`{unit}`" for unit in known_units(quantity))
        for word, quantity in (
            ("time", "time"),
            ("angles", "output"),
            ("torque", "load_torque"),
            ("temperature", "temperature"),
        )
    ]
    lines += ["", "## sensors", "", *_table(schema["properties"]["sensors"]["properties"], {})]
    published = schema["properties"]["published"]["items"]
    lines += ["## published", "", f"{schema['properties']['published']['description'].capitalize()}: a list of", ""]
    plain = {key: node for key, node in published["properties"].items() if key != "conditions"}
    lines += [*_table(plain, published), "### conditions", ""]
    lines += _table(published["properties"]["conditions"]["properties"], {})
    lines += ["### Units of published figures", ""]
    lines += [
        f"- `{quantity}`: " + ", ".join(f"`{unit}`" for unit in known_units(quantity))
        for quantity in published["properties"]["quantity"]["enum"]
    ]
    return "\n".join(lines).rstrip() + "\n"


def _table(rows: dict[str, Node], block: Node) -> Iterator[str]:
    yield "| field | unit | limits | default | example | meaning |"
    yield "| --- | --- | --- | --- | --- | --- |"
    for key, node in rows.items():
        given = node.get("default")
        default = "needed" if key in block.get("required", []) else "" if given is None else f"`{flow(given)}`"
        example = f"`{flow(node['examples'][0])}`" if node.get("examples") else ""
        cells = (f"`{key}`", node.get("unit", "-"), limit_text(node), default, example, node.get("description", ""))
        yield "| " + " | ".join(" ".join(str(cell).split()).replace("|", "\\|") for cell in cells) + " |"
    yield ""
