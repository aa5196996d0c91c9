"""The transfer point: four step planes on one pitch line, lands wide enough, guide and drum close but not touching."""

from __future__ import annotations

from mbcdm_cad.checks.transfer import transfer_checks

CHECKS = transfer_checks("guide", "keep r_o/r_g equal for all steps, as transmission.ratios does")
