"""rarma beside others of its field, on the same signals, in one run: prints a table.

    python -m pip install -r rarma-py/compare/requirements.txt and the wheel
    python rarma-py/compare [--seeds N] [--cases N] [--limit-s S] [--check]

Of each case: rms error of ζ over the Cramér-Rao bound, part of the series whose ±1.96 stated
standard deviations hold the truth, seconds of the processor a fit. See cases.py and estimators.py.
"""

from __future__ import annotations

import argparse
import os
import platform
import sys
import time
from dataclasses import dataclass
from importlib.metadata import version
from typing import Iterator

# One thread each: seconds are those of one core.
for name in ("OMP_NUM_THREADS", "OPENBLAS_NUM_THREADS", "RAYON_NUM_THREADS"):
    os.environ.setdefault(name, "1")

import numpy as np  # noqa: E402
from cases import SAMPLES, Case  # noqa: E402
from estimators import ESTIMATORS  # noqa: E402

CASES = [Case(modes, snr) for modes in (1, 2, 3, 4) for snr in (None, 30.0, 20.0, 10.0)]
PACKAGES = ("rarma", "numpy", "scipy", "statsmodels", "pyOMA-2", "sdypy-EMA")
# What rarma is held to with --check: rms over the bound by modes, and the part that is covered.
OVER_BOUND = {1: 1.10, 2: 1.10, 3: 1.10, 4: 1.25}
COVERED = (0.93, 0.97)
# A figure that is further out of its bar than so many times its scatter is out of it by more than chance.
SCATTERS = 2


@dataclass(frozen=True)
class Cell:
    """What an estimator made of the series of a case."""

    done: int
    lost: int
    seconds: float
    # rms errors over the bound, of ζ and of f, and the parts that are covered; NaN where there is nothing.
    over_zeta: float
    over_f: float
    covered_zeta: float
    covered_f: float

    def text(self, given: int) -> str:
        if np.isnan(self.over_zeta):
            return f"none of {self.done} found; {self.seconds:.2g} s"
        covered = "none" if np.isnan(self.covered_zeta) else f"{self.covered_zeta:.2f}"
        words = f"{self.over_zeta:.2f} ({self.over_f:.2f}); {covered}; {self.seconds:.2g} s"
        if self.lost:
            words += f"; lost {self.lost}"
        return words if self.done == given else f"{words}; {self.done} series"

    def misses(self, modes: int) -> Iterator[str]:
        """What is out of its bar by more than chance."""
        if self.lost:
            yield f"{self.lost} of {self.done} lost"
        most = OVER_BOUND[modes]
        for name, over in (("ζ", self.over_zeta), ("f", self.over_f)):
            if not over <= most * (1 + SCATTERS / np.sqrt(2 * self.done)):
                yield f"{name} {over:.2f} times the bound, {most} wanted"
        low, high = COVERED
        room = SCATTERS * np.sqrt(0.95 * 0.05 / self.done)
        for name, covered in (("ζ", self.covered_zeta), ("f", self.covered_f)):
            if not low - room <= covered <= high + room:
                yield f"{covered:.3f} of {name} covered, {low} to {high} wanted"


def judged(name: str, case: Case, series, limit_s: float) -> Cell:
    """Gives the series to an estimator until its time is over."""
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
    found = np.array(readings, dtype=float).reshape(-1, 4)
    over, covered = [np.nan, np.nan], [np.nan, np.nan]
    for k, (truth, bound) in enumerate(((f, bound_f), (zeta, bound_zeta))):
        off, sd = np.abs(found[:, k] - truth), found[:, 2 + k]
        if readings:
            over[k] = np.sqrt(np.mean(off**2)) / bound
        # A series without a finite deviation does not hold the truth; who never states one is told apart.
        if np.isfinite(sd).any():
            covered[k] = np.mean(off <= 1.96 * sd)
    return Cell(done, lost, seconds, over[1], over[0], covered[1], covered[0])


def main() -> int:
    words = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    words.add_argument("--seeds", type=int, default=40, help="series of each case")
    words.add_argument(
        "--limit-s",
        type=float,
        default=60.0,
        help="seconds of the processor after which an estimator gets no more series of a case",
    )
    words.add_argument(
        "--cases", type=int, default=len(CASES), help="so many cases only, from the first"
    )
    words.add_argument(
        "--check",
        action="store_true",
        help=f"end with 1 where a figure of rarma is out of its bar by more than {SCATTERS} scatters",
    )
    given = words.parse_args()
    have = ", ".join(f"{name} {version(name)}" for name in PACKAGES)
    print(f"{have}; Python {platform.python_version()}, {platform.machine()}, one core")
    print(f"\n| modes, SNR | order | bound, % of ζ | {' | '.join(ESTIMATORS)} |")
    print("|---|---|---|" + "---|" * len(ESTIMATORS))
    misses = []
    for case in CASES[: given.cases]:
        series = [case.series(seed) for seed in range(given.seeds)]
        bound = 100 * case.bound()[1] / case.parts[0][1]
        cells = {name: judged(name, case, series, given.limit_s) for name in ESTIMATORS}
        for name, cell in cells.items():
            if name.startswith("rarma"):
                misses += [f"{name}, {case.name}: {miss}" for miss in cell.misses(case.modes)]
        p, q = case.order
        row = " | ".join(cell.text(len(series)) for cell in cells.values())
        print(f"| {case.name} | ({p},{q}) | {bound:.1f} | {row} |", flush=True)
    print(
        f"\nCells: rms of ζ over the bound (of f); part covered of ζ; seconds a fit. {SAMPLES} samples, "
        f"{given.seeds} series unless stated, of which the ratio scatters by "
        f"{100 / np.sqrt(2 * given.seeds):.0f} %."
    )
    if given.check:
        print("\n".join(misses) or "rarma: every figure within its bar, but for chance")
    return int(given.check and bool(misses))


if __name__ == "__main__":
    sys.exit(main())
