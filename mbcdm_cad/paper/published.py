"""Published figures compared with the declared model: predicted, measured, possible causes; as one HTML page.

Candidates marked ``+`` are plausible (within the bounds below, estimates); a single figure cannot decide between them.
"""

from collections.abc import Callable
from dataclasses import asdict, dataclass
from importlib.resources import files
from typing import Any

import numpy as np
import yaml
from scipy.optimize import brentq

from mbcdm_cad.design.drive import Drive
from mbcdm_cad.errors import InputError
from mbcdm_cad.layouts.registry import layout_of
from mbcdm_cad.loop.readable import readable
from mbcdm_cad.measurement.file import MeasurementFile
from mbcdm_cad.measurement.logformat import Unit, unit_of
from mbcdm_cad.measurement.schema import Published
from mbcdm_cad.model.capability import MOTOR, balanced_preload_N, input_ratings_Nm, torque_at_input_limit_Nm
from mbcdm_cad.model.profiles import simulate_profiles
from mbcdm_cad.model.si import DriveSI
from mbcdm_cad.model.stiffness import drum_backlash
from mbcdm_cad.report.page.template import page_environment
from mbcdm_cad.report.table import rendered

# Plausible relative deviation of preload, modulus and friction from the declared values (estimates).
PRELOAD_SHARE, MODULUS_SHARE, FRICTION_SHARE = 0.3, 0.15, 0.5
# Plausible share of the load on the input that carries more of it.
MOST_SHARE = 0.65
# Highest multiple of a shaft's turn that is compared: above it, some multiple is near any order.
MOST_TIMES = 8
SEARCHED = (0.3, 3.0)
WINDING_SAMPLES = 400


@dataclass(frozen=True)
class Candidate:
    """One possible cause. ``effect`` is its name in the vocabulary, None for a cause that is no effect of a run.

    ``needed``: the size with which it alone explains the difference; ``predicted``: the model's figure with this cause
    (SI; None if its size is free); ``plausible``: whether the needed size, or the figure, is usual for such a part.
    """

    cause: str
    effect: str | None
    needed: str
    predicted: float | None
    plausible: bool


@dataclass(frozen=True)
class Judged:
    """One published figure, SI. ``predicted`` is None if the declared model does not contain it."""

    quantity: str
    where: str
    unit: str
    measured: float
    predicted: float | None
    stated_theory: float | None
    candidates: tuple[Candidate, ...]
    told_apart_by: str
    remark: str

    @property
    def residual(self) -> float | None:
        """Measured minus predicted."""
        return None if self.predicted is None else self.measured - self.predicted


# Of each cause in the order of causes.yaml: what is needed, the model's figure with it, whether it is plausible.
Causes = list[tuple[str, float | None, bool]]
# The declared model's figure, its causes, and the figures that the words in causes.yaml name.
Found = tuple[float | None, Causes, dict[str, float]]
Judge = Callable[[Drive, DriveSI, Published, float], Found]


def _peak_torque(drive: Drive, d: DriveSI, item: Published, measured: float) -> Found:
    """Load torque at which the first input reaches its motor's limit, in the weaker direction."""
    lossless = input_ratings_Nm(drive)[MOTOR]
    lossy = lossless * drive.gearhead.efficiency

    def limit(d: DriveSI, rating: float) -> float:
        return float(min(torque_at_input_limit_Nm(d, rating, way).min() for way in (1, -1)))

    def of_preload(share: float) -> float:
        return limit(d.with_(preload_N=d.preload_N * share), lossless) - measured

    weaker = limit(d, lossless)
    stronger = float(max(torque_at_input_limit_Nm(d, lossless, way).min() for way in (1, -1)))
    even = limit(d.with_(preload_N=balanced_preload_N(d)), lossless)
    ideal = float(sum(lossless * d.total_ratio[d.input_of.index(i)] for i in range(d.n_inputs)))
    busiest = ideal / d.n_inputs / measured
    needed, plausible = _preload_words(d, _root(of_preload))
    shared = bool(1.0 / d.n_inputs < busiest < MOST_SHARE)
    causes: Causes = [
        (needed, weaker, plausible),
        ("no free size", even, False),
        (
            f"efficiency {lossy / lossless * measured / limit(d, lossy):.2f}; the data sheet states "
            f"{lossy / lossless:.2f}",
            limit(d, lossy),
            bool(measured <= limit(d, lossy) * 1.15),
        ),
        (f"one input carries {busiest:.0%} of the load", None, shared),
    ]
    return weaker, causes, {"weaker": weaker, "stronger": stronger, "ideal": ideal}


def _backlash(drive: Drive, d: DriveSI, item: Published, measured: float) -> Found:
    """The swing of the drum at a reversal of the load, inputs locked."""
    load = item.conditions.load_torque_Nm or drive.loads.test_torque_Nm
    drum = drum_backlash(d, load)
    swing, single = float(drum.reversal_swing_rad), float(drum.first_loading_rad)
    modulus = float(d.modulus_Pa)

    def of(change: Callable[[float], DriveSI]) -> Callable[[float], float]:
        return lambda share: float(drum_backlash(change(share), load).reversal_swing_rad) - measured

    preload = _root(of(lambda share: d.with_(preload_N=d.preload_N * share)))
    friction = _root(of(lambda share: d.with_(friction_coefficient=d.friction_coefficient * share)))
    stiff = swing / measured
    preload_words, preload_plausible = _preload_words(d, preload)
    friction_words = _share_words("mu", float(d.friction_coefficient), friction, "")
    causes: Causes = [
        (f"E = {stiff * modulus / 1e9:.1f} GPa instead of {modulus / 1e9:.1f}", None, abs(stiff - 1.0) < MODULUS_SHARE),
        (preload_words, None, preload_plausible),
        (friction_words, None, friction is not None and abs(friction - 1.0) < FRICTION_SHARE),
        (
            f"E = {single / measured * modulus / 1e9:.1f} GPa, lower than that of such a rope",
            single,
            abs(single / measured - 1.0) < MODULUS_SHARE,
        ),
    ]
    travel = item.conditions.half_travel_rad
    if travel is not None:
        wound = swing * _winding_factor(d, load, travel)
        words = f"with it, E = {wound / measured * modulus / 1e9:.1f} GPa"
        causes.append((words, wound, abs(wound / measured - 1.0) < MODULUS_SHARE))
    return swing, causes, {}


def _ripple_amplitude(drive: Drive, d: DriveSI, item: Published, measured: float) -> Found:
    """Ripple of the transmission error; the declared model has none."""
    step = drive.encoder.resolution_urad * 1e-6 / _ratio(d)
    stages = f"{measured * _ratio(d) * 1e6:.0f} urad on the input shafts"
    steps = f"{measured / step:.2f} of its steps, which is {step * 1e6:.1f} urad at the drum"
    return 0.0, [(stages, None, True), (steps, None, bool(measured < 2.0 * step))], {}


def _ripple_order(drive: Drive, d: DriveSI, item: Published, measured: float) -> Found:
    """Order of the ripple, with the axis as printed (per rad) and as if it were per turn."""
    motor = _ratio(d) * drive.gearhead.ratio
    shafts = {
        "drum": 1.0,
        **{body.name: abs(body.turns_per_drum) for body in d.routes.passed},
        "input": _ratio(d),
        "motor": motor,
    }
    travel = item.conditions.half_travel_rad
    bin_per_turn = 2.0 * np.pi / (2.0 * travel) if travel else None
    causes: Causes = []
    for per_turn in (measured * 2.0 * np.pi, measured):
        lines = [(name, times, times * order) for name, order in shafts.items() for times in range(1, MOST_TIMES + 1)]
        shaft, times, turns = min(lines, key=lambda line: abs(line[2] - per_turn))
        off = per_turn - turns
        bins = "" if bin_per_turn is None else f", {abs(off) / bin_per_turn:.2f} of a bin of {bin_per_turn:.0f}"
        words = f"{per_turn:.1f} a turn; nearest {times} times the {shaft}'s turn, {turns:.1f}: {off:+.1f} off{bins}"
        causes.append((words, None, bin_per_turn is not None and abs(off) < bin_per_turn))
    return None, causes, {"per_motor": measured * 2.0 * np.pi / motor}


JUDGES: dict[str, Judge] = {
    "peak_torque": _peak_torque,
    "mass": lambda drive, d, item, measured: (None, [], {}),  # the build computes it, a run cannot measure it
    "backlash": _backlash,
    "ripple_amplitude": _ripple_amplitude,
    "ripple_order": _ripple_order,
}


def together(figures: tuple[Judged, ...]) -> tuple[str, ...]:
    """Conclusions from several figures that none of them gives alone."""
    by_name = {figure.quantity: figure for figure in figures}
    lines = []
    if {"peak_torque", "backlash"} <= by_name.keys():
        words = {
            name: next(c.needed for c in by_name[name].candidates if c.effect == "preload_error")
            for name in ("peak_torque", "backlash")
        }
        lines.append(
            f"preload alone does not explain both: it needs {words['peak_torque']} for the torque, but "
            f"{words['backlash']} for the backlash"
        )
    if {"peak_torque", "mass"} <= by_name.keys():
        torque, mass = by_name["peak_torque"], by_name["mass"]
        lines.append(f"torque to weight {torque.measured / mass.measured:.3f} N m/kg")
    return tuple(lines)


def _winding_factor(d: DriveSI, load: float, travel: float) -> float:
    """Factor by which winding history increases the swing at the end of the second sweep, brake against the motion."""
    phase = np.linspace(0.0, 5.0 * np.pi, 5 * WINDING_SAMPLES // 2)
    angle = np.tile(_ratio(d) * travel * np.sin(phase), (d.n_inputs, 1))
    torque = load * np.tanh(np.cos(phase) / 0.02)

    def width(winding: bool) -> float:
        error = simulate_profiles(d, angle, torque, winding=winding).drum_angle_rad - angle[0] / _ratio(d)
        steady = error[phase > np.pi]
        return float(np.ptp(steady))

    return width(True) / width(False)


def _ratio(d: DriveSI) -> float:
    return float(np.mean(d.total_ratio))


def _root(of: Callable[[float], float]) -> float | None:
    """The share within SEARCHED at which a function is zero; None if there is none."""
    low, high = SEARCHED
    grid = np.geomspace(low, high, 13)
    values = [of(float(share)) for share in grid]
    for a, b, fa, fb in zip(grid[:-1], grid[1:], values[:-1], values[1:], strict=True):
        if np.isfinite(fa) and np.isfinite(fb) and fa * fb <= 0.0:
            return float(brentq(of, a, b, rtol=1e-6))
    return None


def _share_words(name: str, declared: float, share: float | None, unit: str) -> str:
    suffix = f" {unit}" if unit else ""
    if share is None:
        return f"no {name} from {SEARCHED[0]:g} to {SEARCHED[1]:g} times the declared one explains the difference"
    return f"{name} = {share * declared:.3g}{suffix} instead of {declared:.3g}{suffix}"


def _preload_words(d: DriveSI, share: float | None) -> tuple[str, bool]:
    words = _share_words("preload", float(np.mean(d.preload_N)), share, "N")
    return words, share is not None and abs(share - 1.0) < PRELOAD_SHARE


# Ending of a name from which `readable` takes the unit.
ENDINGS = {"rad": "_rad", "N m": "_Nm"}


@dataclass(frozen=True)
class PublishedResult:
    """All figures of one file, and the conclusions from several of them."""

    source: str
    figures: tuple[Judged, ...]
    together: tuple[str, ...]

    def to_json(self) -> dict[str, Any]:
        """The result file: the form of every loop's result, with the figures under ``published``."""
        sets = [[{"name": c.effect} for c in figure.candidates if c.effect and c.plausible] for figure in self.figures]
        return {
            "verdict": "not_testable",
            "effects": [],
            "one_of": [list({item["name"]: item for item in named}.values()) for named in sets if named],
            "unknown": None,
            "error": None,
            "published": [asdict(figure) | {"residual": figure.residual} for figure in self.figures],
            "together": list(self.together),
        }

    def text(self) -> str:
        """The result as text."""
        return rendered("told.txt.j2", "mbcdm_cad.paper", shown=shown, **vars(self)).removesuffix("\n")


def judge_published(drive: Drive, file: MeasurementFile) -> PublishedResult:
    """Compare the model of ``drive`` with the published figures. Raises InputError for a file of another kind."""
    if file.content.published is None:
        remedy = "use a file with published figures"
        raise InputError([file.problem(("data",), "contains a run, not published figures", remedy=remedy)])
    told = yaml.safe_load(files("mbcdm_cad.paper").joinpath("causes.yaml").read_text("utf-8"))
    figures = []
    for item in file.content.published:
        d = layout_of(drive).si
        if item.conditions.preload_N is not None:
            d = d.with_(preload_N=np.full(d.n_cables, item.conditions.preload_N))
        unit = unit_of(item.quantity, item.unit) or Unit(1.0)
        measured, stated = item.value * unit.factor, item.stated_theory
        predicted, causes, words = JUDGES[item.quantity](drive, d, item, measured)
        said = told[item.quantity]
        candidates = tuple(
            Candidate(row["cause"], row.get("effect") or (plausible and row.get("effect_if_plausible")) or None, *found)
            for row, found in zip(said["causes"], causes, strict=False)
            for plausible in found[2:]
        )
        figures.append(
            Judged(
                item.quantity,
                item.where,
                said["unit"],
                measured,
                predicted,
                None if stated is None else stated * unit.factor,
                candidates,
                said["told_apart_by"].format(**words),
                said["remark"].format(**words),
            )
        )
    return PublishedResult(file.path.name, tuple(figures), together(tuple(figures)))


def shown(figure: Judged, value: float | None) -> str:
    """A value in a readable unit; empty for None."""
    if value is None:
        return ""
    if figure.unit in ENDINGS:
        return readable(figure.quantity + ENDINGS[figure.unit], [value])[1][0]
    return f"{value:.4g} {figure.unit}"


def published_page(result: PublishedResult, design: str) -> bytes:
    """Published figures compared with the model as one HTML page, without pictures or other files."""
    template = page_environment(("mbcdm_cad.paper", ".")).get_template("published.html.j2")
    told = {"source": result.source, "figures": result.figures, "together": result.together}
    return template.render(design=design, shown=shown, **told).encode()
