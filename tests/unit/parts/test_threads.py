"""ISO metric threads compared with printed values of ISO 724, ISO 2306 and ISO 898-1."""

from __future__ import annotations

import pytest

from mbcdm_cad.parts.fits import thread

# Nominal: pitch, d2, D1, tap drill, stress area (ISO 261, 724, 2306, 898-1).
PRINTED = {
    1.6: (0.35, 1.373, 1.221, 1.25, 1.27),
    2.0: (0.4, 1.740, 1.567, 1.6, 2.07),
    2.5: (0.45, 2.208, 2.013, 2.05, 3.39),
    3.0: (0.5, 2.675, 2.459, 2.5, 5.03),
    4.0: (0.7, 3.545, 3.242, 3.3, 8.78),
    6.0: (1.0, 5.350, 4.917, 5.0, 20.1),
    8.0: (1.25, 7.188, 6.647, 6.8, 36.6),
    12.0: (1.75, 10.863, 10.106, 10.2, 84.3),
}


@pytest.mark.parametrize("nominal", sorted(PRINTED))
def test_printed_values(nominal: float) -> None:
    found, (pitch, d2, d1, drill, area) = thread(nominal), PRINTED[nominal]
    assert found.pitch_mm == pitch
    assert found.pitch_diameter_mm == pytest.approx(d2, abs=6e-4)
    assert found.minor_diameter_mm == pytest.approx(d1, abs=6e-4)
    assert found.tap_drill_mm == drill
    assert found.stress_area_mm2 == pytest.approx(area, rel=5e-3)


@pytest.mark.parametrize("nominal", sorted(PRINTED))
def test_tap_drill_leaves_thread_and_clears_its_root(nominal: float) -> None:
    found = thread(nominal)
    assert found.minor_diameter_mm < found.tap_drill_mm < found.nominal_mm - 0.5 * found.pitch_mm


def test_names() -> None:
    assert thread(2.0).name == "M2"
    with pytest.raises(ValueError, match=r"M2\.7"):
        thread(2.7)


def test_depths() -> None:
    found = thread(2.0)
    assert found.full_thread_mm(4.9) == pytest.approx(4.1)
