"""Filters and noise of plain arrays."""

from __future__ import annotations

import json
from collections.abc import Sequence
from typing import Any, Literal, NamedTuple

import numpy as np

from . import _gravical, _tables
from ._errors import usage
from ._types import Floats, options, several


def filtered(
    samples: Any,
    filter: str | Sequence[str],
    *,
    rate: float | None = None,
) -> Floats:
    """Filter an array: evenly spaced samples without gaps.

    :func:`gravical.denoise` filters recordings, with their gaps, uneven time stamps and empty cells,
    and says what that did to the noise.

    Parameters
    ----------
    samples : array of shape (n,) or (n, k)
        Each column is filtered, several at a time. All have to be finite.
    filter : str or list of str
        As of :func:`gravical.denoise`.
    rate : float, optional
        Sampling rate, Hz; filters in Hz need it.

    Returns
    -------
    array of the same shape
        A column that is too short for a filter is left as it is by it.

    Raises
    ------
    UsageError
        ``rate-unknown``, ``filter-range``, ``not-finite``.

    Examples
    --------
    >>> import numpy as np
    >>> noise = np.random.default_rng(1).normal(size=(1000, 3))
    >>> smooth = gravical.filtered(noise, "butter:4,5Hz", rate=100)
    >>> bool(smooth.std() < 0.4)
    True
    """
    array = _finite(samples)
    if array.ndim not in (1, 2):
        raise usage(
            f"samples has the shape {array.shape}", "give an array of shape (n,) or (n, k)"
        )
    given = options({}, filter=filter, rate=rate)
    out = _gravical.filter_channels(np.atleast_2d(array.T), given)
    return out[0] if array.ndim == 1 else out.T


def allan(
    samples: Any,
    *,
    rate: float,
    channel: str = "ax",
    spacing: Literal["octave", "dense", "decade"] | None = None,
) -> dict[str, Any]:
    """The overlapping Allan deviation of an array, and the noise that it shows.

    :func:`gravical.noise` takes recordings: it finds the rests, and knows units and gaps.

    Parameters
    ----------
    samples : array of shape (n,)
        Evenly spaced samples at rest in m/s² or rad/s. All have to be finite.
    rate : float
        Sampling rate, Hz.
    channel : str
        Its name: one that begins with ``g`` is a gyroscope's.
    spacing
        As of :func:`gravical.noise`.

    Returns
    -------
    dict
        ``adev``: averaging times ``tau_s`` with ``sigma`` and its 95 % interval ``low``, ``high``;
        ``n``, ``b``, ``k``: noise density, bias instability and random walk with their intervals,
        None where the samples do not determine them.

    Examples
    --------
    >>> import numpy as np
    >>> noise = np.random.default_rng(1).normal(0, 0.01, 50_000)
    >>> found = gravical.allan(noise, rate=100)
    >>> round(found["n"]["value"], 4)
    0.001
    """
    array = _channel(samples)
    hz = _hz(rate)
    given = options({}, spacing=spacing)
    found: dict[str, Any] = json.loads(
        _gravical.noise_of_channel(str(channel), array, hz, given)
    )
    return found


class AllanDeviation(NamedTuple):
    """What :func:`gravical.allan_deviation` computes: ``tau``, averaging times in s, and ``adev``, the
    deviation at each, in the unit of the samples."""

    tau: Floats
    adev: Floats


def allan_deviation(
    samples: Any, *, rate: float, taus: Sequence[float] | None = None
) -> AllanDeviation:
    """The overlapping Allan deviation of an array, and nothing else.

    By every second difference. :func:`gravical.allan` adds intervals and the noise that it shows.

    Parameters
    ----------
    samples : array of shape (n,)
        Evenly spaced samples. All have to be finite.
    rate : float
        Sampling rate, Hz.
    taus : sequence of float, optional
        Averaging times, s, each taken to the nearest number of samples; those that do not fit twice
        into the samples are left out. By default 1, 2, 4, 8 … samples.

    Examples
    --------
    >>> import numpy as np
    >>> noise = np.random.default_rng(1).normal(0, 0.01, 50_000)
    >>> found = gravical.allan_deviation(noise, rate=100, taus=[1.0])
    >>> found.tau, found.adev.round(3)
    (array([1.]), array([0.001]))
    """
    array = _channel(samples)
    try:
        times = None if taus is None else [float(tau) for tau in several(taus)]
    except (TypeError, ValueError):
        raise usage(f"taus=: {taus!r} is no list of seconds") from None
    return AllanDeviation(*_gravical.allan_deviation(array, _hz(rate), times))


def _channel(samples: Any) -> Floats:
    array = _finite(samples)
    if array.ndim != 1:
        raise usage(f"samples has the shape {array.shape}", "give one channel: shape (n,)")
    return array


def _hz(rate: Any) -> float:
    try:
        hz = float(rate)
    except (TypeError, ValueError):
        hz = 0.0
    if not 1e-6 <= hz <= 1e9:
        raise usage(f"rate=: {rate!r} is not possible; 1e-6 to 1e9 is", code="option-range")
    return hz


def _finite(samples: Any) -> Floats:
    try:
        array = _tables.floats(samples)
    except (TypeError, ValueError) as error:
        raise usage(f"samples is no array of numbers: {error}") from None
    if not np.isfinite(array).all():
        raise usage(
            f"{np.count_nonzero(~np.isfinite(array))} of the samples are not finite",
            "denoise and noise take recordings with empty cells: Recording.from_arrays(…)",
            code="not-finite",
        )
    return array
