"""The report of the model on one design: figures and cable paths as text for a terminal, as JSON, as a table.

The command line prints it, the Python API returns it.
"""

from __future__ import annotations

from collections.abc import Iterable, Iterator, Mapping, Sequence
from dataclasses import asdict, dataclass, field, fields
from typing import TYPE_CHECKING, Any

from mbcdm_cad.layouts.base import Layout, NoFigureError
from mbcdm_cad.layouts.registry import layout_of
from mbcdm_cad.layouts.turns import Modes, modes_of
from mbcdm_cad.model.analysis import analyse
from mbcdm_cad.model.equations import papers_test
from mbcdm_cad.model.figures import Analysis, ShaftTurns
from mbcdm_cad.report.check_report import Chance, chance_lines, chances_of
from mbcdm_cad.report.duty import DutyReport, LifeReport, duty_report, life_report
from mbcdm_cad.report.losses import LossesReport, losses_report, stage_figures, stage_lines
from mbcdm_cad.report.preload import PreloadShares, preload_shares
from mbcdm_cad.report.structure import StructureReport, path_data_or_reason, path_lines, structure_report
from mbcdm_cad.report.table import ReportTable, TextReport, filled, speed_shown

if TYPE_CHECKING:
    import pandas

    from mbcdm_cad.design.blocks import AsBuilt
    from mbcdm_cad.design.drive import Drive
    from mbcdm_cad.model.capability import TorqueLimit

# Names of the limits of the drum's torque, by cause.
_LIMITS = {
    "motor": "motor, without losses",
    "motor_with_losses": "motor, all losses counted",
    "gearhead_rated": "gearhead, continuous",
    "gearhead_maximum": "gearhead, intermittent",
    "motor_alone": "motor, continuous",
    "motor_alone_peak": "motor, short-time",
    "strength": "cable at its allowed tension",
    "slack": "a cable goes slack",
    "slip": "the cable slips on its input",
}


@dataclass(frozen=True)
class AnalysisReport(TextReport):
    """``figures`` of the analytic model; ``paths`` of the cables as plain data, None where ``no_paths`` says why.

    ``structure``: what turns the payload besides the cables; None where ``no_structure`` says why; ``modes`` as well.
    ``losses``: friction between motors and payload. ``life``: of the cables; None where ``no_life`` says why.
    ``preload``: what it is made of; None where ``no_preload`` says why. ``duty``: what the drive does all day, how warm
    its motors get.
    """

    figures: Analysis
    paths: dict[str, Any] | None
    no_paths: str
    structure: StructureReport | None
    no_structure: str
    modes: Modes | None
    no_modes: str
    losses: LossesReport
    life: LifeReport | None
    no_life: str
    preload: PreloadShares | None
    no_preload: str
    duty: DutyReport
    layout: Layout = field(repr=False)
    chances: tuple[Chance, ...] = ()

    def to_dict(self) -> dict[str, Any]:
        """Everything, ready for JSON; this is what ``mbcdm analyse --json`` prints."""
        blocks: dict[str, Any] = {
            "paths": self.paths,
            "structure": self.structure and self.structure.to_dict(),
            "modes": self.modes and asdict(self.modes),
            "losses": self.losses.to_dict(),
            "duty": self.duty.to_dict(),
            "life": self.life and self.life.to_dict(),
            "preload": self.preload and self.preload.to_dict(),
        }
        if self.layout.first_stage_unit is not None:
            blocks["stages"] = [asdict(one) for one in stage_figures(self.layout)]
            blocks["first_stage"] = analyse_design(self.layout.first_stage_unit.drive).to_dict()
        if self.chances:
            blocks["as_built"] = {one.check: one.probability for one in self.chances}
        return self.figures.to_dict() | blocks

    def to_pandas(self) -> pandas.DataFrame:
        """The figures of each cable at the test torque, one row a cable. ``MbcdmError`` without pandas."""
        return self._cables().pandas()

    def text(self, width: int | None = None) -> str:
        """What ``mbcdm analyse`` prints: figures by subject, no line longer than ``width``."""
        lines = [line for block in self._blocks(width) for line in (*block, "")]
        paths = path_lines(self.layout, self.paths) if self.paths else [f"Cable paths: {self.no_paths}"]
        odds = ["", *chance_lines(self.chances)] if self.chances else []
        return "\n".join([*lines, *(line for text in (*paths, *odds) for line in filled(text, width))])

    def html(self) -> str:
        """For notebooks: the cables, the load cases, the torque limits."""
        tables = (self._cables(), self._cases(), self._shares(), self._limits())
        return f"<p>{self.figures.name}</p>" + "".join(table.html() for table in tables)

    def _cables(self) -> ReportTable:
        names = [field.name for field in fields(self.figures.cables[0])]
        rows = tuple(tuple(getattr(cable, name) for name in names) for cable in self.figures.cables)
        return ReportTable(tuple(names), rows)

    def _cases(self) -> ReportTable:
        rows = tuple(
            (
                f"{case.load_Nm:+.2f}",
                f"{case.turn_mrad:+.4f}",
                f"{case.tangent_stiffness_Nm_rad:.0f}",
                f"{case.secant_stiffness_Nm_rad:.0f}",
            )
            for case in (*self.figures.test, *self.figures.peak)
        )
        return ReportTable(("load N m", "turn mrad", "stiffness at the load N m/rad", "from zero N m/rad"), rows)

    def _shares(self) -> ReportTable:
        rows = tuple(
            (
                f"{case.load_Nm:+.2f}",
                _list(case.load_share, 3),
                _list(case.input_torque_mNm, 1),
                _list(case.tension_N) + (f"; {sum(case.slack)} slack" if any(case.slack) else ""),
            )
            for case in (*self.figures.test, *self.figures.peak)
        )
        return ReportTable(("load N m", "shares of the inputs", "inputs mN m", "tensions N"), rows)

    def _limits(self) -> ReportTable:
        names, left_out = _LIMITS, ""
        if self.layout.first_stage_unit is not None:
            names, left_out = _LIMITS | {"gearhead_rated": "first stage, torque it is made for"}, "gearhead_maximum"
        causes = [c for c in dict.fromkeys(limit.cause for limit in self.figures.limits) if c != left_out]
        ways = [[x for x in self.figures.limits if x.direction == way] for way in (1, -1)]
        rows = []
        for cause in causes:
            plus, minus = (next(limit for limit in way if limit.cause == cause) for way in ways)
            rows.append((names.get(cause, cause), _limit(plus), _limit(minus)))
        return ReportTable(("limit", "load +", "load -"), tuple(rows))

    def _blocks(self, width: int | None) -> Iterator[list[str]]:
        a = self.figures
        yield [
            *filled(
                f"{a.name}: E = {a.modulus_GPa:g} GPa on the {a.modulus_area} area {a.area_mm2:.4f} mm^2, "
                f"EA = {a.axial_stiffness_kN:.2f} kN, mu = {a.friction_coefficient:g}",
                width,
            ),
            *(line for text in _model_notes(a, self.structure) for line in filled(text, width)),
        ]
        drum, *shafts = dict.fromkeys(shaft for t in a.shaft_turns for shaft in t.turned_deg)
        turns = tuple((t.cable_name, *(_turned(t, shaft) for shaft in shafts)) for t in a.shaft_turns)
        yield [
            f"Turns of the shafts when the {drum} turns by {a.shaft_turns[0].turned_deg[drum]:+g} deg, deg:",
            *ReportTable(("cable", *shafts), turns).text(width, "  "),
        ]
        cables = tuple(
            (
                c.name,
                c.input_name,
                f"{c.preload_N:.2f}",
                f"{c.free_span_mm:.2f}",
                f"{c.high_tension_N:.3f}",
                f"{c.low_tension_N:.3f}",
                f"{c.backlash_mrad:.5f}",
                f"{c.backlash_simplified_mrad:.5f}",
            )
            for c in a.cables
        )
        names = ("cable", "input", "preload N", "span mm", "high N", "low N", "backlash mrad", "simplified")
        yield [
            *filled(
                f"Each cable by the paper's formulas at {a.test[0].load_Nm:g} N m: Eq. (14), and simplified as in "
                "Eq. (16) to (20):",
                width,
            ),
            *ReportTable(names, cables).text(width, "  "),
        ]
        yield [
            "All cables together, inputs locked:",
            *self._cases().text(width, "  "),
            *self._shares().text(width, "  "),
            f"  swing at a reversal {a.reversal_swing_mrad:.4f} mrad",
        ]
        if self.structure is None:
            yield filled(f"No figures of the structure: {self.no_structure}", width)
        else:
            tables = self.structure.table(), self.structure.places()
            yield _part("Turn of the payload by cause, for a torque on it:", tables, self.structure.lines(), width)
        if both := list(stage_lines(self.layout, width)):
            yield both
        yield filled(f"No modes: {self.no_modes}" if self.modes is None else mode_words(self.modes), width)
        tables = self.losses.causes(), self.losses.efficiencies()
        title = "Losses while the drum moves, N m at the drum, by cause, under a load +:"
        yield _part(title, tables, self.losses.lines(), width)
        if self.life is None:
            yield filled(f"No life of the cables: {self.no_life}", width)
        else:
            title = "Bendings of each cable's weakest point in a cycle, and cycles until it breaks:"
            yield _part(title, (self.life.table(),), self.life.lines(), width)
        if self.preload is None:
            yield filled(f"No shares of the preload: {self.no_preload}", width)
        else:
            yield [
                *filled(self.preload.sentence(), width),
                *self.preload.table().text(width, "  "),
                *filled(f"  {self.preload.WORDS}", width),
            ]
        yield [
            "Torque at the drum at which a limit is reached first:",
            *self._limits().text(width, "  "),
            *(line for text in _torque_notes(a, self.layout.drive.mounted) for line in filled(text, width)),
        ]
        yield self.duty.text(width)
        if a.creep:
            days = (f"{day:.0f} days" for day in a.creep[0].days)
            left = tuple((f"{x.temperature_C:g} C", *(f"{share:.1%}" for share in x.share)) for x in a.creep)
            table = ReportTable(("at", *days), left)
            yield ["Share of the preload that is left between fixed ends:", *table.text(width, "  ")]
        if a.motor is not None:
            first, *rest = motor_lines(asdict(a.motor))
            yield [
                *filled(first, width),
                *(line for text in rest for line in filled(f"  {text}", width)),
                *curve_table(asdict(a.motor)).text(width, "  "),
            ]
        bearings = tuple(
            (
                f"{b.load_Nm:+.2f}",
                _list(b.input_radial_N, 1),
                *(text for p in b.passed for text in (f"{p.radial_N:.1f}", f"{p.moment_Nm:.3f}")),
                f"{b.drum_radial_N:.1f}",
            )
            for b in a.bearings
        )
        passed = (head for p in a.bearings[0].passed for head in (f"{p.body} N", f"{p.body} N m"))
        heads = ("load N m", "inputs N", *passed, "drum N")
        yield ["Bearing loads:", *ReportTable(heads, bearings).text(width, "  ")]
        if a.intervals:
            rows = tuple((x.name, x.unit, x.value, x.low, x.high, x.sigma) for x in a.intervals)
            yield [
                "95 % intervals from the sigmas in the design file:",
                *ReportTable(("figure", "unit", "value", "low", "high", "sigma"), rows).text(width, "  "),
            ]
        yield [line for note in a.notes for line in filled(f"note: {note}", width)]


def _part(title: str, tables: Iterable[ReportTable], notes: Iterable[str], width: int | None) -> list[str]:
    """A part of the text: its title, its tables, and sentences on them."""
    return [
        title,
        *(line for table in tables for line in table.text(width, "  ")),
        *(line for text in notes for line in filled(f"  {text}", width)),
    ]


def _turned(t: ShaftTurns, shaft: str) -> str:
    """Angle of a shaft of one cable's chain as text; the motor's is large and needs fewer digits."""
    if shaft not in t.turned_deg:
        return ""
    return f"{t.turned_deg[shaft]:+.1f}" if shaft == "motor" else f"{t.turned_deg[shaft]:+.2f}"


def analyse_design(drive: Drive, found: Sequence[AsBuilt] = ()) -> AnalysisReport:
    """Every figure of the model, and the cables' paths. ``ModelError`` where the geometry leaves no free span.

    ``found``: the list ``as_built`` of the design's file, from which the probabilities of the checks follow.
    """
    paths, reason = path_data_or_reason(drive)
    layout = layout_of(drive)
    figures = analyse(layout)
    return AnalysisReport(
        figures,
        paths,
        reason,
        *structure_report(layout),
        *_modes(layout),
        losses_report(layout),
        *life_report(layout),
        *preload_shares(layout),
        duty_report(layout),
        layout,
        chances_of(drive, found),
    )


def _modes(layout: Layout) -> tuple[Modes | None, str]:
    try:
        return modes_of(layout), ""
    except NoFigureError as missing:
        return None, str(missing)


def _model_notes(a: Analysis, structure: StructureReport | None) -> Iterator[str]:
    if papers_test(a.test[0].load_Nm):
        readings = ", ".join(f"{r.modulus_GPa:.1f} GPa ({r.reading}, {r.route})" for r in a.implied_modulus)
        yield f"  the paper's {a.measured_backlash_mrad:g} mrad at 70 N, 0.91 N m implies E = {readings}"
        if structure is not None:
            yield f"  {structure.modulus_words()}"
    inputs = ", ".join(dict.fromkeys(c.input_name for c in a.cables))
    yield (
        f"  largest deviation from Eq. (1) {a.eq1_worst_residual:.3g}; over the travel the cables of a pair differ by "
        f"{_list(a.pair_mismatch_mm, 4)} mm ({inputs}), tensions change by up to {a.pair_mismatch_N:.2f} N"
    )


def _torque_notes(a: Analysis, mounted: str) -> Iterator[str]:
    yield (
        f"  peak torque + / -: {_list(a.peak_torque_lossless_Nm, 3)} N m without losses, as in the paper, "
        f"{_list(a.peak_torque_with_losses_Nm, 3)} N m with all losses; limits.losses puts the "
        f"{'second' if a.losses_counted else 'first'} in force"
    )
    for called, peaks in (
        ("peak torque without losses", a.peak_torque_lossless_Nm),
        ("peak torque with losses", a.peak_torque_with_losses_Nm),
    ):
        if above := above_gearhead(a.limits, mounted, called, peaks):
            yield f"  {above}"
    if min(a.peak_torque_Nm) > (asked := a.peak[0].load_Nm):
        yield f"  motor and cables allow these; the checks judge all other parts at the {asked:g} N m asked for"
    yield (
        f"  with preloads T ~ 1/r ({_list(a.balanced_preload_N)} N): {_list(a.balanced_peak_torque_Nm, 3)} N m; the "
        f"preload alone loads the inputs by {_list(a.input_bias_mNm, 1)} mN m"
    )
    if a.torque_to_weight_Nm_kg is not None:
        yield f"  torque to weight at the target mass: {a.torque_to_weight_Nm_kg:.3f} N m/kg"


def above_gearhead(limits: Sequence[TorqueLimit], mounted: str, called: str, peaks_Nm: tuple[float, float]) -> str:
    """A sentence on a peak torque (+, -), which motor and cables allow, above a rating of what is ``mounted``, or "".

    Limits that count losses stand beside a lossless peak where only these were worked out.
    """
    for cause, holds, why in (
        ("gearhead_maximum", "at most", "which forbids it"),
        ("gearhead_rated", "continuously", "so hold it for a short time only"),
    ):
        low = [
            (limit.torque_Nm, peaks_Nm[limit.direction < 0])
            for limit in limits
            if limit.cause == cause and limit.torque_Nm < peaks_Nm[limit.direction < 0] * (1.0 - 1e-9)
        ]
        if low:
            limit_Nm, peak_Nm = min(low)
            return (
                f"the {called}, {peak_Nm:.3f} N m, is above what the {mounted} holds {holds}, {limit_Nm:.3f} N m, {why}"
            )
    return ""


def _limit(limit: TorqueLimit) -> str:
    """``3.747 N m, left``; an infinite load means that the limit is never reached."""
    if limit.torque_Nm == float("inf"):
        return "not reached"
    return f"{limit.torque_Nm:.3f} N m, {limit.limiting}"


def _list(values: Sequence[float], digits: int = 2) -> str:
    return ", ".join(f"{v:.{digits}f}" for v in values)


def motor_lines(m: Mapping[str, Any]) -> tuple[str, ...]:
    """Sentences on ``analysis.motor``: its torque, the torque that the design requires, the inertia of its rotors."""
    return (
        f"Motor at {m['bus_voltage_V']:g} V: {m['continuous_torque_mNm']:.4g} mN m continuous with "
        f"{m['continuous_loss_W']:.3g} W lost in the copper, {m['peak_torque_mNm']:.4g} mN m short-time with "
        f"{m['peak_loss_W']:.3g} W; no load {m['no_load_speed_rad_s']:.4g} rad/s, which turns the drum at "
        f"{m['drum_no_load_speed_deg_s']:.4g} deg/s",
        f"At the required peak torque: {m['at_peak_load_torque_mNm']:.4g} mN m, {m['at_peak_load_current_A']:.3g} A, "
        f"{m['at_peak_load_loss_W']:.3g} W for each motor; the drum at most "
        f"{m['at_peak_load_drum_speed_deg_s']:.4g} deg/s",
        f"Rotors reflected to the drum {m['reflected_inertia_kg_m2'] * 1e3:.4g} g m^2",
    )


def mode_words(m: Modes) -> str:
    """The torsional modes, every wrap sticking."""
    payload = f"a payload of {m.payload_kg_m2:.4g} kg m^2" if m.payload_kg_m2 else "no payload"
    free = ", ".join(f"{f:.4g}" for f in m.inputs_free_Hz)
    return (
        f"Torsional modes with {payload}: lowest {m.lowest_inputs_held_Hz:.4g} Hz with the inputs held, by the cables "
        f"alone {m.cables_alone_Hz:.4g}; {free} Hz against the free rotors"
    )


def curve_table(m: Mapping[str, Any]) -> ReportTable:
    """Torque at the drum over its speed."""
    rows = tuple(
        (speed_shown(p["drum_speed_deg_s"]), f"{p['continuous_Nm']:.3f}", f"{p['peak_Nm']:.3f}") for p in m["curve"]
    )
    return ReportTable(("drum deg/s", "continuous N m", "short-time N m"), rows)
