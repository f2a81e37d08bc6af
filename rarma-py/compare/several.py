"""Several sensors: rarma beside pyOMA2 on pyOMA2's own example, a building of five floors.

    python -m pip install -r rarma-py/compare/requirements.txt and the wheel
    python rarma-py/compare/several.py

Prints a table of the modes: truth, both readings with their deviations, and how alike the shapes
are. Exits with 1 where the two lie further apart than is stated below, or from the truth.
"""

from __future__ import annotations

import contextlib
import io
import logging
import os
import sys
import time
import warnings
from importlib.metadata import version

# One thread each: seconds are those of one core.
for name in ("OMP_NUM_THREADS", "OPENBLAS_NUM_THREADS", "RAYON_NUM_THREADS"):
    os.environ.setdefault(name, "1")

import numpy as np  # noqa: E402
import rarma  # noqa: E402

FS = 100.0
ORDER, ROWS, STRETCHES = 10, 20, 100
# What is held: both readings of f and ζ within so many of the stated deviations of each other,
# the deviations within a factor, shapes alike.
APART, FACTOR, ALIKE, TRUE = 0.25, 1.25, 0.999, 0.99


def theirs(y: np.ndarray):
    """Modes by pyOMA2: (f, ζ, sd of f, sd of ζ, shape), and seconds."""
    from pyoma2.algorithms import SSI
    from pyoma2.setup import SingleSetup

    logging.disable(logging.CRITICAL)
    hard = {"xi_max": 1.0, "mpc_lim": None, "mpd_lim": None, "CoV_max": None}
    begun = time.process_time()
    with warnings.catch_warnings(), np.errstate(all="ignore"):
        warnings.simplefilter("ignore")
        with contextlib.redirect_stderr(io.StringIO()), contextlib.redirect_stdout(io.StringIO()):
            setup = SingleSetup(y, fs=FS)
            ssi = SSI(
                name="ssi", method="cov", br=ROWS, ordmax=ORDER, calc_unc=True, nb=STRETCHES, hc=hard
            )
            setup.add_algorithms(ssi)
            setup.run_by_name("ssi")
    seconds = time.process_time() - begun
    r = ssi.result
    columns = (r.Fn_poles, r.Xi_poles, r.Fn_poles_std, r.Xi_poles_std)
    numbers = [np.asarray(column)[:, -1] for column in columns]
    shapes = np.asarray(r.Phi_poles)[:, -1, :]
    modes = [(*row, shape) for *row, shape in zip(*numbers, shapes) if np.isfinite(row[0])]
    return sorted(modes, key=lambda mode: mode[0]), seconds


def ours(y: np.ndarray):
    """The same by rarma."""
    begun = time.process_time()
    found = rarma.identify_channels(y, FS, ORDER, rows=ROWS, stretches=STRETCHES, band_hz="full")
    seconds = time.process_time() - begun
    modes = []
    for mode in found["modes"]:
        shape = np.array([part["re"] + 1j * part["im"] for part in mode["shape"]])
        modes.append((mode["f"], mode["zeta"], mode["f_sd"], mode["zeta_sd"], shape))
    return modes, seconds


def mac(a: np.ndarray, b: np.ndarray) -> float:
    return float(abs(np.vdot(a, b)) ** 2 / (np.vdot(a, a).real * np.vdot(b, b).real))


def main() -> int:
    from pyoma2.functions.gen import example_data

    y, _, (f, zeta, phi) = example_data()
    (mine, my_s), (other, other_s) = ours(y), theirs(y)
    print(
        f"rarma {version('rarma')}, pyOMA-2 {version('pyOMA-2')}: {len(y)} samples of {y.shape[1]} "
        f"channels, order {ORDER}, {ROWS} rows, {STRETCHES} stretches; {my_s:.2f} s and {other_s:.2f} s"
    )
    print(
        "\n| f, ζ | rarma f (Hz) | pyOMA2 f (Hz) | rarma ζ (%) | pyOMA2 ζ (%) | MAC: truth, each other |"
        "\n|---|---|---|---|---|---|"
    )
    failed = len(mine) != len(f) or len(other) != len(f)
    for k, (a, b) in enumerate(zip(mine, other)):
        likeness = mac(a[4], phi[:, k]), mac(a[4], b[4])
        print(
            f"| {f[k]:.3f} Hz, {100 * zeta:.1f} % "
            f"| {a[0]:.4f} ± {a[2]:.4f} | {b[0]:.4f} ± {b[2]:.4f} "
            f"| {100 * a[1]:.3f} ± {100 * a[3]:.3f} | {100 * b[1]:.3f} ± {100 * b[3]:.3f} "
            f"| {likeness[0]:.4f}, {likeness[1]:.5f} |"
        )
        for reading, deviation in ((0, 2), (1, 3)):
            ratio = a[deviation] / b[deviation]
            failed |= not abs(a[reading] - b[reading]) <= APART * b[deviation]
            failed |= not 1 / FACTOR <= ratio <= FACTOR
        failed |= not (likeness[0] >= TRUE and likeness[1] >= ALIKE)
    print("\nNOT within what is stated" if failed else "\nwithin what is stated")
    return int(failed)


if __name__ == "__main__":
    sys.exit(main())
