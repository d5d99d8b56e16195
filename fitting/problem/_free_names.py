"""From free names such as "*.k_d", "light.*" and "object.ball.centre.x" to the parameters of a scene."""

import fnmatch
from collections.abc import Collection, Sequence

import numpy as np

from diffwhitted import SceneError
from diffwhitted.scene import (
    BY_NAME,
    FAMILIES,
    WITHOUT_NAME,
    Parameter,
    Scene,
    find_parameter,
    nearest_name,
    parameters,
)
from diffwhitted.tree import idle

from .._errors import FitError
from ._freedoms import parts_of


def free_parameters(
    scene: Scene, patterns: Sequence[str], max_depth: int | None = None, cameras: Collection[str] | None = None
) -> tuple[tuple[str, ...], tuple[tuple[str, str], ...]]:
    """The names of the parameters (or of single components of them) that the patterns name, in the order of the scene,
    and those passed over with the reason.

    "*" and "*.k_d" match materials only; others need their family word ("light.*"). A pattern with a wildcard passes
    over what cannot change the image. Raises `FitError` for a pattern that matches nothing, and for a plain name that
    cannot change the image. `cameras`: those whose pictures count.
    """
    patterns = free_list(patterns)
    if not patterns:
        raise FitError('free: no coefficient is free; name some, such as free=["glass.k_d"] or "*.k_s"')
    there = parameters(scene)
    chosen: dict[Parameter, set[str]] = {}
    plain: set[Parameter] = set()
    for pattern in patterns:
        matches, is_plain = match_parameters(scene, there, pattern)
        for parameter, component in matches:
            chosen.setdefault(parameter, set()).add(component)
        plain |= {parameter for parameter, _ in matches} if is_plain else set()
    wholes = [parameter.name for parameter in chosen]
    reasons = {p: why for p in there if p in chosen and (why := idle(scene, p, wholes, max_depth, cameras))}
    for parameter in sorted(plain & set(reasons), key=lambda p: p.name):
        raise FitError(
            f"free: {parameter.name} = {shown(parameter.value(scene))} has no effect on the image: {reasons[parameter]}"
        )
    names = tuple(name for p in there if p in chosen and p not in reasons for name in _named(scene, p, chosen[p]))
    if not names:
        raise FitError(
            f"free: nothing that {', '.join(patterns)} matches has an effect on the image: "
            + "; ".join(f"{p.name}: {why}" for p, why in list(reasons.items())[:4])
        )
    return names, tuple((p.name, why) for p, why in reasons.items())


def free_list(patterns: Sequence[str]) -> tuple[str, ...]:
    """Several names, where one may be given alone."""
    return (patterns,) if isinstance(patterns, str) else tuple(patterns)


def whole_names(scene: Scene, names: Sequence[str]) -> tuple[str, ...]:
    """The names of the parameters to which these names, or components, belong."""
    return tuple(dict.fromkeys(split_free(scene, name)[0].name for name in names))


def split_free(scene: Scene, name: str) -> tuple[Parameter, str]:
    """The parameter that a free name stands for and the component of it that is free, empty for all.

    Raises `FitError` for a component that is not free by itself, such as one of a direction, and `SceneError` for an
    unknown name.
    """
    for whole in (name, name.rpartition(".")[0], name.rpartition(".")[0].rpartition(".")[0]):
        try:
            parameter, index = find_parameter(scene, whole)
        except SceneError:
            continue
        component = name[len(whole) + 1 :]
        known = [part.component for part in parts_of(scene, parameter)]
        if index is None and component in ("", *known):
            return parameter, component
    parameter, _ = find_parameter(scene, name)
    raise FitError(
        f"free: {name} is not free by itself; {parameter.name} is free by {', '.join(known_parts(scene, parameter))}, "
        "or as a whole"
    )


def known_parts(scene: Scene, parameter: Parameter) -> list[str]:
    """The full names of the unknowns of a parameter."""
    return [f"{parameter.name}.{part.component}".rstrip(".") for part in parts_of(scene, parameter)]


def _named(scene: Scene, parameter: Parameter, components: set[str]) -> list[str]:
    """A parameter as a whole, or some of its components, by their names in order."""
    order = [part.component for part in parts_of(scene, parameter)]
    if "" in components or components >= set(order):
        return [parameter.name]
    return [f"{parameter.name}.{component}" for component in order if component in components]


def match_parameters(
    scene: Scene, there: Sequence[Parameter], pattern: str
) -> tuple[list[tuple[Parameter, str]], bool]:
    """The parameters (with a component, or none) that a pattern names, and whether it is the plain name of one."""
    family = pattern.partition(".")[0]
    mine = [p for p in there if p.family == family] if family in (*FAMILIES, *WITHOUT_NAME) else []
    materials = [p for p in there if p.family == "material"]
    by_name = {p.name: p for p in there} | {f"material.{p.name}": p for p in materials}
    if pattern in by_name:
        return [(by_name[pattern], "")], True
    if not _is_pattern(pattern):
        return [_plain(scene, pattern, by_name)], True
    # Whole parameters first, then their components; those of a family only where its word comes first.
    groups = (
        [(p.name, p) for p in mine],
        [(p.name, p) for p in materials] + [(f"material.{p.name}", p) for p in materials],
    )
    for names in groups:
        found = [(p, "") for name, p in names if fnmatch.fnmatchcase(name, pattern)]
        found = found or [
            (p, part.component)
            for name, p in names
            for part in parts_of(scene, p)
            if part.component and fnmatch.fnmatchcase(f"{name}.{part.component}", pattern)
        ]
        if found:
            return found, False
    return [_plain(scene, pattern, by_name)], True


def _plain(scene: Scene, name: str, known: Collection[str]) -> tuple[Parameter, str]:
    """The parameter of a plain name and its component. Raises `FitError` where there is none."""
    try:
        return split_free(scene, name)
    except SceneError as error:
        if name.partition(".")[0] in (*FAMILIES, *WITHOUT_NAME) or " has no component " in str(error):
            raise FitError(f"free: {error}") from None
        families = ", ".join((*FAMILIES, *WITHOUT_NAME))
        raise FitError(
            f"free: {name!r} matches no coefficient; names are MATERIAL.COEFFICIENT with materials "
            f"{', '.join(scene.materials)} and coefficients {', '.join(BY_NAME)}, or begin with one of {families}."
            f"{nearest_name(name, known)}"
        ) from None


def _is_pattern(name: str) -> bool:
    return any(character in name for character in "*?[")


def shown(value) -> str:
    return np.array2string(np.asarray(value), precision=4, separator=", ", legacy=False)
