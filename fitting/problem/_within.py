"""How much what is seen varies within each pixel."""

import jax.numpy as jnp
import numpy as np

from diffwhitted.numerics._workers import side_by_side

from ._filtering import Filtering
from ._problem import Problem, with_room


def within_pixels(problem: Problem, values) -> list[np.ndarray]:
    """For each target how much the samples of each pixel vary beyond a smooth course, (height, width, 3); 0 of one
    sample.

    What a parabola through them follows is integrated well by a grid; what it does not, such as an edge, is not. It is
    the variance about the best plane of 2 x 2 samples, about the best parabola of more.
    """
    asked, found = problem.asked(values), []
    for view in problem.views:
        bands = view.parts[0].plan.bands
        if len(view.parts) == view.passes * bands:
            found.append(np.zeros_like(view.image, np.float64))
            continue
        films = []
        for number in range(view.passes):
            lights = side_by_side(lambda part: with_room(asked.rows, part)[1], view.places_of(number))
            each = np.stack([np.asarray(light, np.float64) for light in lights])
            stack = each.reshape(-1, bands, *each.shape[1:]).mean(axis=1)
            rough = _beyond_smooth(np.stack([np.asarray(part.place) for part in view.places_of(number)[::bands]]))
            films.append((np.tensordot(rough, stack, 1) ** 2).mean(axis=0))
        if view.filter == "box":
            found.append(np.asarray(view.picture(np.stack(films)), np.float64))
            continue
        # An edge is uncertain in all pixels that see it.
        around = Filtering("gaussian", *view.weight.shape[:2])
        around.add_passes(jnp.asarray(np.stack(films)), (0.5, 0.5))
        found.append(np.asarray(around.pictures, np.float64))
    return found


def _beyond_smooth(places: np.ndarray) -> np.ndarray:
    """The projection of samples at these places (n, 2) to what no plane, or no parabola, through them follows."""
    x, y = (places - places.mean(axis=0)).T
    smooth = [np.ones_like(x), x, y] + ([x * x, x * y, y * y] if len(x) > 6 else [])
    basis = np.linalg.qr(np.stack(smooth, axis=1))[0]
    return np.eye(len(x)) - basis @ basis.T
