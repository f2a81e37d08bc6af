"""Vibrations whose frequencies and damping ratios are known."""

import numpy as np

FS = 8000.0
MODES = [(700.0, 0.02), (1300.0, 0.03), (1900.0, 0.02), (2600.0, 0.02)]


def characteristic(modes, fs=FS):
    """A(q) of modes (f in Hz, damping ratio), the leading 1 included."""
    a = np.array([1.0])
    for f, zeta in modes:
        w = 2 * np.pi * f / fs
        radius, angle = np.exp(-zeta * w), w * np.sqrt(1 - zeta**2)
        a = np.convolve(a, [1.0, -2 * radius * np.cos(angle), radius**2])
    return a


def vibration(modes, n, seed=1, fs=FS):
    """White noise through 1/A(q)."""
    a = characteristic(modes, fs)[1:]
    e = np.random.default_rng(seed).standard_normal(n)
    past = [0.0] * len(a)
    out = np.empty(n)
    for t in range(n):
        y = e[t] - sum(x * y for x, y in zip(a, past))
        past = [y, *past[:-1]]
        out[t] = y
    return out
