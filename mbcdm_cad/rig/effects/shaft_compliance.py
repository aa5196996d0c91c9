"""A soft shaft between the drum and its encoder: the encoder lags behind the drum by compliance times load torque."""

from __future__ import annotations

from typing import Annotated, Literal

from pydantic import Field

from mbcdm_cad.rig.bench import Bench
from mbcdm_cad.rig.effects.base import RigEffect


class ShaftCompliance(RigEffect):
    """Compliance of the output shaft."""

    effect: Literal["shaft_compliance"]
    compliance_urad_Nm: Annotated[float, Field(ge=0.0, le=1e5)]

    def apply(self, bench: Bench) -> None:
        bench.output_twist_rad_Nm += self.compliance_urad_Nm * 1e-6
        bench.tell(
            "stiffness_error",
            cause="shaft_compliance",
            parameters={"compliance_rad_Nm": self.compliance_urad_Nm * 1e-6},
        )
