"""Means of autocorrelated samples with a standard error that counts the autocorrelation."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

Vector = NDArray[np.float64]

#: lags summed are at most this many times the autocorrelation time found so far (Sokal's window)
_WINDOW = 5.0


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
    """Mean of a stationary series, shape (n,), with standard error `s sqrt(tau / n)`.

    The variance is corrected for the mean having been taken from the same correlated samples; with fewer than about ten
    autocorrelation times in the record the error is a lower bound, and `effective_samples` shows it.
    """
    n = len(samples)
    tau = min(autocorrelation_time(samples), n / 2.0) if n > 1 else 1.0
    effective = max(n / tau, 1.0)
    spread = float(np.var(samples))
    corrected = spread * effective / (effective - 1.0) if effective > 1.0 else spread
    return MeanEstimate(float(np.mean(samples)), float(np.sqrt(corrected / effective)), effective)


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
