"""A residual that no effect explains is described: what it repeats in, how large, and by what shape."""

import numpy as np
import pytest
from scipy.signal import lfilter

from mbcdm_cad.loop.prepare.prepared import Prepared, prepare
from mbcdm_cad.loop.search.evidence import NoiseModel, noise_model
from mbcdm_cad.loop.search.problem import starts_of
from mbcdm_cad.loop.search.unknown import describe_unknown
from mbcdm_cad.measurement.run import Run, Sensors
from mbcdm_cad.routes import Floats

FLOOR, SIZE = 4e-6, 20e-6


def run_with(kind: str, seed: int) -> tuple[Prepared, Floats, NoiseModel]:
    rng = np.random.default_rng(seed)
    t = np.arange(0.0, 160.0, 0.01)
    angle = 0.45 * np.sin(2.0 * np.pi * 0.0625 * t)
    sense = np.sign(np.gradient(angle, t))
    # A load that goes neither with the angle nor with the speed.
    load = 0.5 * np.sign(np.sin(2.0 * np.pi * 0.019 * t)) + 0.4 * np.sin(2.0 * np.pi * 0.0313 * t + 1.0)
    shapes = {
        "nothing": 0.0 * t,
        "square": load**2,
        "cube": load**3,
        "bump": 3.0 * np.exp(-0.5 * ((angle - 0.1) / 0.03) ** 2),
        "sense": sense,
        "loaded sense": load * sense,
        "wander": lfilter([1.0], [1.0, -np.exp(-0.01 / 0.3)], 0.25 * rng.standard_normal(t.size)),
    }
    noise = FLOOR * np.convolve(rng.standard_normal(t.size), np.ones(9) / 3.0, "same")
    residual = SIZE * shapes[kind] + noise
    run = Run(
        t, np.stack([9.0 * angle, 9.0 * angle]), angle + residual, load, None, Sensors(1.9175e-4, 1.3635e-6, 5e-3)
    )
    p, rest = prepare(run, 9.0)[1], residual if kind == "wander" else noise
    return p, residual, noise_model(rest[p.used], p.step_s, starts_of(p), 1e-7)[1]


@pytest.mark.parametrize(
    ("kind", "variable", "form"),
    [
        ("square", "load", "x^2"),
        ("cube", "load", "x^3"),
        ("bump", "angle", "exp(-((x - x0)/w)^2 / 2)"),
        ("sense", "speed", "sign(x)"),
        ("loaded sense", "load by direction", None),
    ],
)
def test_pattern_and_shape_are_those_put_in(kind: str, variable: str, form: str | None) -> None:
    for seed in range(3):
        unknown = describe_unknown(*run_with(kind, seed))
        assert unknown.patterns, unknown.sentence()
        best = unknown.patterns[0]
        assert best.variable == variable, unknown.sentence()
        assert best.share > 0.5, unknown.sentence()
        assert form is None or (best.shape and best.shape.form == form), unknown.sentence()


def test_place_and_height_of_a_bump() -> None:
    unknown = describe_unknown(*run_with("bump", 0))
    words = unknown.sentence().split("a bump of ")[1].split()
    height, place, width = float(words[0]), float(words[4]), float(words[6])
    assert abs(height - 60.0) < 3.0, unknown.sentence()
    assert abs(place - 0.1) < 0.01, unknown.sentence()
    assert abs(width - 2.355 * 0.03) < 0.01, unknown.sentence()


def test_noise_alone_has_no_pattern() -> None:
    found = [describe_unknown(*run_with("nothing", seed)).patterns for seed in range(10)]
    assert found == [()] * 10


def test_a_wander_does_not_repeat_in_angle_load_or_speed() -> None:
    said = []
    for seed in range(10):
        unknown = describe_unknown(*run_with("wander", seed))
        said += [p.variable for p in unknown.patterns if p.variable != "time"]
        assert 0.1 < unknown.memory_s < 1.0, unknown.sentence()
    assert len(said) <= 1, said


def test_json_carries_the_curve_and_the_spectrum() -> None:
    unknown = describe_unknown(*run_with("bump", 1))
    found = unknown.to_json()
    curve = found["patterns"][0]
    assert found["repeatable"] is True and len(curve["at"]) == len(curve["mean_rad"]) > 30
    assert len(found["order_spectrum_peaks"]) == 3
