"""Mutations of the parsed design (deleted, renamed, replaced fields): always a drive or an InputError."""

import copy
import datetime
from typing import Any

import yaml
from hypothesis import HealthCheck, given, settings
from hypothesis import strategies as st

from mbcdm_cad.design.drive import Drive
from mbcdm_cad.errors import InputError
from mbcdm_cad.layouts.loader import load_text, reference_data

BIG = "x" * 3000
EXTREME = st.sampled_from(
    [
        0,
        -1,
        1,
        0.0,
        -0.0,
        1e-300,
        1e15,
        1e16,
        -1e300,
        10**30,
        -(10**400),
        float("inf"),
        float("nan"),
        True,
        False,
        None,
        "",
        " ",
        "nan",
        "1e3",
        "34.6 mm",
        "0x10",
        "../..",
        "/etc/passwd",
        "a\nb",
        "\u202e",
        BIG,
        b"\x00\xff",
        [],
        {},
        [[]],
        [{}],
        {"a": {"b": {"c": 1}}},
        [None] * 100,
        datetime.date(2020, 1, 1),
        "left",
        "-x",
        "+x",
        "miso_bevel",
        "steel",
        "618/8",
    ]
).map(copy.deepcopy)
VALUES = EXTREME | st.floats() | st.integers() | st.text(max_size=30)


def paths(data: Any, path: tuple[str | int, ...] = ()) -> list[tuple[str | int, ...]]:
    """Paths of all values in a tree, blocks and lists too."""
    found = [path] if path else []
    children = data.items() if isinstance(data, dict) else enumerate(data) if isinstance(data, list) else ()
    for key, value in children:
        found += paths(value, (*path, key))
    return found


@st.composite
def mutated_designs(draw: st.DrawFn) -> Any:
    data: Any = copy.deepcopy(reference_data())
    for _ in range(draw(st.integers(1, 4))):
        if not (choices := paths(data)):
            break
        *parents, last = draw(st.sampled_from(choices))
        block = data
        for part in parents:
            block = block[part]
        action = draw(st.sampled_from(["replace", "replace", "scale", "delete", "rename", "copy"]))
        if action == "delete":
            del block[last]
        elif action == "rename" and isinstance(block, dict):
            block[draw(st.text(max_size=12) | st.just(f"{last}s") | st.just(f"{last}"[:-1]))] = block.pop(last)
        elif action == "copy" and isinstance(block, list):
            block.append(copy.deepcopy(block[last]))
        elif action == "scale" and isinstance(block[last], float):
            block[last] *= draw(st.floats(0.1, 10.0))
        else:
            block[last] = draw(VALUES)
    return data


@settings(max_examples=120, deadline=None, suppress_health_check=[HealthCheck.too_slow])
@given(mutated_designs())
def test_any_structure_gives_a_drive_or_a_sentence(data: Any) -> None:
    text = yaml.dump(data, Dumper=yaml.CSafeDumper, sort_keys=False)
    lines = text.count("\n") + 1
    try:
        drive = load_text(text, "f.yaml").drive
    except InputError as error:
        for problem in error.problems:
            assert problem.file == "f.yaml" and 1 <= problem.line <= lines, problem
            assert problem.what and problem.remedy and len(str(problem)) < 900, problem
            assert str(problem).isprintable(), problem
        return
    assert isinstance(drive, Drive) and len(drive.cables) == 4
    assert all(c.input_radius_mm > 0 and c.guide_radius_mm > 0 and c.preload_N > 0 for c in drive.cables), drive.cables
