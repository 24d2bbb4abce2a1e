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
from scipy import ndimage, signal

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


def exact_weights(window, order, derivative, twice_position):
    """The weights by rational arithmetic, per sample."""
    points = [Fraction(2 * i - twice_position, 2) for i in range(window)]
    size = order + 1
    moments = [sum(p**k for p in points) for k in range(2 * order + 1)]
    rows = [
        [moments[i + j] for j in range(size)]
        + [Fraction(math.factorial(derivative) if i == derivative else 0)]
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


def exact_filter(window, order, derivative, n):
    """Savitzky-Golay with interpolated ends by rational arithmetic."""
    x = [Fraction(v) for v in X[:n]]
    half = window // 2
    middle = exact_weights(window, order, derivative, window - 1)
    ends = {}
    y = []
    for i in range(n):
        start = min(max(i - half, 0), n - window)
        at = i - start
        if at == half:
            weights = middle
        else:
            if at not in ends:
                ends[at] = exact_weights(window, order, derivative, 2 * at)
            weights = ends[at]
        value = sum(w * v for w, v in zip(weights, x[start:]))
        y.append(float(value) / STEP_S**derivative)
    return y


def worst(a, b):
    a, b = np.asarray(a), np.asarray(b)
    return float(np.max(np.abs(a - b)) / np.max(np.abs(b)))


def savgol():
    cases, offsets = [], []
    for window, order, derivative in [
        (1, 0, 0), (3, 0, 0), (3, 1, 0), (5, 2, 0), (5, 3, 0), (5, 2, 1), (5, 4, 2), (7, 2, 0),
        (7, 6, 0), (9, 4, 3), (11, 2, 0), (11, 3, 1), (15, 5, 2), (21, 2, 0), (21, 4, 1),
        (21, 5, 0), (31, 3, 0), (51, 2, 0), (51, 3, 1), (101, 1, 0), (101, 2, 0), (101, 3, 1),
        (4, 2, 0), (6, 3, 0), (10, 2, 1), (20, 3, 0), (51, 5, 0), (51, 8, 0), (101, 4, 0),
        (101, 5, 0), (101, 6, 0), (101, 8, 0), (101, 8, 2), (31, 8, 1), (21, 8, 3), (25, 12, 0),
        (101, 12, 0),
    ]:
        exact = [float(w) for w in exact_weights(window, order, derivative, window - 1)]
        own = signal.savgol_coeffs(window, order, deriv=derivative, use="dot")
        off = worst(own, exact)
        case = dict(window=window, order=order, derivative=derivative)
        if off > 2e-13:
            # scipy's own weights are not good enough to be held against.
            offsets.append(case | dict(off=off))
            n = 2 * window - 40 if window > 60 else 70
            cases.append(case | dict(edge="interp", n=n, y=exact_filter(window, order, derivative, n)))
            continue
        for edge in ["interp", "nearest", "mirror", "constant"]:
            lengths = {120 if window <= 31 else len(X)}
            if (window, order) in [(5, 2), (11, 3), (4, 2), (101, 2)]:
                lengths.add(window)
            for n in sorted(lengths):
                y = signal.savgol_filter(X[:n], window, order, derivative, STEP_S, mode=edge)
                cases.append(case | dict(edge=edge, n=n, y=list(y)))
    return cases, offsets


def mean():
    cases = []
    for window in [1, 3, 5, 21, 101]:
        for edge in ["nearest", "mirror", "constant"]:
            y = ndimage.uniform_filter1d(np.asarray(X[:150]), window, mode=edge)
            cases.append(dict(window=window, edge=edge, n=150, y=list(y)))
    return cases


def two_pass(order, kind, edges):
    """Where one pass has to be designed so that two are down by 3 dB at `edges`."""
    factor = (math.sqrt(2) - 1) ** (1 / (2 * order))
    warp = [math.tan(math.pi * f / RATE_HZ) for f in edges]
    if kind == "lowpass":
        warp = [warp[0] / factor]
    elif kind == "highpass":
        warp = [warp[0] * factor]
    else:
        half = (warp[1] - warp[0]) / factor / 2
        root = math.sqrt(half * half + warp[0] * warp[1])
        warp = [root - half, root + half]
    return [RATE_HZ / math.pi * math.atan(w) for w in warp]


def butter():
    cases = []
    wanted = [(f"{n},{f:g}", "lowpass", n, [f]) for n in range(1, 9) for f in (1.0, 5.0, 20.0, 44.0)]
    wanted += [(f"{n},{f:g}", "highpass", n, [f]) for n in range(1, 9) for f in (0.5, 12.0)]
    wanted += [
        (f"{n},{a:g}-{b:g}", "bandpass", n, [a, b])
        for n in range(1, 9)
        for a, b in ((5.0, 20.0), (2.0, 45.0))
    ]
    x = np.asarray(X)
    for text, kind, order, edges in wanted:
        name = "highpass" if kind == "highpass" else "butter"
        for passes, mark in ((1, "1"), (2, "")):
            at = edges if passes == 1 else two_pass(order, kind, edges)
            sos = signal.butter(order, at if len(at) > 1 else at[0], kind, fs=RATE_HZ, output="sos")
            if passes == 1:
                y, _ = signal.sosfilt(sos, x, zi=signal.sosfilt_zi(sos) * x[0])
            else:
                y = signal.sosfiltfilt(sos, x)
            # Two passes hold the impulse response twice: |H|^2 in place of |H|.
            impulse = signal.sosfilt(sos, np.r_[1.0, np.zeros(2**15 - 1)])
            power = np.abs(np.fft.fft(impulse)) ** (2 * passes)
            cases.append(
                dict(
                    spec=f"{name}{mark}:{text}Hz",
                    sos=[list(s) for s in sos],
                    noise_gain=float(math.sqrt(np.mean(power))),
                    # Of the rest the sections and the gain are enough.
                    y=list(y) if order == 4 or (order in (1, 2, 7, 8) and edges[0] not in (2.0, 44.0)) else None,
                )
            )
    return cases


filtered, offsets = savgol()
json.dump(
    dict(
        scipy=scipy.__version__,
        rate_hz=RATE_HZ,
        x=X,
        savgol=filtered,
        scipy_weights_off=offsets,
        mean=mean(),
        butter=butter(),
    ),
    sys.stdout,
    separators=(",", ":"),
)
