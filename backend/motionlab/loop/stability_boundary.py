"""The stability boundary over the plane of gains, as lines."""

from __future__ import annotations

from collections import defaultdict

import numpy as np
from numpy.typing import NDArray

from motionlab.loop.family import LoopFamily

Array = NDArray[np.float64]
Node = tuple[int, int, int]
"""A side of the grid: k_d index, k_p index, and 0 along k_p or 1 along k_d."""

_HALVINGS = 20
"""Bisections of a side: to a millionth of it."""


def stability_edge(family: LoopFamily, k_p: Array, k_d: Array) -> list[Array]:
    """Return the parameters at which the largest pole modulus of a loop is one.

    The grid locates the boundary between neighbours, where it is bisected.

    Parameters
    ----------
    family : LoopFamily
        Loops over gains.
    k_p, k_d : ndarray, shape (n,), (m,)
        Gains of the grid, N/m and N s/m, rising.

    Returns
    -------
    list of ndarray, shape (points, 2)
        Lines of k_p and k_d; closed ones end where they begin.
    """
    stable = family.radius(*np.meshgrid(k_p, k_d)) < 1.0
    nodes = _crossed_sides(stable)
    places = _bisect(family, stable, nodes, k_p, k_d)
    return [np.array([places[node] for node in line]) for line in _lines(stable)]


def _crossed_sides(stable: NDArray[np.bool_]) -> list[Node]:
    along_p = np.argwhere(stable[:, 1:] != stable[:, :-1])
    along_d = np.argwhere(stable[1:] != stable[:-1])
    return [(int(i), int(j), 0) for i, j in along_p] + [(int(i), int(j), 1) for i, j in along_d]


def _bisect(
    family: LoopFamily, stable: NDArray[np.bool_], nodes: list[Node], k_p: Array, k_d: Array
) -> dict[Node, tuple[float, float]]:
    """Return the boundary's point on each crossed side, all of them bisected together."""
    if not nodes:
        return {}
    i, j, along = np.array(nodes).T
    here = np.log(np.stack([k_p[j], k_d[i]]))
    there = np.log(np.stack([k_p[j + (along == 0)], k_d[i + (along == 1)]]))
    begins = stable[i, j]
    for _ in range(_HALVINGS):
        middle = 0.5 * (here + there)
        same = (family.radius(*np.exp(middle)) < 1.0) == begins
        here, there = np.where(same, middle, here), np.where(same, there, middle)
    places = np.exp(0.5 * (here + there)).T
    return {node: (float(p), float(d)) for node, (p, d) in zip(nodes, places, strict=True)}


def _lines(stable: NDArray[np.bool_]) -> list[list[Node]]:
    """Return chains of crossed sides: each cell joins the sides at which the boundary enters it."""
    joined: dict[Node, list[Node]] = defaultdict(list)
    rows, columns = stable.shape
    for i in range(rows - 1):
        for j in range(columns - 1):
            sides = _sides(stable, i, j)
            # Four crossed sides are a saddle: the two corners of the first side are kept apart.
            for a, b in zip(sides[::2], sides[1::2], strict=True):
                joined[a].append(b)
                joined[b].append(a)
    lines = []
    while joined:
        ends = [node for node, others in joined.items() if len(others) == 1]
        node = ends[0] if ends else next(iter(joined))
        line = [node]
        while joined[node]:
            following = joined[node].pop()
            joined[following].remove(node)
            line.append(following)
            node = following
        joined = defaultdict(list, {node: others for node, others in joined.items() if others})
        lines.append(line)
    return lines


def _sides(stable: NDArray[np.bool_], i: int, j: int) -> list[Node]:
    """Return the crossed sides of one cell, going round it."""
    round_it: list[tuple[Node, tuple[int, int], tuple[int, int]]] = [
        ((i, j, 0), (i, j), (i, j + 1)),
        ((i, j + 1, 1), (i, j + 1), (i + 1, j + 1)),
        ((i + 1, j, 0), (i + 1, j + 1), (i + 1, j)),
        ((i, j, 1), (i + 1, j), (i, j)),
    ]
    return [node for node, a, b in round_it if stable[a] != stable[b]]
