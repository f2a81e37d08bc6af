"""Those who are compared: each takes a series and a case, and reads the mode under test.

A reading is (f in Hz, ζ, standard deviation of f, of ζ), the deviations NaN where none is given;
None where no mode lies within 100 Hz. All of them are told the true order.
"""

from __future__ import annotations

import contextlib
import io
import logging
import warnings
from typing import Callable, Dict, Iterable, Optional, Tuple

import numpy as np
import rarma
from cases import FS, Case, deviations

Reading = Tuple[float, float, float, float]
REACH_HZ = 100.0


def nearest(readings: Iterable[Reading], case: Case) -> Optional[Reading]:
    off = lambda reading: abs(reading[0] - case.parts[0][0])  # noqa: E731
    near = [reading for reading in readings if off(reading) < REACH_HZ]
    return min(near, key=off, default=None)


def _modes(found) -> Iterable[Reading]:
    for mode in found:
        yield tuple(np.nan if mode[n] is None else mode[n] for n in ("f", "zeta", "f_sd", "zeta_sd"))


def rarma_recursive(y: np.ndarray, case: Case) -> Optional[Reading]:
    model = rarma.RecursiveArma(*case.order, FS)
    model.push(y, every=len(y))
    return nearest(_modes(model.modes()), case)


def rarma_batch(y: np.ndarray, case: Case) -> Optional[Reading]:
    found = rarma.identify(y, FS, case.order, band_hz="full", detrend="none")
    return nearest(_modes(found["modes"]), case)


def statsmodels_arma(y: np.ndarray, case: Case) -> Optional[Reading]:
    from statsmodels.tsa.arima.model import ARIMA

    p, q = case.order
    with warnings.catch_warnings():
        warnings.simplefilter("ignore")
        # With its default of 50 most fits of two modes in noise are given up before the optimum.
        fit = ARIMA(y, order=(p, 0, q), trend="n").fit(method_kwargs={"maxiter": 500})
    a = np.concatenate([[1.0], -fit.arparams])
    covariance = np.asarray(fit.cov_params())[:p, :p]

    def readings():
        for z in np.roots(a):
            if z.imag > 0:
                log = np.log(z)
                yield (FS * abs(log) / (2 * np.pi), -log.real / abs(log), *deviations(a, covariance, z))

    with np.errstate(all="ignore"):
        return nearest(list(readings()), case)


def pyoma_ssi(y: np.ndarray, case: Case) -> Optional[Reading]:
    from pyoma2.algorithms import SSI
    from pyoma2.setup import SingleSetup

    logging.disable(logging.CRITICAL)
    order = 2 * case.modes
    # 20 block rows are its default, and here the best of 20, 30, 60 and 100.
    # No pole is left out for its damping or its shape, which one channel does not have.
    hard = {"xi_max": 1.0, "mpc_lim": None, "mpd_lim": None, "CoV_max": None}
    with warnings.catch_warnings(), np.errstate(all="ignore"):
        warnings.simplefilter("ignore")
        with contextlib.redirect_stderr(io.StringIO()), contextlib.redirect_stdout(io.StringIO()):
            setup = SingleSetup(y[:, None], fs=FS)
            ssi = SSI(name="ssi", method="cov", br=20, ordmax=order, calc_unc=True, nb=50, hc=hard)
            setup.add_algorithms(ssi)
            setup.run_by_name("ssi")
    result = ssi.result
    columns = (result.Fn_poles, result.Xi_poles, result.Fn_poles_std, result.Xi_poles_std)
    return nearest(zip(*(np.asarray(column)[:, -1] for column in columns)), case)


def sdypy_lscf(y: np.ndarray, case: Case) -> Optional[Reading]:
    """LSCF of sdypy, which wants a frequency response: it is given the half spectrum.

    That is the transform of the autocorrelation at lags from 0 on (half of that at 0), whose poles
    are those of the structure where white noise shakes it. Best of 50, 100, 200 and 400 lags are
    100, and of 0, 1, 2 and 4 modes more than there are 1, which takes what the cut at the last lag adds.
    """
    from sdypy import EMA

    lags = 100
    power = np.abs(np.fft.rfft(y, 2 * len(y))) ** 2
    correlation = np.fft.irfft(power)[:lags] / len(y)
    correlation[0] /= 2
    half = np.fft.rfft(correlation, 2 * lags)
    # With a lower end of 0 it turns the sign of the damping round.
    model = EMA.Model(
        frf=half, freq=np.linspace(0, FS / 2, lags + 1), lower=20, upper=FS / 2, pol_order_high=case.modes + 1
    )
    model.get_poles(method="lscf", show_progress=False)
    both = zip(model.pole_freq[-1], model.pole_xi[-1])
    # It states no deviation. What is not damped is none of the structure.
    return nearest([(f, zeta, np.nan, np.nan) for f, zeta in both if f > 0 and zeta > 0], case)


ESTIMATORS: Dict[str, Callable[[np.ndarray, Case], Optional[Reading]]] = {
    "rarma recursive": rarma_recursive,
    "rarma batch": rarma_batch,
    "statsmodels ARMA": statsmodels_arma,
    "pyOMA2 SSI-cov": pyoma_ssi,
    "sdypy LSCF": sdypy_lscf,
}
