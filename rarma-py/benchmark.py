"""How many times faster than real time the estimators are: prints the table of docs/python.md.

Run it on a machine that does nothing else. Times are of the processor, not of the clock.
"""

import platform
import time

import numpy as np
import rarma

SAMPLE_RATE_HZ = 48_000.0
SECONDS = 5.0
MODES = [(700.0, 0.02), (1300.0, 0.03), (1900.0, 0.02), (2600.0, 0.02)]


def vibration(n: int) -> np.ndarray:
    """Four modes, driven by noise, at 8 kHz; times do not depend on the signal."""
    past, a = np.zeros(8), np.array([1.0])
    for f, zeta in MODES:
        w = 2 * np.pi * f / 8000.0
        radius = np.exp(-zeta * w)
        a = np.convolve(a, [1.0, -2 * radius * np.cos(w * np.sqrt(1 - zeta**2)), radius**2])
    out = np.empty(n)
    for t, e in enumerate(np.random.default_rng(1).standard_normal(n)):
        y = e - a[1:] @ past
        past[1:], past[0] = past[:-1], y
        out[t] = y
    return out


def real_time(work, x) -> float:
    """The best of nine."""
    times = []
    for _ in range(9):
        begun = time.process_time()
        work(x)
        times.append(time.process_time() - begun)
    return len(x) / SAMPLE_RATE_HZ / min(times)


def main() -> None:
    x = np.resize(vibration(48_000), int(SECONDS * SAMPLE_RATE_HZ))
    print(f"{platform.machine()}, Python {platform.python_version()}, one core")
    print("| what, 48 kHz | times real time | ns a sample |")
    print("|---|---|---|")
    cases = []
    for p, q in [(2, 1), (4, 3), (6, 5), (8, 7)]:
        for every in (1, 10, 96):
            model = rarma.RecursiveArma(p, q, SAMPLE_RATE_HZ, forgetting=0.9999)
            model.push(x[:9600])
            name = f"`RecursiveArma({p}, {q}).push(x, every={every})`"
            cases.append((name, lambda x, m=model, e=every: m.push(x, every=e)))
    for p, channels in [(4, 1), (4, 2), (6, 4)]:
        model = rarma.RecursiveChannels(p, p, channels, SAMPLE_RATE_HZ, forgetting=0.9999)
        several = np.column_stack([np.roll(x, 100 * k) for k in range(channels)])
        model.push(several[:9600], every=96)
        name = f"`RecursiveChannels({p}, {p}, {channels}).push(x, every=96)`"
        cases.append((name, lambda _, m=model, y=several: m.push(y, every=96)))
    monitor = rarma.Monitor(SAMPLE_RATE_HZ)
    cases.append(("`Monitor(…).push(x)`, order (8,7)", monitor.push))
    for name, work in cases:
        times = real_time(work, x)
        print(f"| {name} | {times:.0f} | {1e9 / times / SAMPLE_RATE_HZ:.0f} |")


if __name__ == "__main__":
    main()
