"""Small matrices: their exponential, the largest modulus of their eigenvalues, a resolvent.

Compiled by numba for this machine and for WebAssembly: loops over arrays that the caller provides.
A *system* of n states is the matrix ``[[A, B], [C, D]]``, shape (n + 1, n + 1).
"""

from __future__ import annotations

import math
from typing import Any

import numpy as np
from numpy.typing import NDArray

from motionlab.lanes import compiled

Array = NDArray[np.float64]
Complex = NDArray[np.complex128]

_ORDER = 16
_EPSILON = 2.0**-52
_ITERATIONS = 60
_SLOW = 10
"""Iterations without an eigenvalue after which another shift is taken."""


@compiled
def exponential_less_one(A: Array, n: int, E: Array, product: Array) -> None:
    """Write ``e**A - 1`` of A, shape (n, n), into E; A is overwritten, as is `product`.

    Taylor's series of ``A/2**k``, and k times ``(2 + E) E``: small numbers keep their digits.
    """
    norm = 0.0
    for j in range(n):
        column = 0.0
        for i in range(n):
            column += abs(A[i, j])
        norm = max(norm, column)
    halvings, scale = 0, 1.0
    while norm * scale > 0.5:
        halvings += 1
        scale *= 0.5
    for i in range(n):
        for j in range(n):
            A[i, j] *= scale
            E[i, j] = 0.0
    for step in range(_ORDER + halvings):
        series = step < _ORDER  # E becomes A (1 + E)/k; after that (2 + E) E
        factor = 1.0 / (_ORDER - step) if series else 1.0
        for i in range(n):
            for j in range(n):
                value = A[i, j] if series else 2.0 * E[i, j]
                for k in range(n):
                    value += (A[i, k] if series else E[i, k]) * E[k, j]
                product[i, j] = factor * value
        for i in range(n):
            for j in range(n):
                E[i, j] = product[i, j]


@compiled
def balance(A: Array, n: int, size: int) -> None:
    """Scale the first n states of A, shape (size, size), so that their rows and columns are alike.

    By powers of two, exactly; further rows and columns follow.
    """
    again = True
    while again:
        again = False
        for i in range(n):
            row, column = 0.0, 0.0
            for j in range(n):
                if j != i:
                    row += abs(A[i, j])
                    column += abs(A[j, i])
            if row == 0.0 or column == 0.0:
                continue
            f, before = 1.0, row + column
            while column < 0.5 * row:
                f, row, column = 2.0 * f, 0.5 * row, 2.0 * column
            while column > 2.0 * row:
                f, row, column = 0.5 * f, 2.0 * row, 0.5 * column
            if row + column < 0.95 * before:
                again = True
                for j in range(size):
                    A[i, j] /= f
                    A[j, i] *= f


@compiled
def make_hessenberg(A: Array, n: int, size: int) -> None:
    """Make A, shape (size, size), zero below the subdiagonal of its first n rows and columns.

    By elimination with pivots: a change of the first n states; further rows and columns follow.
    """
    for m in range(1, n - 1):
        pivot = m
        for i in range(m + 1, n):
            if abs(A[i, m - 1]) > abs(A[pivot, m - 1]):
                pivot = i
        largest = A[pivot, m - 1]
        if largest == 0.0:
            continue
        if pivot != m:
            for j in range(size):
                A[m, j], A[pivot, j] = A[pivot, j], A[m, j]
            for i in range(size):
                A[i, m], A[i, pivot] = A[i, pivot], A[i, m]
        for i in range(m + 1, n):
            share = A[i, m - 1] / largest
            if share != 0.0:
                for j in range(m - 1, size):
                    A[i, j] -= share * A[m, j]
                A[i, m - 1] = 0.0
                for k in range(size):
                    A[k, m] += share * A[k, i]


@compiled
def largest_modulus(A: Array, n: int) -> float:
    """Return the largest modulus of the eigenvalues of A, shape (n, n), which is overwritten.

    QR iterations with double shifts (`hqr` of EISPACK); infinite if they do not converge.
    """
    balance(A, n, n)
    make_hessenberg(A, n, n)
    norm = 0.0
    for i in range(n):
        for j in range(max(i - 1, 0), n):
            norm += abs(A[i, j])
    largest, shifted, iterations, last = 0.0, 0.0, 0, n - 1
    while last >= 0:
        first = last
        while first > 0:
            scale = abs(A[first - 1, first - 1]) + abs(A[first, first])
            if abs(A[first, first - 1]) <= _EPSILON * (scale if scale > 0.0 else norm):
                A[first, first - 1] = 0.0
                break
            first -= 1
        x = A[last, last]
        if first == last:
            largest = max(largest, abs(x + shifted))
            last, iterations = last - 1, 0
            continue
        y, w = A[last - 1, last - 1], A[last, last - 1] * A[last - 1, last]
        if first == last - 1:
            p = 0.5 * (y - x)
            q = p * p + w
            if q >= 0.0:
                z = p + math.copysign(math.sqrt(q), p)
                other = -w / z if z != 0.0 else z
                largest = max(largest, abs(x + shifted + z), abs(x + shifted + other))
            else:
                largest = max(largest, math.sqrt((x + shifted + p) ** 2 - q))
            last, iterations = last - 2, 0
            continue
        if iterations == _ITERATIONS:
            return math.inf
        if iterations % _SLOW == _SLOW - 1:
            shifted += x
            for i in range(last + 1):
                A[i, i] -= x
            scale = abs(A[last, last - 1]) + abs(A[last - 1, last - 2])
            x = y = 0.75 * scale
            w = -0.4375 * scale * scale
        iterations += 1
        _double_step(A, first, last, x, y, w)
    return largest


@compiled
def _double_step(  # noqa: PLR0912, PLR0913, PLR0917 - EISPACK's
    A: Array, first: int, last: int, x: float, y: float, w: float
) -> None:
    """Do one QR iteration with two shifts, of sum x + y and product x y - w."""
    p = q = r = 0.0
    start = last - 2
    while True:
        z = A[start, start]
        r, s = x - z, y - z
        p = (r * s - w) / A[start + 1, start] + A[start, start + 1]
        q = A[start + 1, start + 1] - z - r - s
        r = A[start + 2, start + 1]
        s = abs(p) + abs(q) + abs(r)
        p, q, r = p / s, q / s, r / s
        if start == first:
            break
        around = abs(A[start - 1, start - 1]) + abs(z) + abs(A[start + 1, start + 1])
        if abs(A[start, start - 1]) * (abs(q) + abs(r)) <= _EPSILON * abs(p) * around:
            break
        start -= 1
    for i in range(start + 2, last + 1):
        A[i, i - 2] = 0.0
        if i > start + 2:
            A[i, i - 3] = 0.0
    for k in range(start, last):
        three = k < last - 1
        if k > start:
            p, q = A[k, k - 1], A[k + 1, k - 1]
            r = A[k + 2, k - 1] if three else 0.0
            x = abs(p) + abs(q) + abs(r)
            if x == 0.0:
                continue
            p, q, r = p / x, q / x, r / x
        s = math.copysign(math.sqrt(p * p + q * q + r * r), p)
        if s == 0.0:
            continue
        if k > start:
            A[k, k - 1] = -s * x
        elif first < start:
            A[k, k - 1] = -A[k, k - 1]
        p += s
        x, y, z = p / s, q / s, r / s
        q, r = q / p, r / p
        for j in range(k, last + 1):
            value = A[k, j] + q * A[k + 1, j]
            if three:
                value += r * A[k + 2, j]
                A[k + 2, j] -= value * z
            A[k + 1, j] -= value * y
            A[k, j] -= value * x
        for i in range(first, min(last, k + 3) + 1):
            value = x * A[i, k] + y * A[i, k + 1]
            if three:
                value += z * A[i, k + 2]
                A[i, k + 2] -= value * r
            A[i, k + 1] -= value * q
            A[i, k] -= value


@compiled
def reach(leads: Array, n: int) -> None:
    """Make ``leads[i, j]`` 1 where a path of states leads from j to i, else 0; shape (n, n)."""
    for i in range(n):
        for j in range(n):
            leads[i, j] = 1.0 if leads[i, j] != 0.0 or i == j else 0.0
    for k in range(n):
        for i in range(n):
            if leads[i, k] != 0.0:
                for j in range(n):
                    if leads[k, j] != 0.0:
                        leads[i, j] = 1.0


@compiled
def path_from_input(system: Array, n: int, short: Array, leads: Array) -> int:
    """Write a system without the states that its response does not depend on; return their number.

    What remains is in Hessenberg form, as `response` takes it.
    """
    for i in range(n):
        for j in range(n):
            leads[i, j] = system[i, j]
    reach(leads, n)
    used = 0
    for i in range(n):
        entered, left = False, False
        for j in range(n):
            entered = entered or (leads[i, j] != 0.0 and system[j, n] != 0.0)
            left = left or (leads[j, i] != 0.0 and system[n, j] != 0.0)
        if entered and left:
            leads[n, used] = i
            used += 1
    leads[n, used] = n
    for i in range(used + 1):
        for j in range(used + 1):
            short[i, j] = system[int(leads[n, i]), int(leads[n, j])]
    balance(short, used, used + 1)
    make_hessenberg(short, used, used + 1)
    return used


@compiled
def response(system: Array, n: int, z: Any, upper: Complex) -> Any:
    """Return ``C (z - A)**-1 B + D`` of a system in Hessenberg form; `upper` is (n, n + 1)."""
    for i in range(n):
        for j in range(max(i - 1, 0), n):
            upper[i, j] = -system[i, j] + 0j
        upper[i, i] += z
        upper[i, n] = system[i, n] + 0j
    for k in range(n - 1):
        here, below = upper[k, k], upper[k + 1, k]
        if abs(below.real) + abs(below.imag) > abs(here.real) + abs(here.imag):
            for j in range(k, n + 1):
                upper[k, j], upper[k + 1, j] = upper[k + 1, j], upper[k, j]
            here, below = below, here
        share = below / here
        for j in range(k + 1, n + 1):
            upper[k + 1, j] -= share * upper[k, j]
    value = system[n, n] + 0j
    for i in range(n - 1, -1, -1):
        state = upper[i, n]
        for j in range(i + 1, n):
            state -= upper[i, j] * upper[j, n]
        state /= upper[i, i]
        upper[i, n] = state
        value += system[n, i] * state
    return value
