"""Readings that arrive late: the output's encoder, or all input encoders, ``delay_ms`` old."""

from __future__ import annotations

from typing import Annotated, Literal

from pydantic import Field

from mbcdm_cad.rig.bench import Bench
from mbcdm_cad.rig.effects.base import RigEffect


class SensorDelay(RigEffect):
    """Delay of encoders."""

    effect: Literal["sensor_delay"]
    sensor: Literal["output", "inputs"] = "output"
    delay_ms: Annotated[float, Field(ge=0.0, le=1000.0)]

    def apply(self, bench: Bench) -> None:
        delay = self.delay_ms * 1e-3
        if self.sensor == "output":
            bench.output_delay_s += delay
        else:
            bench.input_delay_s += delay
        # Only the delay between output and inputs can be measured.
        bench.tell("delay", cause="sensor_delay", parameters={"delay_s": delay if self.sensor == "output" else -delay})
