"""Plain arrays: the Allan deviation beside its definition."""

from __future__ import annotations

import gravical
import numpy as np
import pytest

RATE = 100.0


def test_the_allan_deviation_is_that_of_its_definition() -> None:
    samples = np.random.default_rng(6).normal(3, 1, 5000).cumsum()
    found = gravical.allan_deviation(samples, rate=50.0, taus=[0.02, 0.5, 20.0, 1e3, -1.0])
    assert found.tau.tolist() == [0.02, 0.5, 20.0]
    phases = np.concatenate([[0.0], samples.cumsum()])
    for tau, adev in zip(found.tau, found.adev):
        m = round(tau * 50)
        second = phases[2 * m :] - 2 * phases[m:-m] + phases[: -2 * m]
        assert np.isclose(adev, np.sqrt((second**2).mean() / 2) / m, rtol=1e-9)
    octaves = gravical.allan_deviation(samples, rate=50.0)
    points = gravical.allan(samples, rate=50.0, full=True)["adev"]
    assert np.allclose(octaves.adev[: len(points)], [p["sigma"] for p in points], rtol=1e-12)
    assert len(gravical.allan_deviation([], rate=50.0).tau) == 0
    with pytest.raises(gravical.UsageError):
        gravical.allan_deviation(samples, rate=50.0, taus="a")  # type: ignore[arg-type]
