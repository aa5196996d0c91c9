"""The correction table as files for a controller: CSV, JSON and a C header with the function that reads it."""

import json
from itertools import product

from mbcdm_cad.loop.correction import DIRECTIONS, Correction

CSV, JSON, HEADER = "correction.csv", "correction.json", "correction.h"
SIGN = "corrected output angle = mean of the input angles / total ratio + correction; angle 0 is the inputs' own zero"


def correction_files(found: Correction, source: str) -> dict[str, bytes]:
    """The three files by name; ``source`` names design and runs."""
    return {CSV: _csv(found, source), JSON: _json(found, source), HEADER: _header(found, source)}


def correction_words(found: Correction) -> str:
    """The accuracy of the table in words, for the terminal."""
    words = (
        f"error of the output angle on held-out half sweeps {1e6 * found.before_rad:.3g} urad RMS without and "
        f"{1e6 * found.after_rad:.3g} with it (noise {1e6 * found.noise_rad:.3g}); load {found.load_words}"
    )
    return words + "".join(f"; left out {one}" for one in found.left_out)


def _head(found: Correction, source: str) -> list[str]:
    return [
        f"Correction of the output angle, from {source}",
        SIGN,
        f"direction: -1 to 1, follows the angle by 2 per {found.reversal_rad:.6g} rad after a reversal",
        f"load: {found.load_words}; positive where it opposes positive rotation",
        f"held-out error {found.before_rad:.4g} rad RMS before, {found.after_rad:.4g} after ({found.held_out})",
        *(f"left out: {one}" for one in found.left_out),
    ]


def _csv(found: Correction, source: str) -> bytes:
    at = product(found.angle_rad, DIRECTIONS, found.load_Nm)
    rows = (f"{a:.9g},{d:g},{load:.9g},{v:.9g}" for (a, d, load), v in zip(at, found.value_rad.flat, strict=True))
    head = (f"# {line}" for line in _head(found, source))
    return "\n".join([*head, "angle_rad,direction,load_Nm,correction_rad", *rows, ""]).encode()


def _json(found: Correction, source: str) -> bytes:
    content = {
        "source": source,
        "sign": SIGN,
        "total_ratio": found.ratio,
        "angle_rad": found.angle_rad.tolist(),
        "direction": list(DIRECTIONS),
        "load_Nm": found.load_Nm.tolist(),
        "load": found.load_words,
        "correction_rad": found.value_rad.tolist(),
        "reversal_rad": found.reversal_rad,
        "left_out": list(found.left_out),
        "error": {name: getattr(found, name) for name in ("before_rad", "after_rad", "noise_rad", "held_out")},
    }
    return (json.dumps(content, indent=1) + "\n").encode()


_FUNCTIONS = """
/* Direction after the angle has moved by moved_rad; begin with 0 and keep it from call to call. */
static inline double mbcdm_direction(double before, double moved_rad)
{
    double now = before + 2.0 * moved_rad / MBCDM_REVERSAL_RAD;
    return now > 1.0 ? 1.0 : now < -1.0 ? -1.0 : now;
}

/* Index of the table's point below value, share of the way to the next; 1 where value is beyond the table. */
static inline int mbcdm_place(double value, double first, double step, int points, int *index, double *share)
{
    double at = points > 1 ? (value - first) / step : 0.0;
    int beyond = 0;
    if (!(at >= 0.0)) { at = 0.0; beyond = 1; }
    if (at > points - 1) { at = points - 1; beyond = 1; }
    *index = (int)at;
    if (*index > points - 2) *index = points > 1 ? points - 2 : 0;
    *share = at - *index;
    return beyond;
}

/* Correction in rad. angle_rad: mean of the inputs over the total ratio. held is set to 1 where the table's edge was
   held because angle or load is beyond it, else to 0; it may be null. */
static inline double mbcdm_correction(double angle_rad, double direction, double load_Nm, int *held)
{
    int i, k;
    double u, w, sum = 0.0;
    int beyond = mbcdm_place(angle_rad, MBCDM_ANGLE_FIRST_RAD, MBCDM_ANGLE_STEP_RAD, MBCDM_ANGLES, &i, &u);
    beyond |= mbcdm_place(load_Nm, MBCDM_LOAD_FIRST_NM, MBCDM_LOAD_STEP_NM, MBCDM_LOADS, &k, &w);
    double d = direction > 1.0 ? 1.0 : direction < -1.0 ? -1.0 : direction;
    double up = 0.5 * (d + 1.0);
    int next = MBCDM_LOADS > 1 ? k + 1 : k;
    for (int a = 0; a < 2; a++) {
        for (int s = 0; s < 2; s++) {
            double weight = (a ? u : 1.0 - u) * (s ? up : 1.0 - up);
            sum += weight * ((1.0 - w) * mbcdm_table[i + a][s][k] + w * mbcdm_table[i + a][s][next]);
        }
    }
    if (held) *held = beyond;
    return sum;
}
"""


def _header(found: Correction, source: str) -> bytes:
    angle_step = found.angle_rad[1] - found.angle_rad[0]
    load_step = found.load_Nm[1] - found.load_Nm[0] if found.load_Nm.size > 1 else 1.0
    defines = {
        "MBCDM_ANGLES": str(found.angle_rad.size),
        "MBCDM_ANGLE_FIRST_RAD": f"{found.angle_rad[0]:.17g}",
        "MBCDM_ANGLE_STEP_RAD": f"{angle_step:.17g}",
        "MBCDM_LOADS": str(found.load_Nm.size),
        "MBCDM_LOAD_FIRST_NM": f"{found.load_Nm[0]:.17g}",
        "MBCDM_LOAD_STEP_NM": f"{load_step:.17g}",
        "MBCDM_REVERSAL_RAD": f"{found.reversal_rad:.17g}",
        "MBCDM_TOTAL_RATIO": f"{found.ratio:.17g}",
    }
    lines = ["/*", *(f" * {line}".replace("*/", "* /") for line in _head(found, source)), " */"]
    lines += ["#ifndef MBCDM_CORRECTION_H", "#define MBCDM_CORRECTION_H", ""]
    lines += [f"#define {name} ({value})" for name, value in defines.items()]
    lines += ["", "static const double mbcdm_table[MBCDM_ANGLES][2][MBCDM_LOADS] = {"]
    for row in found.value_rad:
        senses = ", ".join("{" + ", ".join(f"{value:.9e}" for value in sense) + "}" for sense in row)
        lines.append(f"    {{{senses}}},")
    return "\n".join([*lines, "};", _FUNCTIONS, "#endif", ""]).encode()
