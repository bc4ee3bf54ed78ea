"""Means of autocorrelated samples with a standard error that counts the autocorrelation."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

Vector = NDArray[np.float64]

#: lags summed are at most this many times the autocorrelation time found so far (Sokal's window)
_WINDOW = 5.0
_BATCHES = (10, 20, 40)
_CLEARLY_CORRELATED = 1.5


@dataclass(frozen=True)
class MeanEstimate:
    """A mean, its standard error, and how many independent samples that error corresponds to."""

    mean: float
    standard_error: float
    effective_samples: float


def autocorrelation_time(samples: Vector) -> float:
    """Integrated autocorrelation time in samples, `1 + 2 sum rho_k`, at least 1.

    The sum is cut at the first lag beyond five times its own running value (Sokal, Monte Carlo methods in statistical mechanics,
    1997, section 3). 1 for white noise and for constant input; anticorrelated input also gives 1, which errs on the safe side.
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

    Torque that a loop makes of gyro noise is anticorrelated: what it adds now it takes away later, and its mean is far better known
    than white noise of that size would allow. So the error is the largest of three from means of batches (10, 20 and 40 of them);
    where the series is positively correlated, `s sqrt(tau / n)` counts too, corrected for the mean having been taken from the same
    samples. With fewer than about ten autocorrelation times in the record the error is a lower bound.
    """
    n = len(samples)
    mean, spread = float(np.mean(samples)), float(np.var(samples))
    tau = min(autocorrelation_time(samples), n / 2.0) if n > 1 else 1.0
    independent = max(n / tau, 1.0)
    correlated = float(np.sqrt(spread / max(independent - 1.0, 1.0)))
    error = max((_batch_error(samples, batches) for batches in _BATCHES if n >= 2 * batches), default=correlated)
    if tau > _CLEARLY_CORRELATED or n < 2 * _BATCHES[0]:
        error = max(error, correlated)
    effective = min(float(n), spread / error**2) if error > 0.0 else float(n)
    return MeanEstimate(mean, error, effective)


def _batch_error(samples: Vector, batches: int) -> float:
    edges = np.linspace(0, len(samples), batches + 1).astype(np.int64)
    means = np.add.reduceat(samples, edges[:-1]) / np.diff(edges)
    return float(np.std(means, ddof=1) / np.sqrt(batches))


def weighted_mean(means: Vector, errors: Vector) -> MeanEstimate:
    """Mean of several passes with the scatter between them counted.

    Random-effects weights after DerSimonian and Laird (Controlled Clinical Trials 7, 1986): scatter between passes beyond what
    their own errors explain is added to every pass, so three passes that disagree do not give a falsely small error.
    """
    weights = 1.0 / errors**2
    mean = float(np.sum(weights * means) / np.sum(weights))
    surplus = float(np.sum(weights * (means - mean) ** 2)) - (len(means) - 1)
    scale = float(np.sum(weights) - np.sum(weights**2) / np.sum(weights))
    between = max(0.0, surplus / scale) if scale > 0.0 else 0.0
    weights = 1.0 / (errors**2 + between)
    return MeanEstimate(float(np.sum(weights * means) / np.sum(weights)), float(np.sqrt(1.0 / np.sum(weights))), float(len(means)))
