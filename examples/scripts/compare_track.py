"""How far a path of `gravical motion` is from positions that a camera or a rail measured, on the clock of the recording:

    python3 compare_track.py moved.csv camera.csv

Both have the columns t_s, px_m, py_m, pz_m.
"""

import sys

import numpy as np


def columns(path, names):
    table = np.genfromtxt(path, delimiter=",", names=True)
    table = table[~np.isnan(table[names[1]])]
    return table[names[0]], np.column_stack([table[n] for n in names[1:]])


t, own = columns(sys.argv[1], ["t_s", "px_m", "py_m", "pz_m"])
when, seen = columns(sys.argv[2], ["t_s", "px_m", "py_m", "pz_m"])
inside = (t >= when[0]) & (t <= when[-1])
t, own = t[inside], own[inside] - own[inside][0]
seen = np.column_stack([np.interp(t, when, axis) for axis in seen.T])
seen -= seen[0]
# Heading is not measured: the turn about the vertical that suits the steps over half a second best.
k = np.searchsorted(t, np.arange(t[0], t[-1], 0.5))
p, r = np.diff(own[k], axis=0), np.diff(seen[k], axis=0)
turn = np.arctan2(np.sum(r[:, 0] * p[:, 1] - r[:, 1] * p[:, 0]), np.sum(r[:, 0] * p[:, 0] + r[:, 1] * p[:, 1]))
c, s = np.cos(turn), np.sin(turn)
off = np.linalg.norm(own - seen @ np.array([[c, s, 0], [-s, c, 0], [0, 0, 1]]), axis=1)
print(f"end {off[-1]:.3f} m, rms {np.sqrt(np.mean(off**2)):.3f} m, turned by {np.degrees(turn):.1f}°")
