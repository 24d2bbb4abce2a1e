"""Overlapping Allan deviations by allantools, for one series that any language computes alike."""

import json

import allantools
import numpy

COUNT = 200_000
RATE_HZ = 100.0


def series():
    """Uniform noise and a random walk, by the generator of Knuth's MMIX."""
    state, walk, values = 1, 0.0, []

    def uniform():
        nonlocal state
        state = (state * 6364136223846793005 + 1442695040888963407) % 2**64
        return (state >> 11) / 2**53 - 0.5

    for _ in range(COUNT):
        walk += 0.002 * uniform()
        values.append(9.8 + walk + uniform())
    return numpy.array(values)


def main():
    values = series()
    # Phases near zero: differences of large ones would lose digits.
    phases = numpy.concatenate(([0.0], numpy.cumsum(values - values[0]))) / RATE_HZ
    octaves = [2**k for k in range(17)]
    points = []
    for m in octaves:
        tau, dev, _, n = allantools.oadev(
            phases, rate=RATE_HZ, data_type="phase", taus=[m / RATE_HZ])
        points.append({"m": m, "tau_s": tau[0], "deviation": dev[0], "terms": int(n[0])})
    print(json.dumps({
        "allantools": allantools.__version__,
        "count": COUNT,
        "rate_hz": RATE_HZ,
        "first": values[:3].tolist(),
        "last": values[-1],
        "octaves": points,
    }, indent=1))


main()
