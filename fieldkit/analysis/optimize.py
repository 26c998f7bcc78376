"""Two small optimizers for the measurements.

Those in `scipy.optimize` give the same figures (a test compares them), but importing it takes as long as measuring a
log: `fieldkit import` of one would take 1.57 s of processor time instead of 1.42 s.

Source: Levenberg (1944) and Marquardt (1963) for the damped steps.
"""

from collections.abc import Callable

import numpy as np

from fieldkit.shapes import Array, Float

_REFLECTED, _EXPANDED, _CONTRACTED, _SHRUNK = 1.0, 2.0, 0.5, 0.5
_TOLERANCE = 1e-4
"""Convergence tolerance: size of the simplex and spread of its values. [unit of each]"""
_DAMPING, _EASED, _HARDENED = 1e-2, 1 / 3, 4.0
"""Damping of the first step, relative to the diagonal, and its factors after a successful and a failed step. [1]"""
_DIFFERENCE, _MIN_RELATIVE_GAIN = 1e-5, 1e-8
"""Step of a numerical derivative, in scales, and the relative reduction of the cost that counts as converged. [1]"""


def nelder_mead(
    cost: Callable[[Array], float], simplex: Float[Array, "corner value"], evaluations: int
) -> Float[Array, "value"]:
    """Values that minimize a cost, from an initial simplex and with a limited number of evaluations; in the units of
    the simplex.

    Source: J. A. Nelder and R. Mead, A Simplex Method for Function Minimization, The Computer Journal 7 (1965).
    """
    corners = np.array(simplex, float)
    costs = np.array([cost(corner) for corner in corners])
    spent = len(costs)
    while spent < evaluations:
        order = np.argsort(costs, kind="stable")
        corners, costs = corners[order], costs[order]
        if np.abs(corners[1:] - corners[0]).max() <= _TOLERANCE and costs[-1] - costs[0] <= _TOLERANCE:
            break
        middle = corners[:-1].mean(axis=0)
        away = middle - corners[-1]
        tried = middle + _REFLECTED * away
        found = cost(tried)
        spent += 1
        if found < costs[0]:
            further = middle + _REFLECTED * _EXPANDED * away
            better = cost(further)
            spent += 1
            corners[-1], costs[-1] = (further, better) if better < found else (tried, found)
        elif found < costs[-2]:
            corners[-1], costs[-1] = tried, found
        else:
            outside = found < costs[-1]
            nearer = middle + (_CONTRACTED if outside else -_CONTRACTED) * away
            better = cost(nearer)
            spent += 1
            if better <= (found if outside else costs[-1]):
                corners[-1], costs[-1] = nearer, better
            else:
                corners[1:] = corners[0] + _SHRUNK * (corners[1:] - corners[0])
                costs[1:] = [cost(corner) for corner in corners[1:]]
                spent += len(costs) - 1
    return np.asarray(corners[int(np.argmin(costs))])


def least_soft_squares(
    misfit: Callable[[Array], Array],
    start: Float[Array, "value"],
    scale: Float[Array, "value"],
    room: Float[Array, "value"],
    rounds: int,
) -> Float[Array, "value"]:
    """Values that minimize the sum of 2 (sqrt(1 + m²) - 1) over the misfits m, which limits the influence of outliers.

    Damped Gauss-Newton steps (Levenberg-Marquardt). `scale` is a typical change of each value, `room` its largest
    distance from the start. Both are in the units of the values.
    """
    values, damping = np.array(start, float), _DAMPING
    left = misfit(values)
    cost = _soft(left)
    for _ in range(rounds):
        slopes = np.stack(
            [(misfit(values + _DIFFERENCE * step) - left) / _DIFFERENCE for step in np.diag(scale)], axis=1
        )
        weight = 1 / np.sqrt(1 + left**2)
        normal, right = (slopes.T * weight) @ slopes, (slopes.T * weight) @ left
        gain = 0.0
        for _ in range(rounds):
            step = np.linalg.lstsq(normal + damping * np.diag(np.diag(normal) + 1e-12), -right, rcond=None)[0]
            tried = np.clip(values + step * scale, start - room, start + room)
            there = misfit(tried)
            if (gain := cost - _soft(there)) > 0:
                break
            damping *= _HARDENED
        if gain <= 0:
            break
        values, left, cost, damping = tried, there, cost - gain, damping * _EASED
        if gain < _MIN_RELATIVE_GAIN * cost:
            break
    return values


def _soft(left: Float[Array, "sample"]) -> float:
    return float(2 * (np.sqrt(1 + left**2) - 1).sum())
