"""A drafted measurement file reads the data correctly: units, signs, encoders before the gearhead, forces."""

from __future__ import annotations

from datetime import UTC, datetime, timedelta
from pathlib import Path

import numpy as np
import pytest
from sound_runs import DRIVE, sound_run

from mbcdm_cad.cli import run as mbcdm
from mbcdm_cad.errors import InputError
from mbcdm_cad.measurement.draft import draft_text
from mbcdm_cad.measurement.reading import load_measurement
from mbcdm_cad.measurement.roles import Expected
from mbcdm_cad.measurement.run import Run
from mbcdm_cad.measurement.vet import arranged, refusals, vet

DESIGN = Path(__file__).parents[3] / "params" / "mbcdm.yaml"
RUN = sound_run()
DEG = 57.29577951308232


def drafted(
    folder: Path, columns: dict[str, np.ndarray], sign: str = ",", comma: bool = False, title: str = ""
) -> tuple[str, Run]:
    """The draft for a logger's file of these columns, and the run that it reads, as the design has it."""
    rows = [sign.join(f"{value:.10g}" for value in row) for row in np.stack(list(columns.values()), axis=1)]
    text = title + "\n".join([sign.join(columns), *rows]) + "\n"
    (folder / "run.csv").write_text(text.replace(".", ",") if comma else text)
    draft = draft_text(folder / "run.csv", Expected.of_drive(DRIVE))
    (folder / "run.yaml").write_text(draft.replace("lever_arm_mm: '?'", "lever_arm_mm: 120"))
    return draft, arranged(load_measurement(folder / "run.yaml"), DRIVE)


def same(run: Run) -> None:
    np.testing.assert_allclose(run.output_rad, RUN.output_rad, atol=2e-4)
    np.testing.assert_allclose(run.input_rad, RUN.input_rad, atol=2e-3)
    assert not refusals(vet(run, DRIVE)), refusals(vet(run, DRIVE))


def test_plain_names_and_units(tmp_path: Path) -> None:
    draft, run = drafted(
        tmp_path,
        {
            "t": RUN.time_s,
            "q_left [rad]": RUN.input_rad[0],
            "q_right [rad]": RUN.input_rad[1],
            "q_out [rad]": RUN.output_rad,
            "tau": RUN.load_Nm,
            "state": np.ones_like(RUN.time_s),
        },
    )
    same(run)
    assert "guessed" in draft and "not used: state" in draft, draft
    np.testing.assert_allclose(run.load_Nm, RUN.load_Nm, rtol=1e-8)


def test_counts_before_the_gearhead_degrees_and_a_load_cell(tmp_path: Path) -> None:
    counts = np.round(RUN.input_rad * DRIVE.gearhead.ratio * 512.0 / (2.0 * np.pi))
    draft, run = drafted(
        tmp_path,
        {
            "time_ms": 1e3 * RUN.time_s,
            "motor_left": -counts[0],
            "motor_right": counts[1],
            "drum": DEG * RUN.output_rad,
            "load_cell (N)": RUN.load_Nm / 0.12,
        },
    )
    assert "side: motor" in draft and "counts_per_turn: 512" in draft and "scale: -1" in draft, draft
    assert "unit: deg" in draft and "put the arm of the load cell" in draft, draft
    same(run)
    np.testing.assert_allclose(run.load_Nm, RUN.load_Nm, rtol=1e-6)


def test_a_table_of_semicolons_and_decimal_commas(tmp_path: Path) -> None:
    columns = {"t": RUN.time_s, "left": RUN.input_rad[0], "right": RUN.input_rad[1], "drum": RUN.output_rad}
    draft, run = drafted(tmp_path, columns, ";", comma=True)
    assert "decimal: comma" in draft, draft
    same(run)


def test_what_is_no_run_is_refused_and_nothing_is_overwritten(
    tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    (tmp_path / "run.csv").write_text("a,b\n" + "7,5\n" * 200)
    with pytest.raises(InputError, match="no column looks like the output"):
        draft_text(tmp_path / "run.csv", Expected.of_drive(DRIVE))
    columns = {"t": RUN.time_s, "left": RUN.input_rad[0], "right": RUN.input_rad[1], "drum": RUN.output_rad}
    drafted(tmp_path, columns)
    before = (tmp_path / "run.yaml").read_bytes()
    assert mbcdm(["measurement-init", str(tmp_path / "run.csv"), str(DESIGN)]) == 2
    assert "exists already" in capsys.readouterr().err and (tmp_path / "run.yaml").read_bytes() == before
    assert mbcdm(["measurement-init", str(tmp_path / "run.csv"), str(DESIGN), "--out", str(tmp_path / "new.yaml")]) == 0
    assert mbcdm(["measurement-init", str(tmp_path / "none.csv"), str(DESIGN)]) == 2


@pytest.mark.parametrize(("name", "unit"), [("cell_N", "N"), ("torque_Nm", "Nm"), ("load_n", "N*m")])
def test_the_end_of_a_name_states_the_unit_of_the_load(tmp_path: Path, name: str, unit: str) -> None:
    columns = {"t": RUN.time_s, "left": RUN.input_rad[0], "right": RUN.input_rad[1], "drum": RUN.output_rad}
    draft, _ = drafted(tmp_path, {**columns, name: RUN.load_Nm})
    assert f'"{name}", unit: {unit}' in draft, draft


def test_whole_numbers_do_not_hide_the_decimal_comma_nor_a_title_the_names(tmp_path: Path) -> None:
    """Counters are figures with either decimal sign; a title has fewer cells than the table below it."""
    counts = np.round(RUN.input_rad * DRIVE.gearhead.ratio * 4096.0 / (2.0 * np.pi))
    columns = {
        "Zeit [ms]": 1e3 * RUN.time_s,
        "Motor L [counts]": counts[0],
        "Motor R [counts]": counts[1],
        "Abtrieb [deg]": DEG * RUN.output_rad,
        "Kanal 7 [N]": RUN.load_Nm / 0.12,
    }
    draft, run = drafted(tmp_path, columns, ";", comma=True, title="Messung;Pruefstand 3\n")
    assert "decimal: comma" in draft and "skip_rows: 1 " in draft, draft
    assert 'load_torque: {column: "Kanal 7 [N]", unit: N' in draft, draft
    same(run)
    np.testing.assert_allclose(run.load_Nm, RUN.load_Nm, rtol=1e-6)


def test_encoders_of_one_turn_are_counted_on(tmp_path: Path) -> None:
    """Two absolute encoders of 14 bits on the motors and one in degrees on the drum, which passes from 360 to 0."""
    turns = RUN.input_rad * DRIVE.gearhead.ratio / (2.0 * np.pi)
    counts = np.floor(np.mod(turns + np.array([[0.3], [0.7]]), 1.0) * 16384.0)
    columns = {
        "t_s": RUN.time_s,
        "mot_left": counts[0],
        "mot_right": counts[1],
        "drum_deg": np.mod(DEG * RUN.output_rad + 3.0, 360.0),
        "tau_Nm": RUN.load_Nm,
    }
    draft, run = drafted(tmp_path, columns)
    assert draft.count("wraps_at: 16384") == 2 and "wraps_at: 360" in draft, draft
    step = 2.0 * np.pi / 16384.0 / DRIVE.gearhead.ratio
    for measured, true in zip(run.input_rad, RUN.input_rad, strict=True):
        np.testing.assert_allclose(measured - measured[0], true - true[0], atol=2.0 * step)
    turned = run.output_rad - RUN.output_rad
    np.testing.assert_allclose(turned, turned[0], atol=1e-7)


def test_dates_are_a_time(tmp_path: Path) -> None:
    """A script's isoformat(), which leaves out the fraction of a whole second."""
    columns = {"left": RUN.input_rad[0], "right": RUN.input_rad[1], "drum": RUN.output_rad, "tau": RUN.load_Nm}
    began = datetime(2026, 3, 1, 23, 59, 30, tzinfo=UTC)
    rows = zip(RUN.time_s, *columns.values(), strict=True)
    lines = [",".join(["timestamp", *columns])]
    lines += [",".join([(began + timedelta(seconds=t)).isoformat(), *(f"{v:.10g}" for v in rest)]) for t, *rest in rows]
    (tmp_path / "run.csv").write_text("\n".join(lines) + "\n")
    draft = draft_text(tmp_path / "run.csv", Expected.of_drive(DRIVE))
    assert 'time: {column: "timestamp", unit: iso8601}' in draft, draft
    (tmp_path / "run.yaml").write_text(draft)
    run = arranged(load_measurement(tmp_path / "run.yaml"), DRIVE)
    np.testing.assert_allclose(run.time_s - run.time_s[0], RUN.time_s - RUN.time_s[0], atol=1.1e-6)
    same(run)


@pytest.mark.parametrize(
    ("head", "sign", "expected"),
    [
        ("Frequency (Hz),Channel 1 Magnitude (dB),Channel 2 Magnitude (dB),Channel 2 Phase (deg)", ",", "turns: 1}"),
        ("# Bode\n% Frequency (Hz), Gain (dB), Phase (deg)", ",", "response: {over: inputs}"),
        ("freq_rad/s\tmag\tphase_deg\tcoherence", "\t", "unit: rad/s}"),
        ("Frequenz [Hz];Betrag [dB];Phase [°]", ";", "over: torque"),
    ],
)
def test_a_table_of_gain_and_phase_is_one_of_an_analyser(head: str, sign: str, expected: str, tmp_path: Path) -> None:
    """As analysers and control suites write it: a reference channel, rad/s, falling frequencies, decimal commas."""
    f = np.geomspace(5.0, 200.0, 60)
    s, w = 2j * np.pi * f, 2.0 * np.pi * 70.0
    value = w**2 / (s**2 + 30.0 * s + w**2)
    gain, phase = 20.0 * np.log10(np.abs(value)), np.degrees(np.unwrap(np.angle(value)))
    columns = {
        "Frequency (Hz)": [f, 0.0 * f, gain, phase],
        "# Bode": [f, gain - 20.0 * np.log10(9.0), phase],
        "freq_rad/s\tmag": [2.0 * np.pi * f, np.abs(value) / 9.0, phase, 1.0 - 1e-4 * f],
        "Frequenz": [f[::-1], gain[::-1] - 80.0, phase[::-1]],
    }
    table = next(rows for begin, rows in columns.items() if head.startswith(begin))
    lines = [sign.join(f"{v:.7g}" for v in row) for row in np.stack(table, axis=1)]
    text = "\n".join([head, *((line.replace(".", ",") if sign == ";" else line) for line in lines)])
    (tmp_path / "bode.csv").write_text(text + "\n", encoding="utf-8")
    draft = draft_text(tmp_path / "bode.csv", Expected.of_drive(DRIVE))
    assert expected in draft and "kind: frequency_response" in draft, draft
    (tmp_path / "bode.yaml").write_text(draft, encoding="utf-8")
    read = load_measurement(tmp_path / "bode.yaml").table
    assert read is not None
    np.testing.assert_allclose(read.frequency_Hz, f, rtol=1e-5)
    np.testing.assert_allclose(read.value / np.abs(read.value[0]), value / np.abs(value[0]), rtol=1e-4)
