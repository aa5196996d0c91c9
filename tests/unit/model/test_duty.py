"""The duty by rows and by a record: root mean square, movements counted by hand."""

from __future__ import annotations

from math import sqrt

import numpy as np
import pytest

from mbcdm_cad.design.blocks import DutyRow
from mbcdm_cad.model.duty import default_duty, of_record, of_rows


def test_rows_give_mean_square_share_and_movements() -> None:
    rows = (
        DutyRow(torque_Nm=8.0, share=0.4),
        DutyRow(torque_Nm=3.0, share=0.3, speed_deg_s=60.0, range_deg=60.0),
        DutyRow(torque_Nm=-2.0, share=0.2, range_deg=40.0),
        DutyRow(torque_Nm=0.0, share=0.1, speed_deg_s=0.0),
    )
    duty = of_rows(rows, 60.0, 100.0, 35.0)
    assert duty.period_s == pytest.approx(60.0)
    assert duty.rms_torque_Nm == pytest.approx(sqrt(0.4 * 64 + 0.3 * 9 + 0.2 * 4))
    assert duty.peak_torque_Nm == 8.0 and duty.moving_share == pytest.approx(0.5)
    # 18 s at 60 deg/s over 120 deg there and back: 9 a minute; the other row once a minute.
    assert [s.per_h for s in duty.strokes] == pytest.approx([540.0, 60.0])
    assert [s.range_deg for s in duty.strokes] == [60.0, 40.0] and duty.cycles_per_h == pytest.approx(600.0)
    assert duty.largest_speed_deg_s == pytest.approx(60.0)
    assert (duty.speed_deg_s * duty.time_s).sum() == pytest.approx(0.0, abs=1e-9)


def test_shares_count_relative_to_their_sum_and_the_travel_stands_in_for_a_range() -> None:
    rows = (DutyRow(torque_Nm=1.0, share=1.0, speed_deg_s=20.0), DutyRow(torque_Nm=2.0, share=1.0))
    duty = of_rows(rows, 10.0, 100.0, 25.0)
    assert duty.time_s.sum() == pytest.approx(10.0) and duty.rms_torque_Nm == pytest.approx(sqrt(2.5))
    assert duty.strokes[0].range_deg == 100.0 and duty.strokes[0].per_h == pytest.approx(5 * 20 / 200 * 360)


def test_the_assumed_duty_says_what_it_is() -> None:
    duty = default_duty(10.0, 120.0, 25.0)
    assert not duty.stated and len(duty.assumed) == 2
    assert duty.peak_torque_Nm == 10.0 and duty.rms_torque_Nm == pytest.approx(10 * sqrt(0.1 + 0.9 * 0.09))
    assert duty.cycles_per_h == pytest.approx(360.0)


def test_the_assumed_duty_carries_the_payloads_weight() -> None:
    """A weight above the usual share of the peak torque is carried all the time; a smaller one is within it."""
    heavy, light = (default_duty(10.0, 120.0, 25.0, weight) for weight in (6.0, 2.0))
    assert heavy.rms_torque_Nm == pytest.approx(10 * sqrt(0.1 + 0.9 * 0.36))
    assert "weight, 6 N m" in heavy.assumed[0], heavy.assumed
    assert light.rms_torque_Nm == default_duty(10.0, 120.0, 25.0).rms_torque_Nm
    assert "weight, 2 N m" in light.assumed[-1], light.assumed


def test_a_record_gives_what_its_curve_is() -> None:
    """Two periods of a cosine of 30 degrees under a torque of 2 N m with a wave of 1 N m; a tremble is no movement."""
    t = np.linspace(0.0, 10.0, 4001)
    angle = 30.0 * np.cos(2 * np.pi * t / 5.0) + 0.05 * np.sin(2 * np.pi * t * 7.0)
    torque = 2.0 + np.sin(2 * np.pi * t)
    duty = of_record(t, angle, torque, 25.0)
    assert duty.period_s == pytest.approx(10.0)
    assert duty.rms_torque_Nm == pytest.approx(sqrt(4.5), rel=1e-3)
    assert duty.cycles_per_h == pytest.approx(2 * 360.0)
    assert [s.range_deg for s in duty.strokes] == pytest.approx([60.0] * 4, abs=0.2)
    assert all(s.torque_Nm == pytest.approx(3.0, abs=0.01) for s in duty.strokes)


def test_a_record_that_ends_elsewhere_closes_the_cycle() -> None:
    """From 0 to 40 and no way back in the record: the cycle begins anew at 0, so the drum came back."""
    duty = of_record(np.array([0.0, 1.0, 2.0]), np.array([0.0, 20.0, 40.0]), np.ones(3), 25.0)
    assert duty.cycles_per_h == pytest.approx(1800.0) and {s.range_deg for s in duty.strokes} == {40.0}
