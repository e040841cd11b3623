"""Loops over arrays that several kernels need."""

from rail_native import fast_kernel, kernel


@kernel
def set_zero(array):
    """Fill a contiguous array of any shape with zeros."""
    for i in range(array.size):
        array.flat[i] = 0.0


@kernel
def copy(values, out):
    """Copy a contiguous array of any shape."""
    for i in range(out.size):
        out.flat[i] = values.flat[i]


@fast_kernel
def add_scaled(factor, values, out):
    """Add ``factor`` times a vector (n,) to another one."""
    for k in range(out.size):
        out[k] += factor * values[k]


@fast_kernel
def dot(a, b):
    """Return the scalar product of two vectors (n,)."""
    total = 0.0
    for k in range(a.size):
        total += a[k] * b[k]
    return total


@fast_kernel
def multiply(columns, factors, sums):
    """Write a product: ``sums`` (m,) from ``factors`` (n,).

    ``columns`` (n, m) holds the transposed matrix: four columns at a time are added up.
    """
    whole = factors.size - factors.size % 4
    for i in range(sums.size):
        sums[i] = 0.0
    for j in range(0, whole, 4):
        a, b, c, d = factors[j], factors[j + 1], factors[j + 2], factors[j + 3]
        for i in range(sums.size):
            sums[i] += (
                a * columns[j, i]
                + b * columns[j + 1, i]
                + c * columns[j + 2, i]
                + d * columns[j + 3, i]
            )
    for j in range(whole, factors.size):
        for i in range(sums.size):
            sums[i] += factors[j] * columns[j, i]


@fast_kernel
def multiply_two(columns, factors, more_factors, sums, more_sums):
    """Write two products as :func:`multiply` does, n a multiple of 4."""
    for i in range(sums.size):
        sums[i] = more_sums[i] = 0.0
    for j in range(0, factors.size, 4):
        a, b, c, d = factors[j], factors[j + 1], factors[j + 2], factors[j + 3]
        e, f = more_factors[j], more_factors[j + 1]
        g, h = more_factors[j + 2], more_factors[j + 3]
        for i in range(sums.size):
            c0, c1, c2, c3 = columns[j, i], columns[j + 1, i], columns[j + 2, i], columns[j + 3, i]
            sums[i] += a * c0 + b * c1 + c * c2 + d * c3
            more_sums[i] += e * c0 + f * c1 + g * c2 + h * c3


@kernel
def multiply_rows(rows, matrix, out):
    """Write the product (m, n) of two matrices, (m, k) and (k, n)."""
    for r in range(rows.shape[0]):
        multiply(matrix, rows[r], out[r])
