"""Normal matrices whose unknowns have few neighbours: their solution, and the diagonal of their inverse, exactly.

The unknowns are put in an order in which neighbours are near each other (Cuthill and McKee 1969), so that the
triangular factor has a narrow band. The inverse Z of N = L L' is not sparse, but within the band it follows from L
alone, from the last row to the first (Takahashi, Fagan and Chen 1973):

    Z_ki = - sum_m Z_km L_mi / L_ii  (m, k > i, in the band),    Z_ii = 1 / L_ii^2 - sum_m Z_mi L_mi / L_ii

The work is n b^2 for n unknowns and a band of b.
"""

from dataclasses import dataclass

import numpy as np
from jaxtyping import Float
from scipy import sparse
from scipy.linalg import cho_solve_banded, cholesky_banded
from scipy.sparse.csgraph import reverse_cuthill_mckee

RIDGE = 1e-12
"""Share of the largest diagonal entry that is added to all, so that what cannot be told apart has a factor."""


@dataclass(frozen=True, eq=False)
class Banded:
    """The factor of a normal matrix."""

    factor: Float[np.ndarray, "band n"]
    """L by its diagonals, the main one first."""
    order: np.ndarray

    @staticmethod
    def of(normal) -> "Banded":
        """Of a sparse symmetric matrix with a positive diagonal."""
        normal = sparse.csr_array(normal)
        order = np.asarray(reverse_cuthill_mckee(sparse.csr_matrix(normal), symmetric_mode=True))
        place = np.empty_like(order)
        place[order] = np.arange(len(order))
        entries = normal.tocoo()
        row, column = place[entries.row], place[entries.col]
        below = row >= column
        bands = np.zeros((int((row - column).max(initial=0)) + 1, len(order)))
        bands[(row - column)[below], column[below]] = entries.data[below]
        bands[0] += RIDGE * bands[0].max(initial=0)
        return Banded(cholesky_banded(bands, lower=True), order)

    def solve(self, right: Float[np.ndarray, "n"]) -> Float[np.ndarray, "n"]:
        solution = np.empty(len(right))
        solution[self.order] = cho_solve_banded((self.factor, True), right[self.order])
        return solution

    def inverse_diagonal(self) -> Float[np.ndarray, "n"]:
        """The diagonal of the inverse."""
        factor, (size, count) = self.factor, self.factor.shape
        band, step = size - 1, max(size, 256)
        # Of the inverse only a window is kept, which moves up through it.
        window = np.zeros((band + step, band + step))
        found, top = np.empty(count), step
        for i in range(count - 1, -1, -1):
            if not top:
                window[step:, step:] = window[:band, :band].copy()
                top = step
            top -= 1
            inner = slice(top + 1, top + 1 + band)
            ratio = factor[1:, i] / factor[0, i]
            beside = -window[inner, inner] @ ratio
            window[inner, top] = window[top, inner] = beside
            window[top, top] = found[i] = 1 / factor[0, i] ** 2 - beside @ ratio
        inverse = np.empty(count)
        inverse[self.order] = found
        return inverse
