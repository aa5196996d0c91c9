"""Marks on the rig's rope, counted where they pass from a body to a span and back, against the zones of the life."""

from __future__ import annotations

from collections import Counter
from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest

from mbcdm_cad.layouts.life import ropes_in_use
from mbcdm_cad.layouts.loader import load_design
from mbcdm_cad.model.rope_zones import Level, RopeLife, rope_life
from mbcdm_cad.rig import chain
from mbcdm_cad.rig.bench import RigCable, cables_of

PARAMS = Path(__file__).parents[3] / "params"
MARK_M, STEPS = 0.2e-3, 201
# By hand, in a cycle over the whole travel: what winds on and off bends once, what passes the guide and returns twice.
BY_HAND = {
    "mbcdm": {"input": 1.0, "guide": 2.0, "drum": 1.0},
    "siso_spur": {"input": 1.0, "drum": 1.0},
    "miso_spur": {"input": 1.0, "drum": 1.0},
    "siso_bevel": {"input": 1.0, "drum": 1.0},
}


def rig_of(name: str) -> tuple[tuple[RigCable, ...], float, RopeLife]:
    """The rig's cables of the first rope of a reference, half its travel, and the life's zones of that rope."""
    drive = load_design(PARAMS / f"{name}.yaml").drive
    layout = drive.layout
    half, si = layout.half_travel_rad, layout.loads.si
    rope = next(iter(ropes_in_use(layout, si)))
    # Without directions bends of opposite sense count as any other.
    plain = replace(rope, tangents=tuple(replace(t, normal=(0.0, 0.0, 0.0)) for t in rope.tangents))
    tension = np.full((si.n_cables, 2), 50.0)
    life = rope_life(plain, [Level(np.array([-half, half]), tension, tension)])
    sides = {t.cable for t in rope.tangents}
    return tuple(c for j, c in enumerate(cables_of(drive)) if j in sides), half, life


def counted(cables: tuple[RigCable, ...], half_rad: float) -> tuple[Counter[float], dict[str, float]]:
    """Length in mm by bendings in a cycle, and the most bendings on each kind of body."""
    state = chain.chains(cables, passed_slip=True, reach_rad=half_rad, input_wrap_rad=12.0, drum_wrap_rad=2.5)
    lengths: Counter[float] = Counter()
    most: dict[str, float] = {}
    way = np.linspace(-half_rad, half_rad, STEPS)
    for j, c in enumerate(cables):
        spans = [span.length_m for span in c.route.spans]
        first = c.input_radius_m * 12.0
        marks = np.arange(first - 0.2, first + 0.4, MARK_M)
        before: np.ndarray | None = None
        halves = {k: np.zeros(marks.size) for k in range(len(spans) + 1)}
        for drum in np.concatenate([way, way[-2::-1]]):
            chain.carry(state, j, float(drum * c.drum_radius_m / c.input_radius_m), float(drum))
            wraps = state.wraps[j, :, chain.HIGH] - state.wraps[j, :, chain.LOW]
            ends = [c.input_radius_m * wraps[0]]
            for k, span in enumerate(spans, start=1):
                ends.append(ends[-1] + span)
                if k < len(spans):
                    ends.append(ends[-1] + wraps[k] * state.wraps[j, k, chain.RADIUS])
            # Even places are bodies: the input, those passed, the drum.
            now = np.searchsorted(np.array(ends), marks)
            if before is not None:
                for k in halves:
                    halves[k] += (now == 2 * k) != (before == 2 * k)
            before = now
        each = sum(halves.values()) / 2.0
        for number in np.unique(each[each > 0.0]):
            lengths[float(number)] += 1e3 * MARK_M * float(np.sum(each == number))
        kinds = ["input", *(["guide"] * (len(spans) - 1)), "drum"]
        for k, kind in enumerate(kinds):
            most[kind] = max(most.get(kind, 0.0), float(halves[k].max()) / 2.0)
    return lengths, most


@pytest.mark.parametrize("name", BY_HAND)
def test_marks_on_the_rigs_rope_bend_as_the_zones_say(name: str) -> None:
    cables, half, life = rig_of(name)
    seen, most = counted(cables, half)
    found: Counter[float] = Counter()
    by_body: dict[str, float] = {}
    for zone in life.zones:
        found[round(sum(zone.bendings.values()), 6)] += 1e3 * (zone.end_m - zone.start_m)
        for body, count in zone.bendings.items():
            kind = body.split(" ")[-1]
            by_body[kind] = max(by_body.get(kind, 0.0), count)
    assert by_body == most == BY_HAND[name]
    assert set(found) == set(seen), (found, seen)
    for count, length_mm in found.items():
        # Steps of the travel and the distance of the marks.
        assert seen[count] == pytest.approx(length_mm, abs=2.5), (count, found, seen)
