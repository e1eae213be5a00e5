"""Small matrices in plain Python: loading a spec must be quick, and needs no numpy."""

from __future__ import annotations

import math
from collections.abc import Sequence

Number = float | complex
Matrix = list[list[float]]
Vector = list[float]


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
    return [[sum(map(float.__mul__, row, column)) for column in columns] for row in left]


def apply(matrix: Matrix, vector: Vector) -> Vector:
    """Multiply a matrix by a vector."""
    return [sum(map(float.__mul__, row, vector)) for row in matrix]


def exponential(matrix: Matrix) -> Matrix:
    """Raise e to a square matrix: halve it to a norm below 1, sum the series, square it back."""
    size = range(len(matrix))
    norm = max(sum(map(abs, row)) for row in matrix)
    halvings = max(0, math.frexp(norm)[1])
    scaled = [[value / 2.0**halvings for value in row] for row in matrix]
    total = [[float(i == j) for j in size] for i in size]
    term = total
    for order in range(1, 18):  # 1/18! is below the last bit of 1
        term = [[value / order for value in row] for row in product(term, scaled)]
        total = [
            [a + b for a, b in zip(*rows, strict=True)] for rows in zip(total, term, strict=True)
        ]
    for _ in range(halvings):
        total = product(total, total)
    return total
