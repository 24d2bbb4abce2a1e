#!/usr/bin/env python3
"""Makes filters.json: what scipy makes of one made-up channel. See README.md.

    python make.py > filters.json
"""

import json
import math
import sys
from fractions import Fraction

import numpy as np
import scipy
from scipy import signal

RATE_HZ = 100.0
STEP_S = 1.0 / RATE_HZ


def channel(n):
    """Gravity, a move, a tremor and repeatable noise, rounded as a file is."""
    state, out = 12345, []
    for i in range(n):
        t = i * STEP_S
        state = (1664525 * state + 1013904223) % 2**32
        noise = state / 2**32 - 0.5
        move = 2.5 * math.sin(2 * math.pi * 0.8 * t) if 0.3 < t < 1.5 else 0.0
        out.append(round(9.81 + move + 0.05 * math.sin(80 * t) + 0.3 * noise, 4))
    return out


X = channel(240)


def exact_weights(window, order, twice_position):
    """The weights by rational arithmetic, per sample."""
    points = [Fraction(2 * i - twice_position, 2) for i in range(window)]
    size = order + 1
    moments = [sum(p**k for p in points) for k in range(2 * order + 1)]
    rows = [
        [moments[i + j] for j in range(size)]
        + [Fraction(int(i == 0))]
        for i in range(size)
    ]
    for i in range(size):
        pivot = next(r for r in range(i, size) if rows[r][i] != 0)
        rows[i], rows[pivot] = rows[pivot], rows[i]
        rows[i] = [v / rows[i][i] for v in rows[i]]
        for r in range(size):
            if r != i and rows[r][i] != 0:
                factor = rows[r][i]
                rows[r] = [a - factor * b for a, b in zip(rows[r], rows[i])]
    a = [rows[i][size] for i in range(size)]
    return [sum(a[k] * p**k for k in range(size)) for p in points]


def exact_filter(window, order, n):
    """Savitzky-Golay with interpolated ends by rational arithmetic."""
    x = [Fraction(v) for v in X[:n]]
    half = window // 2
    middle = exact_weights(window, order, window - 1)
    ends = {}
    y = []
    for i in range(n):
        start = min(max(i - half, 0), n - window)
        at = i - start
        if at == half:
            weights = middle
        else:
            if at not in ends:
                ends[at] = exact_weights(window, order, 2 * at)
            weights = ends[at]
        value = sum(w * v for w, v in zip(weights, x[start:]))
        y.append(float(value))
    return y


def worst(a, b):
    a, b = np.asarray(a), np.asarray(b)
    return float(np.max(np.abs(a - b)) / np.max(np.abs(b)))


def savgol():
    cases, offsets = [], []
    for window, order in [
        (1, 0), (3, 0), (3, 1), (5, 2), (5, 3), (7, 2), (7, 6), (11, 2), (21, 2), (21, 5), (31, 3), (51, 2), (101, 1),
        (101, 2), (51, 5), (51, 8), (101, 4), (101, 5), (101, 6), (101, 8), (25, 12), (101, 12),
    ]:
        exact = [float(w) for w in exact_weights(window, order, window - 1)]
        own = signal.savgol_coeffs(window, order, use="dot")
        off = worst(own, exact)
        case = dict(window=window, order=order)
        if off > 2e-13:
            # scipy's own weights are not good enough to be held against.
            offsets.append(case | dict(off=off))
            n = 2 * window - 40 if window > 60 else 70
            cases.append(case | dict(n=n, y=exact_filter(window, order, n)))
            continue
        lengths = {120 if window <= 31 else len(X)}
        if (window, order) in [(5, 2), (101, 2)]:
            lengths.add(window)
        for n in sorted(lengths):
            cases.append(case | dict(n=n, y=list(signal.savgol_filter(X[:n], window, order, mode="interp"))))
    return cases, offsets


def two_pass(order, kind, edge):
    """Where one pass has to be designed so that two are down by 3 dB at `edge`."""
    factor = (math.sqrt(2) - 1) ** (1 / (2 * order))
    warp = math.tan(math.pi * edge / RATE_HZ)
    warp = warp / factor if kind == "lowpass" else warp * factor
    return RATE_HZ / math.pi * math.atan(warp)


WANTED = [("lowpass", n, f) for n in range(1, 9) for f in (1.0, 5.0, 20.0, 44.0)]
WANTED += [("highpass", n, f) for n in range(1, 9) for f in (0.5, 12.0)]


def samples_wanted(order, edge):
    return order == 4 or (order in (1, 2, 7, 8) and edge != 44.0)


def butter():
    cases = []
    for kind, order, edge in WANTED:
        name = "highpass" if kind == "highpass" else "butter"
        sos = signal.butter(order, two_pass(order, kind, edge), kind, fs=RATE_HZ, output="sos")
        y = signal.sosfiltfilt(sos, np.asarray(X))
        # Two passes hold the impulse response twice: |H|^2 in place of |H|.
        impulse = signal.sosfilt(sos, np.r_[1.0, np.zeros(2**15 - 1)])
        power = np.abs(np.fft.fft(impulse)) ** 4
        cases.append(
            dict(
                spec=f"{name}:{order},{edge:g}Hz",
                noise_gain=float(math.sqrt(np.mean(power))),
                # Of the rest the gain is enough.
                y=list(y) if samples_wanted(order, edge) else None,
            )
        )
    return cases


def sosfilt():
    x, cases = np.asarray(X), []
    for kind, order, edge in WANTED:
        if samples_wanted(order, edge):
            sos = signal.butter(order, edge, kind, fs=RATE_HZ, output="sos")
            y, _ = signal.sosfilt(sos, x, zi=signal.sosfilt_zi(sos) * x[0])
            cases.append(dict(order=order, kind=kind, cutoff_hz=edge, y=list(y)))
    return cases


filtered, offsets = savgol()
json.dump(
    dict(
        scipy=scipy.__version__,
        rate_hz=RATE_HZ,
        x=X,
        savgol=filtered,
        scipy_weights_off=offsets,
        butter=butter(),
        sosfilt=sosfilt(),
    ),
    sys.stdout,
    separators=(",", ":"),
)
