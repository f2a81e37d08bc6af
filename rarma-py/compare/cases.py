"""Signals of known modes, and the Cramér-Rao bound of each: nothing of rarma is used here.

A mode is an oscillator driven by white noise of its own, its displacement sampled exactly; each
has variance 1, and white noise of the sensor may be added. Together they are an ARMA(2m, 2m - 1)
series, (2m, 2m) with noise.
"""

from __future__ import annotations

from dataclasses import dataclass
from typing import List, Optional, Tuple

import numpy as np

FS = 5000.0
SAMPLES = 5000
# The mode under test, and those that join it, in this order: Hz and damping ratio.
MODES = [(980.0, 0.02), (450.0, 0.03), (1500.0, 0.025), (2000.0, 0.03)]
GRID = 1 << 15


def pole(f: float, zeta: float) -> complex:
    """Of a mode, sampled."""
    w = 2 * np.pi * f / FS
    return np.exp(-zeta * w + 1j * w * np.sqrt(1 - zeta**2))


@dataclass(frozen=True)
class Case:
    """So many modes, and the variance of all of them over that of the noise, dB, if there is any."""

    modes: int
    snr_db: Optional[float]

    @property
    def parts(self) -> List[Tuple[float, float]]:
        return MODES[: self.modes]

    @property
    def noise_variance(self) -> float:
        return 0.0 if self.snr_db is None else self.modes * 10 ** (-self.snr_db / 10)

    @property
    def order(self) -> Tuple[int, int]:
        p = 2 * self.modes
        return p, p - 1 if self.snr_db is None else p

    @property
    def name(self) -> str:
        noise = "clean" if self.snr_db is None else f"{self.snr_db:.0f} dB"
        return f"{self.modes}, {noise}"

    def autocovariance(self, lags: int) -> np.ndarray:
        """r(τ) = e^(-ζωτ)·(cos ω_d τ + ζ/√(1-ζ²)·sin ω_d τ), summed over modes."""
        t = np.arange(lags) / FS
        r = np.zeros(lags)
        for f, zeta in self.parts:
            w, root = 2 * np.pi * f, np.sqrt(1 - zeta**2)
            angle = w * root * t
            r += np.exp(-zeta * w * t) * (np.cos(angle) + zeta / root * np.sin(angle))
        r[0] += self.noise_variance
        return r

    def series(self, seed: int) -> np.ndarray:
        """One realisation."""
        random = np.random.default_rng(seed)
        y = np.sqrt(self.noise_variance) * random.standard_normal(SAMPLES)
        for f, zeta in self.parts:
            y += oscillator(f, zeta, random)
        return y

    def polynomials(self) -> Tuple[np.ndarray, np.ndarray]:
        """A and C with their leading 1: C from the autocovariance of A·y, which is that of C·e."""
        a = np.array([1.0])
        for part in self.parts:
            z = pole(*part)
            a = np.convolve(a, [1.0, -2 * z.real, abs(z) ** 2])
        p, q = self.order
        r = self.autocovariance(p + q + 1)
        both = np.concatenate([r[:0:-1], r])
        filtered = np.convolve(np.convolve(both, a), a[::-1])
        middle = len(filtered) // 2
        moving = filtered[middle - q : middle + q + 1]
        roots = np.roots(moving)
        inside = roots[np.argsort(np.abs(roots))][:q]
        return a, np.real(np.poly(inside))

    def bound(self) -> Tuple[float, float]:
        """Least standard deviations of f (Hz) and ζ of the mode under test.

        J = E(ψψᵀ)/σ² with ψ = (e(t-i)/A, -e(t-j)/C), by its integral over frequency; the covariance
        of (a, c) is J⁻¹/n, and f and ζ follow by their derivatives.
        """
        a, c = self.polynomials()
        p, q = self.order
        w = np.pi * (np.arange(GRID) + 0.5) / GRID
        back = np.exp(-1j * np.outer(np.arange(1, max(p, q) + 1), w))
        value_a = 1 + a[1:] @ back[:p]
        value_c = 1 + c[1:] @ back[:q]
        g = np.concatenate([back[:p] / value_a, -back[:q] / value_c])
        information = np.real(g @ g.conj().T) / GRID
        covariance = np.linalg.inv(information)[:p, :p] / SAMPLES
        return deviations(a, covariance, pole(*self.parts[0]))


def oscillator(f: float, zeta: float, random: np.random.Generator) -> np.ndarray:
    """Displacement of variance 1, by the exact recursion of (x, v/ω)."""
    w, root = 2 * np.pi * f, np.sqrt(1 - zeta**2)
    t = 1 / FS
    decay, c, s = np.exp(-zeta * w * t), np.cos(w * root * t), np.sin(w * root * t) / root
    step = decay * np.array([[c + zeta * s, s], [-s, c - zeta * s]])
    # The covariance of (x, v/ω) is the identity, so that of the noise is what a step loses of it.
    shape = np.linalg.cholesky(np.eye(2) - step @ step.T)
    noise = random.standard_normal((SAMPLES, 2)) @ shape.T
    state = random.standard_normal(2)
    out = np.empty(SAMPLES)
    for k in range(SAMPLES):
        state = step @ state + noise[k]
        out[k] = state[0]
    return out


def deviations(a: np.ndarray, covariance: np.ndarray, z: complex) -> Tuple[float, float]:
    """Standard deviations of f (Hz) and ζ of a root z of A, from the covariance of a_1 … a_p."""
    p = len(a) - 1
    slope = np.polyval(np.polyder(a), z)
    by_a = -(z ** np.arange(p - 1, -1, -1)) / slope / z
    log = np.log(z)
    r = abs(log)
    by_f = FS / (2 * np.pi) * (log.real * by_a.real + log.imag * by_a.imag) / r
    by_zeta = log.imag * (log.real * by_a.imag - log.imag * by_a.real) / r**3
    return (
        float(np.sqrt(by_f @ covariance @ by_f)),
        float(np.sqrt(by_zeta @ covariance @ by_zeta)),
    )
