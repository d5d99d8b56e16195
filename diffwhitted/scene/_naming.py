"""From a name to the number that it stands for: reading, replacing, and what is said of a name that means nothing."""

from typing import Any

import jax.numpy as jnp
import numpy as np

from .._errors import SceneError
from ..records import is_traced, nearest_name, number_array, rows_of
from ._classes import MaterialClass
from ._coefficients import BY_NAME
from ._parameters import FAMILIES, WITHOUT_NAME, Index, Parameter, members, numbers_of, parameters, texels_of
from ._scene import Scene
from ._settings import settings_under


def find_parameter(scene: Scene, name: str) -> tuple[Parameter, Index | None]:
    """What a name stands for and, where it names one number of several, where that lies in the value.

    Raises `SceneError` naming the nearest record, key or component.
    """
    family, _, rest = name.partition(".")
    known_material = _of_material(scene, name) or _of_material(scene, name.removeprefix("material."))
    if known_material is None and (family in FAMILIES or family in WITHOUT_NAME):
        parameter, component = _of_family(scene, name, family, rest)
    elif known_material is None:
        parameter, component = _no_material(scene, name.removeprefix("material."))
    else:
        parameter, component = known_material
    return parameter, parameter.index(scene, component) if component else None


def parameter_value(scene: Scene, name: str):
    """The value of a number of the scene by its name, or of one of its components. Raises `SceneError` for an unknown
    name.
    """
    parameter, index = find_parameter(scene, name)
    value = parameter.value(scene)
    return value if index is None else value[index]


def replace_parameter(scene: Scene, name: str, value) -> Scene:
    """The scene with one of its numbers replaced by name, or one component of it; differentiable in `value`.

        jax.grad(lambda x: loss(render(replace_parameter(scene, "light.key.position.x", x), camera)))(3.0)

    Of a camera it is `scene.cameras[NAME]` that changes. Raises `SceneError` for an unknown name, a wrong shape, or a
    value that is not allowed (a traced value is not checked).
    """
    parameter, index = find_parameter(scene, name)
    if index is not None:
        value = _with_component(parameter.value(scene), index, number_array(value, parameter.place, name, ((),)))
    return parameter.replaced(scene, value)


def _with_component(whole, index: Index, value):
    """An array with one of its numbers replaced, on the host where both are concrete."""
    if is_traced(whole) or is_traced(value):
        return jnp.asarray(whole).at[index].set(value)
    changed_one = np.array(whole)
    changed_one[index] = value
    return changed_one


def _of_material(scene: Scene, name: str) -> tuple[Parameter, str] | None:
    """The coefficient of a material and a component of it; a material's own name may hold dots."""
    whole, _, component = name.rpartition(".")
    for name_of, part in ((name, ""), (whole, component)):
        material, _, coefficient = name_of.rpartition(".")
        if material in scene.materials and coefficient in BY_NAME:
            if not scene.materials[material].has(coefficient):
                raise _not_of_class(material, coefficient, scene.materials[material].kind)
            return Parameter("material", material, BY_NAME[coefficient]), part
    return None


def _of_family(scene: Scene, name: str, family: str, rest: str) -> tuple[Parameter, str]:
    """What a name that begins with a family word stands for, and a component of it."""
    if family in WITHOUT_NAME:
        owner, rest, known = (
            settings_under(scene, rest) if family == "scene" else ("", rest, numbers_of(scene.background))
        )
        key, component = _parted(rest)
        rows = {row.name: row for row in known}
    else:
        there = members(scene, family)
        owner, key, component = rest.partition(".")[0], *_parted(rest.partition(".")[2])
        for dotted in (member for member in there if "." in member and f"{rest}.".startswith(f"{member}.")):
            raise SceneError(
                f"parameter {name!r}: the name of the {family} {dotted!r} has a dot in it, so its numbers have no "
                "names; rename it in the scene"
            )
        if owner not in there:
            names = ", ".join(there) or "none at all"
            raise SceneError(
                f"parameter {name!r}: no {family} {owner!r}; there is {names}.{nearest_name(owner, there)}"
            )
        rows = {row.name: row for row in (*numbers_of(there[owner]), *texels_of(there[owner]))}
        absent = rows_of(there[owner]).get(key)
        if absent is not None and absent.numeric and key not in rows:
            raise SceneError(f"parameter {name!r}: {family} {owner!r} states no {key}; write one in the scene")
    if key not in rows:
        what = f"{family} {owner!r}" if owner else f"the {family}"
        wanted = f"no number {key!r}" if key else "which of its numbers?"
        raise SceneError(f"parameter {name!r}: {what}: {wanted}; there is {', '.join(rows)}.{nearest_name(key, rows)}")
    return Parameter(family, owner, rows[key]), component


def _parted(rest: str) -> tuple[str, str]:
    """A key and a component of it."""
    key, _, component = rest.partition(".")
    return key, component


def _no_material(scene: Scene, name: str) -> Any:
    """Raise the `SceneError` for a name that is no material's coefficient."""
    material, _, coefficient = name.rpartition(".")
    if not material:
        raise SceneError(
            f"coefficient {name!r}: allowed is MATERIAL.COEFFICIENT, such as 'glass.k_d', or a name that begins "
            f"with one of {', '.join((*FAMILIES, *WITHOUT_NAME))}"
        )
    if material not in scene.materials:
        nearest = nearest_name(material, scene.materials) or nearest_name(name, [p.name for p in parameters(scene)])
        raise SceneError(
            f"coefficient {name!r}: no material {material!r}; there is {', '.join(scene.materials)}.{nearest}"
        )
    raise SceneError(
        f"coefficient {name!r}: no coefficient {coefficient!r}; there is "
        f"{', '.join(BY_NAME)}.{nearest_name(coefficient, BY_NAME)}"
    )


def _not_of_class(material: str, coefficient: str, kind: MaterialClass) -> SceneError:
    if kind.stated(coefficient):
        return SceneError(
            f"coefficient '{material}.{coefficient}': material {material!r} states none; write one in the scene, "
            "not zero"
        )
    has = ", ".join(kind.has or ())
    return SceneError(
        f"coefficient '{material}.{coefficient}': material {material!r} is of class {kind.name!r}, which has no "
        f"{coefficient}; there is {has}"
    )
