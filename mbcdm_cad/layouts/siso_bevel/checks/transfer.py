"""The transfer point: both step planes on one pitch line, lands wide enough, input and drum close but not touching."""

from __future__ import annotations

from mbcdm_cad.checks.transfer import transfer_checks

CHECKS = transfer_checks("input pulley", "keep r_o/r_m equal for both steps, as transmission.input_to_drum does")
