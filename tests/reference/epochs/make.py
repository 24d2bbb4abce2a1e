"""Makes recording.csv and epochs.json: the measures of epochs, computed with numpy and datetime."""

import json
import math
from datetime import datetime, timezone

import numpy as np

RATE_HZ = 12.5
START = datetime(2026, 3, 29, 0, 59, 43, 120000, tzinfo=timezone.utc).timestamp()
EPOCH_S = 5

rng = np.random.default_rng(7)
n = 375
t = np.round(START + np.arange(n) / RATE_HZ, 3)
tilt = np.radians(np.linspace(-80, 70, n))
gravity = np.column_stack([np.cos(tilt), 0.1 * np.sin(7 * tilt), np.sin(tilt)])
burst = np.where((np.arange(n) // 60) % 2 == 1, 0.4, 0.01)[:, None]
a = np.round(gravity + burst * rng.standard_normal((n, 3)), 4)
temperature = np.round(28 + np.linspace(0, 1, n), 2)
kept = np.ones(n, bool)
kept[100:104] = False  # rows that are lost
empty = [200, 201]  # rows without the y axis

lines = ["time,ax [g],ay [g],az [g],temperature [C]"]
for i in np.flatnonzero(kept):
    stamp = datetime.fromtimestamp(t[i], timezone.utc).isoformat(timespec="milliseconds")
    y = "" if i in empty else f"{a[i, 1]:.4f}"
    lines.append(f"{stamp.replace('+00:00', 'Z')},{a[i, 0]:.4f},{y},{a[i, 2]:.4f},{temperature[i]:.2f}")
with open("recording.csv", "w") as out:
    out.write("\n".join(lines) + "\n")

kept_values = kept.copy()
kept_values[empty] = False
number = np.floor((t + 1e-6) / EPOCH_S).astype(int)
norm = np.linalg.norm(a, axis=1)
epochs = []
for k in range(number[0], number[-1] + 1):
    own = (number == k) & kept_values
    rows = (number == k) & kept
    x = np.column_stack([a[own], norm[own]])
    median = np.median(a[own], axis=0)
    epochs.append({
        "time": datetime.fromtimestamp(k * EPOCH_S, timezone.utc).isoformat().replace("+00:00", "Z"),
        "mean_g": x.mean(axis=0).tolist(),
        "sd_mg": (1000 * x.std(axis=0, ddof=1)).tolist(),
        "enmo_mg": 1000 * float(np.maximum(norm[own] - 1, 0).mean()),
        "mad_mg": 1000 * float(np.abs(norm[own] - norm[own].mean()).mean()),
        "angle_z_deg": math.degrees(math.atan(median[2] / math.hypot(median[0], median[1]))),
        "temperature_c": float(temperature[rows].mean()),
        "samples": int(own.sum()),
        "missing": int((number == k).sum() - own.sum()),
    })
with open("epochs.json", "w") as out:
    json.dump(epochs, out, indent=1)
    out.write("\n")
