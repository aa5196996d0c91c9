"""Compare the loop's result for a run with the truth, by the rules of the project's aims."""

from __future__ import annotations

from dataclasses import asdict, dataclass, field
from typing import Any

from bench_effects import Effect

# Outcomes from best to worst. For runs without an effect "none" is right, for causes outside the vocabulary "unknown".
OUTCOMES = ("exact", "set", "partial", "none", "unknown", "not_testable", "wrong set", "wrong", "error")


@dataclass
class Score:
    """One run judged. ``values`` holds (what, true, found, low, high) of the effects named rightly."""

    case: str
    seed: int
    group: str
    outcome: str
    said: str
    true: str
    before_rad: float | None = None
    after_rad: float | None = None
    floor_rad: float | None = None
    knowing_rad: float | None = None
    values: list[tuple[str, float, float, float | None, float | None]] = field(default_factory=list)
    seconds: float = 0.0
    note: str = ""

    def as_dict(self) -> dict[str, Any]:
        """For the store."""
        return asdict(self)


def label(effect: dict[str, Any] | Effect) -> str:
    """Short name with stage and cables, as in the tables."""
    if isinstance(effect, Effect):
        effect = effect.as_truth()
    parts = [str(effect["name"])]
    if effect.get("stage"):
        parts.append(str(effect["stage"]))
    cables = effect.get("cables")
    if cables and len(cables) < 4:
        parts.append("cable " + ",".join(str(c).removeprefix("cable_") for c in cables))
    return " ".join(parts)


def said_of(result: dict[str, Any]) -> str:
    """One line: names, sets in braces, or the verdict."""
    names = sorted(label(e) for e in result["effects"])
    names += sorted("{" + " | ".join(sorted(label(e) for e in one)) + "}" for one in result["one_of"])
    if result["verdict"] == "partly_explained" or (names and result["verdict"] == "unknown"):
        names.append("(+ unknown)")
    return " + ".join(names) if names else str(result["verdict"])


def same(said: dict[str, Any], effect: Effect) -> bool:
    """True when a name the loop gave is the effect. An eccentric pulley and an encoder of one stage share a name."""
    if said["name"] != effect.name:
        return False
    if effect.name == "once_per_rev":
        return bool(said.get("stage") == effect.stage)
    if effect.name == "preload_error":
        cables = sorted(int(str(c).removeprefix("cable_")) for c in said.get("cables") or (1, 2, 3, 4))
        return cables == sorted(j + 1 for j in effect.cables)
    # Play at the output has no stage of its own in the vocabulary.
    if effect.name == "lash" and effect.stage and said.get("stage"):
        return bool(said["stage"] == effect.stage)
    return True


def outcome_of(result: dict[str, Any], effects: tuple[Effect, ...]) -> str:
    """The outcome of a run with the effects that the vocabulary has; see OUTCOMES."""
    known = [effect for effect in effects if effect.in_vocabulary]
    left = list(known)
    for said in result["effects"]:
        hit = next((effect for effect in left if same(said, effect)), None)
        if hit is None:
            return "wrong"
        left.remove(hit)
    named = len(result["effects"])
    in_sets = 0
    for one in result["one_of"]:
        hit = next((effect for effect in left if any(same(said, effect) for said in one)), None)
        if hit is None:
            return "wrong set"
        left.remove(hit)
        in_sets += 1
    if known and not left:
        return "set" if in_sets else "exact"
    if named or in_sets:
        return "partial"
    return {"none": "none", "not_testable": "not_testable"}.get(str(result["verdict"]), "unknown")


# Where the loop reports what a cause's size is: (key of the truth, keys of the result in order of preference).
REPORTED: dict[str, tuple[tuple[str, tuple[str, ...]], ...]] = {
    "pulley": (("eccentricity_m", ("eccentricity_m",)),),
    "input_encoder": (("amplitude_rad", ("encoder_error_rad",)),),
    "output_encoder": (("amplitude_rad", ("amplitude_rad",)),),
    "radii": (("share", ("share",)),),
    "output_scale": (("share", ("share",)),),
    "modulus": (("share", ("share",)),),
    "preload": (("share", ("share",)),),
    "mu": (("share", ("share",)),),
    "shaft_compliance": (("compliance_rad_Nm", ("compliance_rad_Nm",)),),
    "bearing": (("torque_Nm", ("torque_Nm",)),),
    "viscous": (("drag_Nm_s", ("drag_Nm_s",)),),
    "anchor": (("slip_m", ("slip_m",)),),
    "latency": (("delay_s", ("delay_s",)),),
    "input_play": (("play_rad", ("play_rad",)),),
    "output_play": (("play_rad", ("play_rad",)),),
    "division": (("cycles_per_output_rev", ("cycles_per_output_rev",)), ("amplitude_rad", ("amplitude_rad",))),
    "warming": (("turn_rad_K", ("turn_rad_K",)),),
    "mount_jump": (("step_rad", ("step_rad",)), ("at_s", ("at_s",))),
}


def values_of(
    result: dict[str, Any], effects: tuple[Effect, ...]
) -> list[tuple[str, float, float, float | None, float | None]]:
    """True and found sizes, with the interval where one is given, of the effects named rightly."""
    found = []
    for effect in effects:
        said = next((e for e in result["effects"] if same(e, effect)), None)
        if said is None:
            continue
        figures = {**(said.get("physical") or {}), **(said.get("parameters") or {})}
        for key, names in REPORTED.get(effect.kind, ()):
            name = next((n for n in names if n in figures), None)
            if name is None:
                continue
            value = figures[name]
            low = high = None
            if isinstance(value, dict):
                low, high = value.get("ci95") or (None, None)
                value = value["value"]
            found.append((f"{effect.kind}.{key}", float(effect.size[key]), float(value), low, high))
    return found
