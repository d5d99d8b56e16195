"""Names of coefficients, such as "glass.k_d": reading and replacing. All other numbers are reached in the same way."""

from ._naming import parameter_value, replace_parameter
from ._scene import Scene


def coefficient_value(scene: Scene, name: str):
    """The value of a coefficient: shape () or, for linear RGB, (3,). An absent k_h reads as k_s.

    Takes the names of `parameters` too. Raises `SceneError` naming the nearest material or coefficient.
    """
    return parameter_value(scene, name)


def replace_coefficient(scene: Scene, name: str, value) -> Scene:
    """The scene with one coefficient replaced; differentiable in `value`.

    `name` is "material.coefficient", or another of the names of `parameters`; `value` a number or, where the
    coefficient has a colour, three.

        jax.grad(lambda k: loss(render(replace_coefficient(scene, "glass.k_d", k), camera)))(0.12)

    Raises `SceneError` for an unknown name, a wrong shape, or a value outside the interval of
    `COEFFICIENTS` (a traced value is not checked).
    """
    return replace_parameter(scene, name, value)
