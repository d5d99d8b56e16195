"""Names of coefficients, such as "glass.k_d": reading and replacing."""

import equinox as eqx
import jax.numpy as jnp

from .._errors import SceneError
from ..records import nearest_name
from ._coefficients import BY_NAME
from ._material import checked
from ._scene import Scene


def split_name(scene: Scene, name: str) -> tuple[str, str]:
    """("glass", "k_d") from "glass.k_d"; a material's own name may hold dots.

    Raises `SceneError` naming the nearest material or coefficient.
    """
    material, _, coefficient = name.rpartition(".")
    if not material:
        raise SceneError(f"coefficient {name!r}: allowed is MATERIAL.COEFFICIENT, such as 'glass.k_d'")
    if material not in scene.materials:
        raise SceneError(
            f"coefficient {name!r}: no material {material!r}; there is "
            f"{', '.join(scene.materials)}.{nearest_name(material, scene.materials)}"
        )
    if coefficient not in BY_NAME:
        raise SceneError(
            f"coefficient {name!r}: no coefficient {coefficient!r}; there is "
            f"{', '.join(BY_NAME)}.{nearest_name(coefficient, BY_NAME)}"
        )
    return material, coefficient


def coefficient_value(scene: Scene, name: str):
    """The value of a coefficient: shape () or, for linear RGB, (3,). An absent k_h reads as k_s."""
    material, coefficient = split_name(scene, name)
    return scene.materials[material].at_work(coefficient)


def replace_coefficient(scene: Scene, name: str, value) -> Scene:
    """The scene with one coefficient replaced; differentiable in `value`.

    `name` is "material.coefficient", `value` a number or, where the coefficient has a colour, three.

        jax.grad(lambda k: loss(render(replace_coefficient(scene, "glass.k_d", k), camera)))(0.12)

    Raises `SceneError` for an unknown name, a wrong shape, or a value outside the interval of
    `COEFFICIENTS` (a traced value is not checked).
    """
    material, coefficient = split_name(scene, name)
    array = jnp.asarray(checked(coefficient, value, f"material {material!r}"), scene.dtype)
    return eqx.tree_at(lambda s: s.materials[material].values[coefficient], scene, array, is_leaf=lambda x: x is None)
