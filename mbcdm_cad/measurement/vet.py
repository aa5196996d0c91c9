"""Vetting: read runs, compare them with the design before anything is predicted, and find what they can show.

A measurement file need not give the zeros of the input encoders: a counter begins anywhere. The cables are strained by
the difference of the inputs, and wound by their angle. Where the difference of the columns would take more than a
share of the preload from a cable, or the angle lies outside the travel, it is the counters' and not the drive's.
"""

from collections.abc import Sequence
from dataclasses import dataclass, replace

import numpy as np

from mbcdm_cad.design.drive import Drive
from mbcdm_cad.errors import InputError, Problem
from mbcdm_cad.layouts.registry import layout_of
from mbcdm_cad.measurement.file import MeasurementFile
from mbcdm_cad.measurement.kinds import Declared, kind_of
from mbcdm_cad.measurement.loads import figures_of, parts_seen, with_motors_load
from mbcdm_cad.measurement.reading import read_run
from mbcdm_cad.measurement.run import Run, VettingNote, ZerosFound, doubts, fact, gravest_first, refused
from mbcdm_cad.measurement.schema import CREEP
from mbcdm_cad.measurement.vet_signals import FEWEST_HALF_SWEEPS
from mbcdm_cad.model.creep import creep_a_decade
from mbcdm_cad.model.si import DriveSI
from mbcdm_cad.routes.route import input_body

# A difference of the inputs that changes the tension of a cable by this share of its preload is taken for one of zeros.
STRAINED_SHARE = 0.5
# Angles beyond this multiple of the half travel are taken for those of a counter.
BEYOND = 1.2


def zeroed(run: Run, d: DriveSI, half_travel_rad: float) -> Run:
    """The run with zeros of its inputs from the data where those of the file are impossible; else the run itself.

    The inputs then agree in the median over the run, since servos follow their targets on average, and the middle of
    their range is angle zero. ``half_travel_rad``: of the drum.
    """
    angle = run.input_rad
    common = angle.mean(axis=0)
    apart = angle - common
    typical = np.median(apart, axis=1, keepdims=True)
    stretch = float(np.min(d.preload_N * d.free_span_m / d.input_radius_m)) / float(d.axial_stiffness_N)
    zeros = float(np.ptp(typical)) if angle.shape[0] > 1 else 0.0
    unsure = float(np.quantile(np.abs(apart - typical), 0.99))
    if zeros <= 2.0 * STRAINED_SHARE * stretch:
        zeros, unsure, typical = 0.0, 0.0, np.zeros_like(typical)
    middle = 0.5 * float(common.min() + common.max())
    centre = middle if np.abs(common).max() > BEYOND * half_travel_rad * float(np.mean(d.total_ratio)) else 0.0
    if not zeros and not centre:
        return run
    return replace(run, input_rad=angle - typical - centre, zeros=ZerosFound(zeros, unsure, centre))


# Columns of these names are the inputs at -x and at +x of a design that gives its inputs other names.
SIDES = {"left": -1, "right": 1}


def declared_of(run: Run, drive: Drive | None) -> Declared:
    """The drive with which this run is compared. A run with its own ``ratio`` is of another drive."""
    if run.ratio is not None:
        return Declared(run.ratio, None, None)
    if drive is None:
        raise ValueError("a run without a ratio of its own needs a drive")
    d = layout_of(drive).si
    travel = 2.0 * np.radians(drive.half_travel_deg + drive.stop_clearance_deg)
    return Declared(float(np.mean(d.total_ratio)), d, float(travel), drive.reduction.ratio)


def arranged(run: Run, drive: Drive) -> Run:
    """The run with its inputs as in the design, angles after the gearhead, and with the figures of the parts.

    Inputs are identified by name, else left and right by their side.
    """
    if not run.input_rad.size:
        still = np.zeros((len(drive.input_names), run.time_s.size))
        run = replace(run, input_rad=still, input_names=drive.input_names)
    if run.kind == CREEP:
        run = replace(run, expected_creep=creep_a_decade(drive.cable))
    if run.counted is not None:
        at = run.counted.inputs_at
        motors = any(run.motor_side) if at is None else at == "motors"
        run = replace(run, parts=parts_seen(drive, run.counted, motors))
    run = _after_gearhead(run, drive.reduction.ratio)
    run = zeroed(run, layout_of(drive).si, float(np.radians(drive.half_travel_deg)))
    run = _in_order(run, drive)
    turns = layout_of(drive).si.input_turns
    return with_motors_load(run, drive, turns) if turns.size == run.input_rad.shape[0] else run


def _in_order(run: Run, drive: Drive) -> Run:
    """The run with its inputs in the order of the design."""
    names = run.input_names
    if sorted(names) == sorted(drive.input_names):
        rows = [names.index(name) for name in drive.input_names]
    elif sorted(names) == sorted(SIDES):
        bodies = {body.name: body for body in layout_of(drive).routed.routes.bodies}
        sides = [int(np.sign(bodies[input_body(name)].point_m[0])) for name in drive.input_names]
        if sorted(sides) != sorted(SIDES.values()):
            return run
        rows = [[SIDES[name] for name in names].index(side) for side in sides]
    else:
        return run
    if rows == list(range(len(rows))):
        return run
    current = None if run.current_A is None else run.current_A[rows]
    named = tuple(names[row] for row in rows)
    return replace(run, input_rad=run.input_rad[rows], input_names=named, current_A=current)


def _after_gearhead(run: Run, gearhead_ratio: float) -> Run:
    """Angles and steps of encoders on the motors turned into those of the inputs' own shafts."""
    if not any(run.motor_side):
        return run
    ratios = np.where(run.motor_side, gearhead_ratio, 1.0)

    def behind(step_rad: float | None) -> float | None:
        # The coarsest step of several; the step of an encoder that is not on a motor does not change.
        return None if step_rad is None else step_rad / float(ratios.min())

    sensors = replace(
        run.sensors,
        input_resolution_rad=behind(run.sensors.input_resolution_rad),
        input_noise_rad=behind(run.sensors.input_noise_rad),
    )
    return replace(run, input_rad=run.input_rad / ratios[:, None], sensors=sensors, motor_side=())


def vet(run: Run, drive: Drive | None) -> list[VettingNote]:
    """All findings, refusals first. The columns are not compared if the inputs do not fit the drive."""
    known = declared_of(run, drive)
    return _inputs(run, known) or gravest_first(kind_of(run).findings(run, known))


def refusals(findings: list[VettingNote]) -> list[VettingNote]:
    """The findings because of which the run cannot be judged."""
    return [finding for finding in findings if finding.level == "refused"]


def _inputs(run: Run, known: Declared) -> list[VettingNote]:
    count = run.input_rad.shape[0]
    if known.d is None:
        return []
    names = ", ".join(known.d.input_names)
    text = f"the run has {count} input column(s), the design {known.d.n_inputs} ({names})"
    remedy = "give a column for each input of the design, or ratio for a drive of which only that is known"
    if known.d.n_inputs == count:
        if count == 1 or sorted(run.input_names) in (sorted(known.d.input_names), sorted(SIDES)):
            return []
        text = f"inputs {', '.join(run.input_names)} are not those of the design ({names})"
        remedy = "call the columns input_ and the name that the design file gives each input"
    return [refused("inputs", text, remedy, "columns")]


@dataclass(frozen=True, eq=False)
class Vetted:
    """A run that can be judged: its measurement file, the notes of its reading, the findings of its vetting."""

    file: MeasurementFile
    run: Run
    notes: tuple[str, ...]
    findings: tuple[VettingNote, ...]

    @property
    def doubts(self) -> list[str]:
        """Reasons to doubt the finding."""
        return doubts(self.notes, self.findings)


def vetted_runs(files: Sequence[MeasurementFile], drive: Drive | None) -> list[Vetted]:
    """All runs, read and vetted. Raises InputError with the refusals of all of them."""
    vetted: list[Vetted] = []
    problems: list[Problem] = []
    for file in files:
        reading = read_run(file)
        motor = reading.run.motor
        if motor is not None and drive is not None and figures_of(motor, drive).torque_constant_Nm_A is None:
            remedy = "give torque_constant_Nm_A: 60 / (2 pi Kv) of the data sheet"
            what = f"no torque constant, and {drive.motor.name} has none"
            problems.append(file.problem(("motor",), what, remedy=remedy))
        if problems:
            continue
        ratio = np.full(reading.run.input_rad.shape[0], reading.run.ratio or 1.0)
        run = with_motors_load(reading.run, None, ratio) if drive is None else arranged(reading.run, drive)
        findings = [*vet(run, drive), *(fact("turns", words) for words in reading.turns)]
        problems += [file.problem(f.field, f.text, remedy=f.remedy) for f in refusals(findings)]
        for one in vetted:
            if one.run.sha256 == run.sha256:
                what, remedy = f"the same data as {one.file.path}", "give each run once: a copy is no new evidence"
                problems.append(file.problem(("data",), what, run.source, remedy=remedy))
        vetted.append(Vetted(file, run, reading.notes, tuple(findings)))
    if problems:
        raise InputError(problems)
    return repeated(vetted)


def repeated(vetted: list[Vetted]) -> list[Vetted]:
    """The runs without the doubt of too few half sweeps, where several short runs repeat each other."""
    if not all(kind_of(one.run).moves for one in vetted):
        return vetted
    counts = [int(one.run.half_sweep.max()) + 1 for one in vetted]
    if len(vetted) < 2 or sum(counts) - len(counts) < FEWEST_HALF_SWEEPS or min(counts) < 2:
        return vetted
    return [replace(one, findings=tuple(f for f in one.findings if f.kind != "one_sweep")) for one in vetted]


def vetting_lines(one: Vetted) -> list[str]:
    """The run and what it can show, one sentence on each line, doubts first."""
    lines = [f"{one.file.path}: {one.run.time_s.size} samples of {one.run.source}"]
    lines += [f"  doubt: {words}" for words in one.doubts]
    return lines + [f"  run: {finding}" for finding in one.findings if finding.level == "fact"]
