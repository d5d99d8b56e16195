"""The light of the patches of a scene, for programs that want it itself."""

import equinox as eqx
import numpy as np
from jaxtyping import Array, Bool, Float, Int

from ._errors import SceneError
from .scene import Interreflection, Scene, patch_light, patches_in, whole_number


class PatchLight(eqx.Module):
    """Patches, their form factors and their light (Hearn and Baker 14-7). Metres, linear RGB."""

    form_factors: Float[Array, "n n"]
    """F_jk of (14-82): the share of what leaves patch j that arrives at k; A_j F_jk = A_k F_kj."""
    radiosity: Float[Array, "n 3"]
    """B: the light that leaves each patch, pi times the radiance; differentiable in reflectances, emissions, lamps."""
    emitted: Float[Array, "n 3"]
    """E: what it sends of its own and of the lamps."""
    reflectance: Float[Array, "n 3"]
    """k_d, with its texture."""
    areas: Float[np.ndarray, "n"]
    """Square metres."""
    object: Int[np.ndarray, "n"]
    """The object of each patch, by its place in `scene.objects`."""
    centres: Float[np.ndarray, "n 3"]
    normals: Float[np.ndarray, "n 3"]
    """Unit, on the side of the surface that the patch is on."""
    corners: Float[np.ndarray, "n v 3"]
    """Counter-clockwise seen from that side; shorter ones repeat the last."""
    closed: Bool[np.ndarray, "n"]
    """No light from it leaves the scene: the sum of its row is 1."""
    residual: float = eqx.field(static=True)
    """The most by which the sum of a closed row is off 1."""
    imbalance: float = eqx.field(static=True)
    """The same before these rows were balanced: how far the form factors themselves are off."""


def radiosity(
    scene: Scene, patches: int | None = None, *, solver: str | None = None, shots: int | None = None
) -> PatchLight:
    """Cut a scene into about `patches` patches, and solve (I - rho F) B = E for what each sends out.

        found = radiosity(scene, patches=500)
        found.form_factors[j, k], found.radiosity[j]

    - `patches`, `solver` ("direct", "gauss-seidel", "progressive"): by default those of the scene, else 500 and
      "progressive". Every solver gives the same answer.
    - `shots`: of progressive refinement, stop after so many and add the ambient estimate of the light that is yet to
      be shot; a picture of the way to the answer. No derivatives in reverse.

    Lamps light patches as they light points in the ray tree, pi k_d c s (N.L); emission is radiance, so E = pi
    emission; objects of any material block light, and only k_d sends it back. Under `jit`, `grad` and `jvp` materials
    and lamps may be traced, geometry may not. Raises `SceneError` for traced geometry, for kinds of objects without
    patches, for k_d above 1, for more than 6000 patches (form factors of 6000 take 275 MiB several times over), and for
    a solver that there is not.
    """
    stated = {name: value for name, value in (("patches", patches), ("solver", solver)) if value is not None}
    way = Interreflection.of(vars(scene.radiosity or Interreflection()) | stated, "radiosity")
    if shots is not None:
        whole_number(shots, "radiosity: shots", 0)
        if way.solver != "progressive":
            raise SceneError(
                f'radiosity: shots = {shots} with solver = {way.solver!r}; allowed with "progressive" only'
            )
    factors, tables = patches_in(scene, way.patches)
    found, of = patch_light(scene, tables, way.solver, shots), factors.patches
    return PatchLight(
        tables.matrix, found.radiosity, found.emitted, found.reflectance, of.area, of.object, of.centre, of.normal,
        of.loops, factors.closed, factors.residual, factors.imbalance,
    )  # fmt: skip
