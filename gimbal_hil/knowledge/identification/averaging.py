"""Means of autocorrelated samples with a standard error that counts the autocorrelation."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

Vector = NDArray[np.float64]

#: lags summed are at most this many times the autocorrelation time found so far (Sokal's window)
_WINDOW = 5.0
_CLEARLY_CORRELATED = 1.5
#: a long series is first put together to so many blocks at most: the error of its mean is a matter of its lowest
#: frequencies
_MOST_BLOCKS = 2048
#: pairs of periodogram ordinates through whose logarithms a straight line goes down to frequency zero, the mean of the
#: logarithm of such a pair below that of what it estimates, and what undoes the bias of the exponential of a line's end
#: (Heidelberger and Welch, table 1)
_PAIRS, _LOG_BIAS, _LINE_BIAS = 15, 0.270, 0.948
#: blocks about whose straight lines the running sum is taken to sway
_SWAYING = 25


@dataclass(frozen=True)
class MeanEstimate:
    """A mean, its standard error, and how many independent samples that error corresponds to."""

    mean: float
    standard_error: float
    effective_samples: float


def autocorrelation_time(samples: Vector) -> float:
    """Integrated autocorrelation time in samples, `1 + 2 sum rho_k`, at least 1.

    The sum is cut at the first lag beyond five times its own running value (Sokal, Monte Carlo methods in statistical
    mechanics, 1997, section 3). 1 for white noise and for constant input; anticorrelated input also gives 1, which errs
    on the safe side.
    """
    n = len(samples)
    centred = samples - np.mean(samples)
    if n < 4 or not np.any(centred):
        return 1.0
    size = 1 << (2 * n - 1).bit_length()
    spectrum = np.fft.rfft(centred, size)
    covariance = np.fft.irfft(spectrum * np.conj(spectrum), size)[: n // 2]
    running = 2.0 * np.cumsum(covariance / covariance[0]) - 1.0
    inside = np.arange(len(running)) >= _WINDOW * running
    cut = int(np.argmax(inside)) if np.any(inside) else len(running) - 1
    return float(max(1.0, running[cut]))


def mean_with_error(samples: Vector) -> MeanEstimate:
    """Mean of a stationary series, shape (n,), with a standard error that counts its autocorrelation, of either sign.

    Torque that a loop makes of gyro noise is anticorrelated: what it adds now it takes away later, and its mean is far
    better known than white noise of that size would allow, or than means of batches tell. Two things are left. The
    spectrum at frequency zero, found from its lowest frequencies (Heidelberger and Welch, A spectral method for
    confidence interval generation, Communications of the ACM 24, 1981); and the ends: what the loop has not taken back
    yet when the record begins and ends, which is how far its running sum sways. Where the series is positively
    correlated, `s sqrt(tau / n)` counts too, corrected for the mean having been taken from the same samples. With fewer
    than about ten autocorrelation times in the record the error is a lower bound.
    """
    n = len(samples)
    mean, spread = float(np.mean(samples)), float(np.var(samples))
    tau = min(autocorrelation_time(samples), n / 2.0) if n > 1 else 1.0
    correlated = float(np.sqrt(spread / max(n / tau - 1.0, 1.0)))
    length = max(1, n // _MOST_BLOCKS)
    if n < 4 * _PAIRS or spread == 0.0:
        error = correlated
    else:
        error = float(np.hypot(_error_from_spectrum(samples, length), _error_of_ends(samples, length)))
        error = max(error, correlated) if tau > _CLEARLY_CORRELATED else error
    effective = min(float(n), spread / error**2) if error > 0.0 else float(n)
    return MeanEstimate(mean, error, effective)


def _error_from_spectrum(samples: Vector, length: int) -> float:
    """Standard error of the mean that the spectrum at frequency zero stands for."""
    blocks = len(samples) // length
    means = samples[: blocks * length].reshape(blocks, length).mean(axis=1)
    power = np.abs(np.fft.rfft(means - np.mean(means))) ** 2 / blocks
    pairs = power[1 : 2 * _PAIRS + 1].reshape(_PAIRS, 2).mean(axis=1)
    frequency = 2.0 * np.arange(_PAIRS) + 1.5
    _, level = np.polyfit(frequency, np.log(np.maximum(pairs, 1e-300)) + _LOG_BIAS, 1)
    return float(np.sqrt(_LINE_BIAS * np.exp(level) / blocks))


def _error_of_ends(samples: Vector, length: int) -> float:
    """Standard error of the mean from the sum's two ends, each off by what it sways about its own straight course."""
    running = np.cumsum(samples - np.mean(samples))[length - 1 :: length]
    pieces = len(running) // _SWAYING
    if pieces == 0:
        return 0.0
    parts = running[: pieces * _SWAYING].reshape(pieces, _SWAYING)
    return float(np.sqrt(2.0) * spread_about_lines(parts) / len(samples))


def spread_about_lines(parts: Vector) -> float:
    """Scatter of the rows of `parts`, shape (rows, n), each about its own straight line."""
    x = np.arange(parts.shape[1]) - 0.5 * (parts.shape[1] - 1)
    left = parts - parts.mean(axis=1, keepdims=True)
    left = left - np.outer(left @ x / (x @ x), x)
    return float(np.sqrt(np.sum(left**2) / (len(parts) * (parts.shape[1] - 2))))


def weighted_mean(means: Vector, errors: Vector) -> MeanEstimate:
    """Mean of several passes with the scatter between them counted.

    Random-effects weights after DerSimonian and Laird (Controlled Clinical Trials 7, 1986): scatter between passes
    beyond what their own errors explain is added to every pass, so three passes that disagree do not give a falsely
    small error.
    """
    weights = 1.0 / errors**2
    mean = float(np.sum(weights * means) / np.sum(weights))
    surplus = float(np.sum(weights * (means - mean) ** 2)) - (len(means) - 1)
    scale = float(np.sum(weights) - np.sum(weights**2) / np.sum(weights))
    between = max(0.0, surplus / scale) if scale > 0.0 else 0.0
    weights = 1.0 / (errors**2 + between)
    return MeanEstimate(
        float(np.sum(weights * means) / np.sum(weights)), float(np.sqrt(1.0 / np.sum(weights))), float(len(means))
    )
