"""Materials of glTF as coefficients: the reverse of `_materials`, as far as there is one.

Base colour C, transmission t and metallic m become k_d = (1 - t)(1 - m) C and k_t = t (1 - m) C. What is smooth
(alpha = roughness^2 below `SMOOTH`) mirrors with its Fresnel reflectance F0 seen straight on; what is rough has a
halfway highlight of the exponent n = 2 / alpha^2 - 2 and k_h = F0 (n + 2) / 8 (Walter et al. 2007, equation 30).
"""

import tempfile
from pathlib import Path
from typing import Any

import numpy as np

from ..._errors import InputError, SceneError
from ...scene import ImageTexture, Material
from .._losses import Losses
from ._arrays import Content

SMOOTH = 0.05
USUAL_INDEX = 1.5
WRAPS = {10497: "repeat", 33071: "clamp", 33648: "mirror"}
LEAST_ALPHA = 1e-3


class Pictures:
    """The textures that materials wear, each read once."""

    def __init__(self, content: Content, lost: Losses):
        self._content, self._lost, self.textures = content, lost, {}
        self._names: dict[tuple[int, float | None], str] = {}

    def worn(self, stated: dict[str, Any], where: str, steepness: float | None = None) -> str:
        """The name of the texture that a material states; with `steepness` it is one of normals, so many times as
        steep.
        """
        content, number = self._content, stated.get("index", -1)
        texture = content.one("textures", number, where)
        if stated.get("texCoord", 0):
            self._lost.say("second sets of texture coordinates are lost: the first are taken")
        if "KHR_texture_transform" in stated.get("extensions", {}):
            self._lost.say("transforms of textures are lost")
        if (number, steepness) not in self._names:
            image = content.one("images", texture.get("source"), where)
            kind = "picture" if steepness is None else "normals"
            name = f"{image.get('name') or kind}_{number + 1}".replace(".", "_")
            name = f"{name}_normals" if name in self.textures else name
            sampler = content.one("samplers", texture["sampler"], where) if "sampler" in texture else {}
            encoding = None if steepness is None else "linear"
            texels, file = self._texels(image, where, encoding)
            if steepness is not None and not (texels[..., 2] > 0.5).all():
                raise SceneError(f"picture {name} has normals that point into the surface (blue at most 0.5)")
            if steepness not in (None, 1.0):
                texels, file, encoding = _steepened(texels, steepness), None, None
            wrap: Any = WRAPS.get(sampler.get("wrapS", 10497), "repeat")
            self.textures[name] = ImageTexture(
                texels, wrap=wrap, file=file, encoding=encoding, place=f"{content.source}: {name}"
            )
            self._names[number, steepness] = name
        return self._names[number, steepness]

    def _texels(self, image: dict[str, Any], where: str, encoding: str | None) -> tuple[np.ndarray, str | None]:
        """Linear texels, and the file that holds them if there is one."""
        from ...image import read_image  # OpenImageIO takes long to load

        uri, content = image.get("uri"), self._content
        try:
            if uri is not None and not uri.startswith("data:"):
                path = content.path(uri, where)
                return read_image(path, encoding=encoding).pixels, str(path)
            view = image.get("bufferView")
            data = content.file(uri, where) if uri else content.bytes_of_view(view, where)
            with tempfile.TemporaryDirectory() as folder:
                kind = (image.get("mimeType") or (uri or "").partition(";")[0].removeprefix("data:")).rpartition("/")[2]
                file = Path(folder) / f"picture.{kind or 'png'}"
                file.write_bytes(data)
                return read_image(file, encoding=encoding).pixels, None
        except InputError as error:
            raise SceneError(f"{content.source}: {where}: a picture cannot be read: {error}") from None


def material_in(content: Content, stated: dict[str, Any], name: str, pictures: Pictures, lost: Losses) -> Material:
    """The coefficients of a material of a file."""
    what, where = ("material", name), f"material {name!r}"
    rough, extensions = stated.get("pbrMetallicRoughness", {}), stated.get("extensions", {})
    base = np.asarray(rough.get("baseColorFactor", (1, 1, 1, 1)), float)[:3]
    metal, alpha = float(rough.get("metallicFactor", 1.0)), float(rough.get("roughnessFactor", 1.0)) ** 2
    through = float(extensions.get("KHR_materials_transmission", {}).get("transmissionFactor", 0.0))
    index = float(extensions.get("KHR_materials_ior", {}).get("ior", USUAL_INDEX))
    specular = extensions.get("KHR_materials_specular", {})
    tint = np.asarray(specular.get("specularColorFactor", (1, 1, 1)), float) * specular.get("specularFactor", 1.0)
    # Reflectance seen straight on: of the metal its colour, of all else by the index.
    straight_on = np.minimum(((index - 1) / (index + 1)) ** 2 * tint, 1)
    facets = metal * base + (1 - metal) * straight_on
    coefficients: dict[str, Any] = {"k_a": 0.0, "k_d": (1 - through) * (1 - metal) * base, "k_h": 0.0}
    if through:
        coefficients |= {"k_t": through * (1 - metal) * base, "refractive_index": max(index, 1.0)}
    if alpha < SMOOTH:
        coefficients["k_s"] = facets
    else:
        exponent = 2 / max(alpha, LEAST_ALPHA) ** 2 - 2
        coefficients |= {"k_h": facets * (exponent + 2) / 8, "phong_exponent": max(exponent, 0.01)}
        if metal > 0.5:
            lost.say(f"{{}} is rough metal (roughness {np.sqrt(alpha):.2g}): only its highlights are kept", what)
    if "metallicRoughnessTexture" in rough:
        lost.say("the texture of metal and roughness of {} is lost", what)
    for key, said in (("occlusionTexture", "occlusion"), ("emissiveTexture", "emission")):
        if key in stated:
            lost.say(f"the texture of {said} of {{}} is lost", what)
    if any(stated.get("emissiveFactor", ())):
        lost.say("the light that {} emits is lost", what)
    if stated.get("alphaMode", "OPAQUE") != "OPAQUE":
        lost.say("{} is taken as opaque: alpha is not read", what)
    for extension in sorted(set(extensions) - {f"KHR_materials_{known}" for known in KNOWN}):
        lost.say(f"{extension} of {{}} is lost", what)
    if "baseColorTexture" in rough:
        worn = pictures.worn(rough["baseColorTexture"], where)
        coefficients |= {f"{key}_texture": worn for key in ("k_d", "k_t") if np.any(coefficients.get(key, 0))}
    if "normalTexture" in stated:
        normals = stated["normalTexture"]
        try:
            coefficients["normal_texture"] = pictures.worn(normals, where, float(normals.get("scale", 1.0)))
        except SceneError as error:
            lost.say(f"the texture of normals of {{}} is lost: {error}", what)
    return Material(**coefficients)


def _steepened(texels: np.ndarray, by: float) -> np.ndarray:
    """Normals so many times as steep."""
    normal = (2 * texels - 1) * np.asarray([by, by, 1.0], texels.dtype)
    return 0.5 + 0.5 * normal / np.linalg.norm(normal, axis=-1, keepdims=True)


KNOWN = ("ior", "specular", "transmission", "volume")
