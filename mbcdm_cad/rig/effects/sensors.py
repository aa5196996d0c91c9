"""Effects of the encoders: their scale, place, lines, and readings that arrive late."""

from __future__ import annotations

from math import radians
from typing import Annotated, Literal

import numpy as np
from pydantic import Field

from mbcdm_cad.rig.bench import Bench
from mbcdm_cad.rig.effects.base import Phase, RigEffect, Stage


class EncoderScale(RigEffect):
    """Scale error of an encoder.

    An encoder that counts too many or too few lines a turn: it reads its shaft's angle times 1 + share.
    """

    effect: Literal["encoder_scale"]
    stage: Stage
    share_ppm: Annotated[float, Field(ge=-1e5, le=1e5)]

    def apply(self, bench: Bench) -> None:
        share = self.share_ppm * 1e-6
        bench.add_encoder_error(self.stage, lambda angle: np.asarray(share * angle))
        # Error of the ratio of output to inputs; one input counts with its share.
        inputs = len(bench.drive.input_names)
        ratio = share if self.stage == bench.routes.drum.name else -share / inputs
        bench.tell(
            "ratio_error", stage=self.stage, cause="encoder_scale", parameters={"share": ratio, "encoder_share": share}
        )


class EccentricEncoder(RigEffect):
    """Eccentric encoder on the drum's or an input's shaft.

    An encoder whose disc is not centred: at the shaft angle a its error is amplitude cos(a + phase).
    """

    effect: Literal["eccentric_encoder"]
    stage: Stage
    amplitude_urad: Annotated[float, Field(ge=0.0, le=1e5)]
    phase_deg: Phase = 0.0

    def apply(self, bench: Bench) -> None:
        amplitude, phase = self.amplitude_urad * 1e-6, radians(self.phase_deg)
        bench.add_encoder_error(self.stage, lambda angle: np.asarray(amplitude * np.cos(angle + phase)))
        bench.tell(
            "once_per_rev",
            stage=self.stage,
            cause="eccentric_encoder",
            parameters={"amplitude_rad": amplitude, "phase_rad": phase},
        )


class EncoderSubdivision(RigEffect):
    """Sub-division error of an encoder.

    Sub-division error: sine and cosine of an encoder's lines differ, which causes an error periodic in the lines.

    Unequal amplitudes give two periods a line, offsets one: ``cycles_per_rev`` is lines times that. Angle error
    amplitude sin(cycles a + phase) on the encoder's shaft.
    """

    effect: Literal["encoder_subdivision"]
    stage: Stage
    amplitude_urad: Annotated[float, Field(ge=0.0, le=1e5)]
    cycles_per_rev: Annotated[float, Field(gt=0.0, le=1e6)]
    phase_deg: Phase = 0.0

    def apply(self, bench: Bench) -> None:
        amplitude, phase, cycles = self.amplitude_urad * 1e-6, radians(self.phase_deg), self.cycles_per_rev
        bench.add_encoder_error(self.stage, lambda angle: np.asarray(amplitude * np.sin(cycles * angle + phase)))
        turns, part = 1.0, 1.0
        if self.stage != bench.routes.drum.name:
            turns, part = bench.turns(bench.input_index(self.stage)), 1.0 / len(bench.drive.input_names)
        # At the output the error of an input is divided by its ratio and by the number of inputs, which share about
        # equally.
        bench.tell(
            "ripple",
            stage=self.stage,
            cause="encoder_subdivision",
            parameters={"cycles_per_output_rev": cycles * turns, "amplitude_rad": amplitude / turns * part},
        )


class SensorDelay(RigEffect):
    """Delay of encoders.

    Readings that arrive late: the output's encoder, or all input encoders, ``delay_ms`` old.
    """

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
