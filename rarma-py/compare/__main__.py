"""rarma beside others of its field, on the same signals, in one run: prints a table.

    python -m pip install -r rarma-py/compare/requirements.txt and the wheel
    python rarma-py/compare [--seeds N] [--limit-s S] [--slow]

Of each case: rms error of ζ over the Cramér-Rao bound, part of the series whose ±1.96 stated
standard deviations hold the truth, seconds of the processor a fit. See cases.py and estimators.py.
"""

from __future__ import annotations

import argparse
import os
import platform
import sys
import time
from importlib.metadata import version

# One thread each: seconds are those of one core.
for name in ("OMP_NUM_THREADS", "OPENBLAS_NUM_THREADS", "RAYON_NUM_THREADS"):
    os.environ.setdefault(name, "1")

import numpy as np  # noqa: E402
from cases import SAMPLES, Case  # noqa: E402
from estimators import ESTIMATORS  # noqa: E402

CASES = [Case(modes, snr) for modes in (1, 2, 3, 4) for snr in (None, 30.0, 20.0, 10.0)]
# Those whose fits take long beyond so many modes, in noise above all.
SLOW = {"statsmodels ARMA": 2}
PACKAGES = ("rarma", "numpy", "scipy", "statsmodels", "pyOMA-2", "sdypy-EMA")


def judged(name: str, case: Case, series, limit_s: float) -> str:
    """A cell of the table."""
    if limit_s == 0:
        return "not run"
    (f, zeta), (bound_f, bound_zeta) = case.parts[0], case.bound()
    readings, lost, begun = [], 0, time.process_time()
    for y in series:
        reading = ESTIMATORS[name](y, case)
        lost += reading is None
        if reading is not None:
            readings.append(reading)
        if time.process_time() - begun > limit_s:
            break
    done = len(readings) + lost
    seconds = (time.process_time() - begun) / done
    if not readings:
        return f"none of {done} found; {seconds:.2g} s"
    found = np.array(readings, dtype=float)
    rms = lambda k, truth: np.sqrt(np.mean((found[:, k] - truth) ** 2))  # noqa: E731
    # A series without a finite deviation does not hold the truth; who never states one is told apart.
    covered = f"{np.mean(np.abs(found[:, 1] - zeta) <= 1.96 * found[:, 3]):.2f}"
    if not np.isfinite(found[:, 3]).any():
        covered = "none"
    words = f"{rms(1, zeta) / bound_zeta:.2f} ({rms(0, f) / bound_f:.2f}); {covered}; {seconds:.2g} s"
    if lost:
        words += f"; lost {lost}"
    return words if done == len(series) else f"{words}; {done} series"


def main() -> None:
    words = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    words.add_argument("--seeds", type=int, default=40, help="series of each case")
    words.add_argument(
        "--limit-s", type=float, default=60.0, help="seconds after which an estimator gets no more series of a case"
    )
    words.add_argument(
        "--slow", action="store_true", help=f"with {', '.join(SLOW)} on more than two modes, too"
    )
    words.add_argument(
        "--cases", type=int, default=len(CASES), help="so many cases only, from the first"
    )
    given = words.parse_args()
    have = ", ".join(f"{name} {version(name)}" for name in PACKAGES)
    print(f"{have}; Python {platform.python_version()}, {platform.machine()}, one core")
    print(f"\n| modes, SNR | order | bound, % of ζ | {' | '.join(ESTIMATORS)} |")
    print("|---|---|---|" + "---|" * len(ESTIMATORS))
    for case in CASES[: given.cases]:
        series = [case.series(seed) for seed in range(given.seeds)]
        bound = 100 * case.bound()[1] / case.parts[0][1]
        waits = lambda name: given.slow or case.modes <= SLOW.get(name, case.modes)  # noqa: E731
        cells = [judged(n, case, series, given.limit_s * waits(n)) for n in ESTIMATORS]
        p, q = case.order
        print(f"| {case.name} | ({p},{q}) | {bound:.1f} | {' | '.join(cells)} |", flush=True)
    print(
        f"\nCells: rms of ζ over the bound (of f); covered; seconds a fit. {SAMPLES} samples, "
        f"{given.seeds} series unless stated, of which the ratio scatters by "
        f"{100 / np.sqrt(2 * given.seeds):.0f} %."
    )


if __name__ == "__main__":
    sys.exit(main())
