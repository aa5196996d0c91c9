"""The public interface of the package, ``import mbcdm_cad as mc``. Names in ``__all__`` are stable, others may change.

    import mbcdm_cad as mc

    design = mc.load("my_drive.yaml")
    wider = design.with_(transmission__centre_distance_mm=36.0)
    print(wider.check())
    print(wider.analyse().figures.reversal_swing_mrad)
    wider.part("drum")                      # a cadquery solid
    wider.build("out")

Each command of the command line is one of these functions or a method of :class:`DriveDesign`, and prints its result.
Results print themselves, are shown as tables in notebooks, and convert to plain data (``to_dict``); tables also to
frames (``to_pandas``), if pandas is installed.

The import is fast: the model, CAD and the loop are imported when they are first used.
"""

from mbcdm_cad.api.design import DriveDesign
from mbcdm_cad.api.designs import (
    MeasuredRun,
    analyse_many,
    catalogue,
    close_loop,
    compare,
    doctor,
    draft_measurement,
    judge_published,
    load,
    load_run,
    new_design,
    new_design_text,
    next_run,
    optimise,
    prices,
    reference_design,
    reproduce,
    schema,
    schema_page,
    solve,
    trend,
)
from mbcdm_cad.errors import InputError, MbcdmError
from mbcdm_cad.optimising import Effort

__all__ = [
    "load",
    "reference_design",
    "new_design",
    "new_design_text",
    "DriveDesign",
    "solve",
    "optimise",
    "Effort",
    "prices",
    "compare",
    "analyse_many",
    "load_run",
    "MeasuredRun",
    "close_loop",
    "next_run",
    "trend",
    "judge_published",
    "draft_measurement",
    "reproduce",
    "catalogue",
    "schema",
    "schema_page",
    "doctor",
    "MbcdmError",
    "InputError",
]
