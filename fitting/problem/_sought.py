"""What a fit looks for: free numbers with their bounds, what was known of them, what ties them, and what they may come
to together."""

from collections.abc import Mapping, Sequence
from dataclasses import dataclass, field, replace

from diffwhitted.scene import Scene

from ._priors import with_priors
from ._sums import with_sums
from ._ties import Ties, tied
from ._unknowns import list_unknowns


@dataclass(frozen=True)
class Wishes:
    """As given to `fit`, by name, with wildcards."""

    bounds: Mapping[str, tuple[float, float]] = field(default_factory=dict)
    prior: Mapping[str, tuple[float, float]] = field(default_factory=dict)
    ties: Mapping[str, str | tuple[float, str]] = field(default_factory=dict)
    at_most: Mapping[str, float] = field(default_factory=dict)


def sought(scene: Scene, names: Sequence[str], wishes: Wishes) -> Ties:
    """The unknowns of these names. Raises `FitError` for what cannot be."""
    found = tied(list_unknowns(scene, names, wishes.bounds), wishes.ties)
    return replace(found, leaders=with_sums(with_priors(found.leaders, wishes.prior), wishes.at_most))
