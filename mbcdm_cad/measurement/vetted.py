"""Read runs from their measurement files, order their inputs as in the design, and vet them."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

from mbcdm_cad.design.drive import Drive
from mbcdm_cad.errors import InputError
from mbcdm_cad.measurement.file import MeasurementFile
from mbcdm_cad.measurement.reading import read_run
from mbcdm_cad.measurement.run import Run, VettingNote, doubts
from mbcdm_cad.measurement.vet import arranged, refusals, vet


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
    problems = []
    for file in files:
        reading = read_run(file)
        run = reading.run if drive is None else arranged(reading.run, drive)
        findings = vet(run, drive)
        problems += [file.problem(f.field, f.text, remedy=f.remedy) for f in refusals(findings)]
        for one in vetted:
            if one.run.sha256 == run.sha256:
                what, remedy = f"the same data as {one.file.path}", "give each run once: a copy is no new evidence"
                problems.append(file.problem(("data",), what, run.source, remedy=remedy))
        vetted.append(Vetted(file, run, reading.notes, tuple(findings)))
    if problems:
        raise InputError(problems)
    return vetted


def vetting_lines(one: Vetted) -> list[str]:
    """The run and what it can show, one sentence on each line, doubts first."""
    lines = [f"{one.file.path}: {one.run.time_s.size} samples of {one.run.source}"]
    lines += [f"  doubt: {words}" for words in one.doubts]
    return lines + [f"  run: {finding}" for finding in one.findings if finding.level == "fact"]
