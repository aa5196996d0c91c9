"""Effects found on the built drive that change values of the design: modulus, preload, friction.

The others have no value in the design file: they stay in ``Drive.as_built``, and the loop predicts with them.
"""

from __future__ import annotations

from dataclasses import replace

from mbcdm_cad.design.blocks import AsBuilt, AsBuiltValue
from mbcdm_cad.design.drive import Drive

# Forms, by name of the effect, whose figure "share" is the relative change of a value that the design declares.
CHANGE_VALUES = {
    "stiffness_error": ("modulus of the rope",),
    "preload_error": ("all cables", "one cable"),
    "cable_friction": ("rope on pulley",),
}
# Half a 95 % interval in standard deviations.
HALF_95 = 1.96


def with_as_built(drive: Drive, found: tuple[AsBuilt, ...]) -> Drive:
    """``drive`` as built: each entry of ``found`` changes a value and widens its sigma, or is kept for the loop."""
    for entry in found:
        if entry.form in CHANGE_VALUES.get(entry.name, ()):
            share = next(value for value in entry.values if value.name == "share")
            drive = _CHANGES[entry.name](drive, entry, share)
        else:
            drive = replace(drive, as_built=(*drive.as_built, entry))
    return drive


def _widened(sigma: float, value: float, share: AsBuiltValue) -> float:
    """Standard deviation of ``value * (1 + share)``, ``value`` with ``sigma``."""
    own = 0.0 if share.low is None or share.high is None else (share.high - share.low) / (2.0 * HALF_95)
    return float(((sigma * (1.0 + share.value)) ** 2 + (value * own) ** 2) ** 0.5)


def _modulus(drive: Drive, _: AsBuilt, share: AsBuiltValue) -> Drive:
    value = drive.cable.modulus_GPa
    sigmas = replace(drive.sigmas, modulus_GPa=_widened(drive.sigmas.modulus_GPa, value, share))
    return replace(drive, cable=replace(drive.cable, modulus_GPa=value * (1.0 + share.value)), sigmas=sigmas)


def _preload(drive: Drive, entry: AsBuilt, share: AsBuiltValue) -> Drive:
    cables, sigmas = [], []
    for cable, sigma in zip(drive.cables, drive.sigmas.preload_N, strict=True):
        has_it = not entry.cables or cable.name in entry.cables
        cables.append(replace(cable, preload_N=cable.preload_N * (1.0 + share.value)) if has_it else cable)
        sigmas.append(_widened(sigma, cable.preload_N, share) if has_it else sigma)
    return replace(drive, cables=tuple(cables), sigmas=replace(drive.sigmas, preload_N=tuple(sigmas)))


def _friction(drive: Drive, _: AsBuilt, share: AsBuiltValue) -> Drive:
    value = drive.friction_coefficient
    sigmas = replace(drive.sigmas, friction_coefficient=_widened(drive.sigmas.friction_coefficient, value, share))
    return replace(drive, friction_coefficient=value * (1.0 + share.value), sigmas=sigmas)


_CHANGES = {"stiffness_error": _modulus, "preload_error": _preload, "cable_friction": _friction}
