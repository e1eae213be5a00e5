"""Small matrices in plain Python: loading a spec must be quick, and needs no numpy."""

import math
from collections.abc import Sequence
from functools import lru_cache
from operator import mul

Number = float | complex
Matrix = list[list[float]]
Vector = list[float]

GROUP, TERMS = 4, 12
"""Terms of the exponential series that are summed at once, and in all: 0.5**13/13! is below the
precision of 1."""

MOST_KEPT = 4096
"""Maximum number of stored exponentials: twice those of a spec, some megabytes."""

_FACTORS = [1 / math.factorial(order) for order in range(TERMS + 1)]


def solve(matrix: Sequence[Sequence[Number]], right: Sequence[Number]) -> list[Number]:
    """Solve a system of linear equations by elimination with pivots."""
    rows = [[*row, value] for row, value in zip(matrix, right, strict=True)]
    size = len(rows)
    for column in range(size):
        pivot = max(range(column, size), key=lambda row: abs(rows[row][column]))
        rows[column], rows[pivot] = rows[pivot], rows[column]
        for below in range(column + 1, size):
            factor = rows[below][column] / rows[column][column]
            if factor:
                for k in range(column, size + 1):
                    rows[below][k] -= factor * rows[column][k]
    found: list[Number] = [0.0] * size
    for row in reversed(range(size)):
        rest = sum(rows[row][k] * found[k] for k in range(row + 1, size))
        found[row] = (rows[row][size] - rest) / rows[row][row]
    return found


def product(left: Matrix, right: Matrix) -> Matrix:
    """Multiply two square matrices."""
    columns = list(zip(*right, strict=True))
    empty = [0.0] * len(columns)
    return [
        [sum(map(mul, row, column)) for column in columns] if any(row) else empty for row in left
    ]


def apply(matrix: Matrix, vector: Vector) -> Vector:
    """Multiply a matrix by a vector."""
    return [sum(map(mul, row, vector)) for row in matrix]


def exponential(matrix: Matrix) -> Matrix:
    """Raise e to a square matrix; callers must not change the result, which is stored.

    Rows of a comparison, and searches for a number, need the same exponentials again.
    """
    return _exponential(tuple(map(tuple, matrix)))


@lru_cache(maxsize=MOST_KEPT)
def _exponential(matrix: tuple[tuple[float, ...], ...]) -> Matrix:
    """Halve the matrix to a norm below 1/2, sum the series, square the sum as often.

    The terms are summed in groups of four: five products for twelve terms (Paterson, Stockmeyer).
    """
    norm = max(sum(map(abs, row)) for row in matrix)
    halvings = max(0, math.frexp(norm)[1] + 1)
    scale = 0.5**halvings
    powers = [[[value * scale for value in row] for row in matrix]]
    for _ in range(3):
        powers.append(product(powers[-1], powers[0]))
    total = [[_FACTORS[TERMS] * value for value in row] for row in powers[-1]]
    for first in range(TERMS - GROUP, -1, -GROUP):
        total = _sum(total, _group(powers, first))
        if first:
            total = product(total, powers[-1])
    for _ in range(halvings):
        total = product(total, total)
    return total


def _group(powers: Sequence[Matrix], first: int) -> Matrix:
    """Sum four terms of the series over the power that they begin with."""
    one, single, square, cube = _FACTORS[first : first + GROUP]
    total = [
        [single * a + square * b + cube * c for a, b, c in zip(*rows, strict=True)]
        for rows in zip(*powers[:3], strict=True)
    ]
    for i, (row, *rows) in enumerate(zip(total, *powers[:3], strict=True)):
        a, b, c = (each[i] for each in rows)
        row[i] = one + single * a + square * b + cube * c
    return total


def _sum(left: Matrix, right: Matrix) -> Matrix:
    return [[a + b for a, b in zip(*rows, strict=True)] for rows in zip(left, right, strict=True)]
