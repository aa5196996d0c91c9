"""Mutated logger files and measurement files: always a run that can be vetted, or an InputError with a remedy."""

from __future__ import annotations

import random
import warnings
from collections.abc import Callable
from functools import cache
from pathlib import Path
from typing import TypeVar

import numpy as np
import pytest
from hypothesis import HealthCheck, given, settings
from hypothesis import strategies as st

from mbcdm_cad.design.drive import Drive
from mbcdm_cad.errors import InputError
from mbcdm_cad.layouts.loader import load_design
from mbcdm_cad.measurement.file import load_file
from mbcdm_cad.measurement.kinds import FEWEST_SAMPLES
from mbcdm_cad.measurement.reading import load_measurement
from mbcdm_cad.measurement.vet import vet
from tests.support.mutants import mutate

PAPER = Path(__file__).parents[2] / "params" / "measurements" / "paper.yaml"
MAPPING = """\
data: run.csv
columns:
  time: {column: t, unit: ms}
  input_left: {column: q_left, unit: counts, counts_per_turn: 32768}
  input_right: {column: 3, unit: deg, scale: -1, zero: 2}
  output: {column: q_out, unit: rad}
  load_torque: {column: "tau Nm", unit: N*m}
sensors: {input_resolution_rad: 1.9175e-4, torque_noise_Nm: 0.005}
delimiter: comma
comment: "%"
skip_rows: 1
header: row
broken_rows: refuse
"""
SPICE = [
    b",",
    b";",
    b"\t",
    b" ",
    b"\n",
    b"\r",
    b"\r\n",
    b"\n\n",
    b"%",
    b"#",
    b'"',
    b"'",
    b"nan",
    b"inf",
    b"-inf",
    b"1e999",
    b"NULL",
    b"\x00",
    b"\xff",
    b"\xef\xbb\xbf",
    b"\xff\xfe",
    b"\x1a",
    b"0x1p3",
    b"1_0",
    b"1,5",
    b"--",
    b"-",
    b"e",
    b".",
    b"9" * 400,
    b"\xc2\xa0",
    b"\xe2\x80\xa8",
    b"1j",
    b"(1)",
    b"True",
    b"\x0b",
    b"\x0c",
    b"\x1c",
    b"\x85",
]
MAPPING_SPICE = [
    b"&a ",
    b"*a",
    b"<<: ",
    b"[",
    b"]",
    b"{",
    b"}",
    b": ",
    b"- ",
    b"~",
    b"published: ",
    b"ratio: 9\n",
    b"rad",
    b"counts",
    b"K",
    b"-1",
    b"0",
    b"99",
    b"1e300",
    b"../",
    b"/dev/zero",
    b"skip",
    b"comma",
    b"tab",
    b"none",
    b"comment",
    b"\\0",
]


def logger_file(rows: int = 160) -> bytes:
    """A logger's file that MAPPING fits."""
    t = np.arange(rows) * 10.0
    drum = 0.4 * np.sin(0.01 * t)
    counts = np.round(9.0 * drum / (2.0 * np.pi) * 32768)
    body = zip(t, counts, 2.0 - np.degrees(9.0 * drum), drum, 0.9 * np.sign(np.cos(0.01 * t)), strict=True)
    lines = ["Bench 4", "t,q_left,q_right,q_out,tau Nm", *(",".join(f"{value:.7g}" for value in row) for row in body)]
    return ("\n".join(lines) + "\n").encode()


T = TypeVar("T")


def read_or_refused(load: Callable[[Path], T], path: Path, note: object) -> T | None:
    """What ``load`` makes of a file; None for an InputError, which must be whole; anything else fails."""
    try:
        with warnings.catch_warnings():
            warnings.simplefilter("error")
            return load(path)
    except InputError as error:
        problems = error.problems
    except BaseException as error:
        raise AssertionError(f"{note}: {type(error).__name__}: {error}") from error
    for problem in problems:
        assert problem.file and problem.line >= 1 and problem.what and problem.remedy, (note, problem)
        assert str(problem).isprintable() and len(str(problem)) < 900, (note, problem)
    return None


def tried(path: Path, note: object) -> bool:
    """Whether a measurement file is read; a run must then be fit for use."""
    run = read_or_refused(load_measurement, path, note)
    if run is None:
        return False
    assert run.time_s.size >= FEWEST_SAMPLES and np.all(np.diff(run.time_s) > 0.0), note
    for values in (run.time_s, run.input_rad, run.output_rad, run.load_Nm, run.temperature_C):
        assert values is None or (np.isfinite(values).all() and values.shape[-1] == run.time_s.size), note
    with warnings.catch_warnings():
        warnings.simplefilter("error")
        findings = vet(run, reference_drive())
    assert all(finding.text.isprintable() for finding in findings), (note, findings)
    return True


@cache
def reference_drive() -> Drive:
    """The drive that runs are vetted against."""
    return load_design(PAPER.parents[1] / "mbcdm.yaml").drive


def run_mutants(folder: Path, seeds: range) -> tuple[int, int]:
    """Mutants of the data with the right mapping, and of the mapping with the right data; (read, refused)."""
    (folder / "run.csv").write_bytes(logger_file())
    (folder / "run.yaml").write_text(MAPPING)
    assert tried(folder / "run.yaml", "unharmed")
    read = refused = 0
    for seed in seeds:
        rng = random.Random(seed)
        data, mapping = logger_file(), MAPPING.encode()
        if seed % 3:
            data = mutate(data, SPICE, rng)
        if seed % 3 != 1:
            mapping = mutate(mapping, SPICE + MAPPING_SPICE, rng)
        if seed % 2:
            mapping = mapping.replace(b"refuse", b"skip")
        (folder / "run.csv").write_bytes(data)
        (folder / "run.yaml").write_bytes(mapping)
        if tried(folder / "run.yaml", seed):
            read += 1
        else:
            refused += 1
    return read, refused


def test_two_hundred_mutants(tmp_path: Path) -> None:
    read, refused = run_mutants(tmp_path, range(200))
    assert read > 30 and refused > 60, f"{read} read and {refused} refused: the mutations are too weak or too strong"


@pytest.mark.slow
def test_four_thousand_more_mutants(tmp_path: Path) -> None:
    read, refused = run_mutants(tmp_path, range(200, 4200))
    assert read > 700 and refused > 1300, f"{read} read and {refused} refused"


@settings(max_examples=60, deadline=None, suppress_health_check=[HealthCheck.function_scoped_fixture])
@given(
    st.lists(
        st.lists(
            st.one_of(st.floats(width=32).map(str), st.sampled_from(["", "nan", "x", "1,5", '"2"', "%", "\x00"])),
            max_size=7,
        ),
        max_size=130,
    ),
    st.sampled_from([",", ";", "\t", " "]),
    st.sampled_from(["auto", "comma", "semicolon", "tab", "space"]),
    st.sampled_from(["auto", "row", "comment", "none"]),
    st.sampled_from(["point", "comma"]),
)
def test_any_table(tmp_path: Path, rows: list[list[str]], sign: str, delimiter: str, header: str, decimal: str) -> None:
    (tmp_path / "run.csv").write_bytes("\n".join(sign.join(row) for row in rows).encode())
    mapping = MAPPING.replace("delimiter: comma", f"delimiter: {delimiter}\ndecimal: {decimal}").replace(
        "header: row", f"header: {header}"
    )
    for number, name in enumerate(("t,", "q_left", "3,", "q_out", '"tau Nm"'), 1):
        mapping = mapping.replace(f"column: {name}", f"column: {number}" + ("," if name.endswith(",") else ""))
    (tmp_path / "run.yaml").write_text(mapping.replace("refuse", "skip"))
    tried(tmp_path / "run.yaml", (rows, sign))


def test_four_hundred_mutants_of_published_figures(tmp_path: Path) -> None:
    content = PAPER.read_bytes()
    path = tmp_path / "paper.yaml"
    read = 0
    for seed in range(400):
        path.write_bytes(mutate(content, SPICE + MAPPING_SPICE, random.Random(seed)))
        read += read_or_refused(load_file, path, seed) is not None
    assert 40 < read < 300, f"{read} of 400 read"
