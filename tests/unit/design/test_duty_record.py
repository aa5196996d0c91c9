"""A duty's record beside the design file: units of its header, messages with the record's lines, hours of life."""

from __future__ import annotations

from pathlib import Path

import numpy as np
import pytest

from mbcdm_cad.errors import InputError
from mbcdm_cad.layouts.life import life_of
from mbcdm_cad.layouts.loader import layout_of, load_design

DESIGN = """name: wrist
configuration: siso_spur
travel: {half_angle_deg: 35}
transmission: {input_to_drum: 10, drum_radius_mm: 60}
loads: {peak_torque_Nm: 0.8, duty: {record: logs/day.csv, ambient_C: 30}}
targets: {life_h: 10}
"""


def written(folder: Path, record: str, design: str = DESIGN) -> Path:
    (folder / "logs").mkdir(exist_ok=True)
    (folder / "logs" / "day.csv").write_text(record)
    (folder / "wrist.yaml").write_text(design)
    return folder / "wrist.yaml"


@pytest.mark.parametrize(
    "record",
    [
        "time_s,angle_deg,torque_Nm\n0,0,0.2\n1,30,0.5\n2,0,0.2\n",
        "# a comment\ntorque [mN m];time [ms];note;angle [deg]\n200;0;a;0\n\n500;1000;b;30\n200;2000;c;0\n",
        "time_min,angle_rad,torque_kNm\n0,0,0.0002\n0.016666666667,0.5235987756,0.0005\n0.033333333333,0,0.0002\n",
    ],
)
def test_a_record_gives_the_same_duty_in_any_units(record: str, tmp_path: Path) -> None:
    layout = layout_of(load_design(written(tmp_path, record)).drive)
    duty = layout.duty
    assert duty.stated and duty.assumed == () and duty.ambient_C == 30.0
    assert duty.period_s == pytest.approx(2.0) and duty.largest_speed_deg_s == pytest.approx(30.0)
    # A straight line from 0.2 to 0.5: mean square (0.04 + 0.1 + 0.25)/3.
    assert duty.rms_torque_Nm == pytest.approx(0.13**0.5, rel=1e-6)
    assert [s.range_deg for s in duty.strokes] == pytest.approx([30.0, 30.0]) and duty.cycles_per_h == pytest.approx(
        1800
    )
    # Ten hours of 1800 cycles.
    assert life_of(layout).wanted_cycles == pytest.approx(18000.0)


@pytest.mark.parametrize(
    ("record", "line", "words"),
    [
        ("time_s,angle_deg\n0,0\n1,1\n", 1, "no column with the torque"),
        ("time_s,angle_deg,torque\n0,0,1\n1,1,1\n", 1, "no column with the torque"),
        ("time_s,angle_deg,torque_Nm\n0,0,0.1\n1,x,0.1\n", 3, "not three numbers"),
        ("time_s,angle_deg,torque_Nm\n0,0,0.1\n1,3\n", 3, "not three numbers"),
        ("time_s,angle_deg,torque_Nm\n0,0,0.1\n1,nan,0.1\n", 3, "not three numbers"),
        ("time_s,angle_deg,torque_Nm\n0,0,0.1\n\n1,3,0.1\n1,4,0.1\n", 5, "does not grow"),
        ("time_s,angle_deg,torque_Nm\n0,0,0.1\n1,3,0.9\n", 3, "more than the peak torque"),
        ("time_s,angle_deg,torque_Nm\n0,-36,0.1\n1,36,0.1\n", 3, "more than the whole travel"),
        ("time_s,angle_deg,torque_Nm\n0,0,0.1\n", 1, "too short"),
        ("", 1, "too short"),
    ],
)
def test_a_record_that_does_not_do_is_told_by_its_line(record: str, line: int, words: str, tmp_path: Path) -> None:
    path = written(tmp_path, record)
    with pytest.raises(InputError) as error:
        load_design(path)
    problem = error.value.problems[0]
    assert problem.file == str(tmp_path / "logs/day.csv") and (problem.line, words in problem.what) == (line, True), (
        str(error.value)
    )


def test_what_contradicts_the_record_is_told_by_the_design_files_line(tmp_path: Path) -> None:
    record = "time_s,angle_deg,torque_Nm\n0,0,0.2\n1,30,0.5\n"
    for old, new, words in (
        ("ambient_C: 30", "period_s: 3", "given beside record"),
        ("ambient_C: 30", "rows: [{torque_Nm: 0.1, share: 1}]", "both rows and record"),
        ("record: logs/day.csv, ", "", "neither rows nor record"),
        ("life_h: 10", "life_h: 10, life_cycles: 3", "given beside life_cycles"),
        (", duty: {record: logs/day.csv, ambient_C: 30}", "", "hours without a duty"),
        ("day.csv", "night.csv", "cannot be read"),
    ):
        with pytest.raises(InputError, match=words):
            load_design(written(tmp_path, record, DESIGN.replace(old, new)))


def test_the_hash_follows_the_record(tmp_path: Path) -> None:
    hashes = set()
    for load in (0.2, 0.3, 0.2):
        loaded = load_design(written(tmp_path, f"time_s,angle_deg,torque_Nm\n0,0,{load}\n1,30,0.5\n"))
        assert loaded.data["loads"]["duty"] == {"record": "logs/day.csv", "ambient_C": 30}
        hashes.add(loaded.sha256)
    assert len(hashes) == 2


def test_many_movements_count_by_classes_that_take_no_life_away(tmp_path: Path) -> None:
    """A noisy walk of a thousand turns back: as many movements, none smaller than it was."""
    rng = np.random.default_rng(1)
    angle, torque = rng.uniform(-30, 30, 1000), rng.uniform(-0.7, 0.7, 1000)
    rows = "\n".join(f"{k},{a:.4f},{m:.4f}" for k, (a, m) in enumerate(zip(angle, torque, strict=True)))
    duty = layout_of(load_design(written(tmp_path, f"time_s,angle_deg,torque_Nm\n{rows}\n")).drive).duty
    assert len(duty.strokes) <= 72
    turns = np.flatnonzero(np.diff(np.sign(np.diff(np.append(angle, angle[0]))))).size
    assert duty.cycles_per_h == pytest.approx(0.5 * turns * 3600.0 / 999.0, rel=0.02)
    mean = sum(s.range_deg * s.per_h for s in duty.strokes) / duty.cycles_per_h
    exact = np.abs(np.diff(angle)).sum() / turns
    assert exact <= mean <= 1.2 * exact, (exact, mean)
