"""The YAML reader: lines, bounds, and refused content."""

from __future__ import annotations

import time
from pathlib import Path

import pytest
import yaml

from mbcdm_cad.design import yamltree
from mbcdm_cad.errors import InputError

PARAMS = Path(__file__).parents[3] / "params" / "mbcdm.yaml"


def refusal(text: str) -> str:
    with pytest.raises(InputError) as caught:
        yamltree.parse(text, "f.yaml")
    return str(caught.value)


def test_every_field_of_the_real_file_has_the_line_it_stands_on() -> None:
    text = PARAMS.read_text("utf-8")
    tree = yamltree.parse(text, "f.yaml")
    lines = text.split("\n")
    for path, line in tree.lines.items():
        if isinstance(path[-1], str):
            assert f"{path[-1]}:" in lines[line - 1], f"{path} is said to be on line {line}: {lines[line - 1]!r}"


def test_values_agree_with_a_full_yaml_reader_on_the_real_file() -> None:
    text = PARAMS.read_text("utf-8")
    assert yamltree.parse(text, "f.yaml").data == yaml.safe_load(text)


def test_the_pure_python_parser_gives_the_same_tree_as_the_compiled_one(monkeypatch: pytest.MonkeyPatch) -> None:
    text = PARAMS.read_text("utf-8") + "\nextra: {a: \"1\", b: '2', c: 3, d: [x, ~, true, |\n  ]}\n".replace(
        "|\n  ", "-1.5"
    )
    compiled = yamltree.parse(text, "f.yaml")
    monkeypatch.setattr(yamltree, "_LOADER", yaml.SafeLoader)
    assert yamltree.parse(text, "f.yaml") == compiled


def test_line_of_a_field_not_given_is_that_of_the_block_above() -> None:
    tree = yamltree.parse("a:\n  b:\n    c: 1\n", "f.yaml")
    assert tree.line_of(("a", "b", "missing", 3)) == 2
    assert tree.line_of(("other",)) == 1


@pytest.mark.parametrize(
    ("text", "value"),
    [
        ("12", 12),
        ("-3.5", -3.5),
        ("1e3", 1000.0),
        (".5", 0.5),
        ("0", 0),
        ("+7", 7),
        ("true", True),
        ("False", False),
        ("yes", "yes"),
        ("no", "no"),
        ("on", "on"),
        ("'12'", "12"),
        ('"1.5"', "1.5"),
        ("~", None),
        ("2020-01-01", "2020-01-01"),
        ("618/8", "618/8"),
        ("7x7", "7x7"),
        ("-x", "-x"),
        ("1.2.3", "1.2.3"),
        ("inf", "inf"),
    ],
)
def test_scalars(text: str, value: object) -> None:
    read = yamltree.parse(f"a: {text}", "f.yaml").data["a"]
    assert read == value and type(read) is type(value), f"{text} was read as {read!r}"


@pytest.mark.parametrize("text", ["010", "0o17", "0x1F", "0b11", "1:30", "190:20:30.15", "1_000", "1_0.5", "007.5"])
def test_numbers_that_can_be_read_in_two_ways_are_refused(text: str) -> None:
    assert "f.yaml:2: b: a number that can be read in two ways" in refusal(f"a: 1\nb: {text}\n")


@pytest.mark.parametrize(
    "text", [".nan", ".NaN", ".inf", "-.INF", "1e400", "-1e16", "9" * 5000, "1" * 41, "1e99999999999"]
)
def test_numbers_that_are_not_finite_or_out_of_bounds_are_refused(text: str) -> None:
    message = refusal(f"a: 1\nb: {text}\n")
    assert message.startswith("f.yaml:2: "), message
    assert len(message) < 300, f"a message of {len(message)} characters"


@pytest.mark.parametrize(
    ("text", "line", "what"),
    [
        ("", 1, "the design file is empty"),
        ("# only a comment\n", 1, "the design file is empty"),
        ("---\n", 1, "the design file is empty"),
        ("a: 1\n---\nb: 2\n", 2, "a second document"),
        ("a: 1\nb: 2\na: 3\n", 3, "a: given twice (value first on line 1)"),
        ("a:\n  b: 1\n  b: 2\n", 3, "a.b: given twice"),
        ("a: [1, 2\nb: 3\n", 2, "not valid YAML"),
        ("a: 1\n\tb: 2\n", 2, "not valid YAML"),
        ("a: 'x\n\n", 3, "not valid YAML"),
        ("a: !!python/object/apply:os.system [ls]\n", 1, "tags are not part of design files"),
        ("a: 1\nb: !!python/name:os.system\n", 2, "tags are not part"),
        ("a: !!float 3\n", 1, "tags are not part"),
        ("a: ! x\n", 1, "tags are not part"),
        ("a: !!binary aGk=\n", 1, "tags are not part"),
        ("a: &x 1\nb:\n  <<: {c: 1}\n", 3, "merge keys"),
        ("a: *x\n", 1, "refers to no finished anchor"),
        ("a: &x [1, *x]\n", 1, "refers to no finished anchor"),
        ("? [1, 2]\n: 3\n", 1, "used as a key"),
        ("x: &k 1\n? *k\n: 3\n", 2, "an alias used as a key"),
        ("a: 1\nb: \x00\n", 2, "a character that YAML does not allow (value U+0000)"),
        ("a: 1\nb: \x1b[31m\n", 2, "value U+001B"),
        ("a: " + "x" * 3000, 1, "a text too long"),
        ("%YAML 3.0\n---\na: 1\n", 1, "not valid YAML"),
    ],
)
def test_what_is_refused_and_where(text: str, line: int, what: str) -> None:
    message = refusal(text)
    assert message.startswith(f"f.yaml:{line}: ") and what in message, message


def test_aliases_stand_for_what_they_name_and_keep_the_line_of_their_use() -> None:
    tree = yamltree.parse("a: &x {b: 1}\nc: *x\n", "f.yaml")
    assert tree.data == {"a": {"b": 1}, "c": {"b": 1}}
    assert tree.line_of(("c", "b")) == 2


def bomb(levels: int) -> str:
    lines = ["a0: &a0 [x, x, x, x, x, x, x, x, x, x]"]
    lines += [f"a{k}: &a{k} [{', '.join([f'*a{k - 1}'] * 10)}]" for k in range(1, levels)]
    return "\n".join(lines)


@pytest.mark.parametrize(
    ("name", "text"),
    [
        ("aliases, 10^9 values", bomb(9)),
        ("aliases, 10^400 values", bomb(400)),
        ("brackets", "[" * 500_000),
        ("braces", "{a: " * 200_000),
        ("indentation", "\n".join(" " * k + "a:" for k in range(1200))),
        ("long list", "[" + "1, " * 300_000 + "1]"),
        ("many keys", "\n".join(f"k{i}: 1" for i in range(90_000))),
        ("one long text", "a: '" + "x" * 1_000_000 + "'"),
        ("one long comment", "#" * 1_000_000),
        ("many comments", "#\n" * 500_000),
        ("question marks", "? " * 400_000),
        ("dashes", "- " * 400_000),
        ("anchors", " ".join(f"&a{k}" for k in range(100_000))),
    ],
)
def test_bombs_are_refused_before_they_cost_much(name: str, text: str) -> None:
    start = time.process_time()
    message = refusal(text)
    took = time.process_time() - start
    assert took < 10.0, f"{name}: {took:.2f} s of processor time"
    assert len(message) < 400, f"{name}: a message of {len(message)} characters"
