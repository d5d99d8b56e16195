"""What other programs call the keys of a scene file, and what people mean by them."""

from collections.abc import Iterable

ELSEWHERE = {
    "center": "centre",
    "color": "colour",
    "colors": "colours",
    "points": "vertices",
    "distance": "offset",
    "ior": "refractive_index",
    "index": "refractive_index",
    "index_of_refraction": "refractive_index",
    "eta": "refractive_index",
    "shininess": "phong_exponent",
    "exponent": "phong_exponent",
    "n": "phong_exponent",
    "diffuse": "k_d",
    "specular": "k_h",
    "reflectivity": "k_s",
    "reflection": "k_s",
    "transparency": "k_t",
    "transmission": "k_t",
    "eye": "look_from",
    "from": "look_from",
    "to": "look_at",
    "target": "look_at",
    "matrix": "pose",
    "transform_matrix": "pose",
    "camera_to_world": "pose",
    "fx": "focal",
    "fy": "focal",
    "fl_x": "focal",
    "fl_y": "focal",
    "focal_length": "focal",
    "cx": "principal_point",
    "cy": "principal_point",
    "k1": "distortion",
    "k2": "distortion",
    "p1": "distortion",
    "p2": "distortion",
    "ortho_scale": "view_height",
    "projection": "type",
    "fov": "vfov_deg",
    "vfov": "vfov_deg",
    "settings": "scene",
    "sphere": "object",
    "plane": "object",
    "triangle": "object",
    "polygon": "object",
    "shape": "object",
}
"""By the key in lower case."""
MATERIALS = {
    "Ka": ("k_a", "MTL's Ka is k_a here"),
    "Kd": ("k_d", "MTL's Kd is k_d here"),
    "Ks": ("k_h", "MTL's Ks is the highlight, k_h here (k_s is the mirror)"),
    "Ke": ("emission", "MTL's Ke is emission here"),
    "Ns": ("phong_exponent", "MTL's Ns is phong_exponent here"),
    "Ni": ("refractive_index", "MTL's Ni is refractive_index here"),
    "d": ("k_t", "MTL's d is the opacity; here k_t = 1 - d is the share of light that passes"),
    "Tr": ("k_t", "MTL's Tr is the transparency, k_t here"),
    "Tf": ("k_t", "MTL's Tf is the colour of what passes, k_t here"),
    "illum": (None, "MTL's illum chooses the terms; here each is there where its coefficient is not zero"),
    "map_Ka": ("k_a_texture", "MTL's map_Ka is k_a_texture here, the name of a [[texture]]"),
    "map_Kd": ("k_d_texture", "MTL's map_Kd is k_d_texture here, the name of a [[texture]]"),
    "map_Ks": ("k_h_texture", "MTL's map_Ks is k_h_texture here, the name of a [[texture]]"),
    "int_ior": ("refractive_index", "Mitsuba's int_ior is refractive_index here"),
    "ext_ior": (None, "the index outside is that of the solid around, 1 in the open; leave ext_ior out"),
    "diffuse_reflectance": ("k_d", "Mitsuba's diffuse_reflectance is k_d here"),
    "specular_reflectance": ("k_s", "Mitsuba's specular_reflectance is k_s here of a mirror, k_h of a highlight"),
    "specular_transmittance": ("k_t", "Mitsuba's specular_transmittance is k_t here"),
    "alpha": ("phong_exponent", "a roughness alpha of Mitsuba is about phong_exponent = 2 / alpha^2 - 2 here"),
    "metallic": ("k_s", 'Blender\'s metallic is class = "metal" here, with k_s the colour of the metal'),
    "base_color": ("k_d", "Blender's base colour is k_d here"),
    "ambient": ("k_a", "POV-Ray's ambient is k_a here"),
    "phong": ("k_h", "POV-Ray's phong is k_h here"),
    "phong_size": ("phong_exponent", "POV-Ray's phong_size is phong_exponent here"),
    "transmit": ("k_t", "POV-Ray's transmit is k_t here"),
    "filter": ("k_t", "POV-Ray's filter is k_t here, in the colour of the glass"),
}
"""Of a material: the key here, if there is one, and what to say. Capital letters count, as they do in MTL."""


def elsewhere(key: str, known: Iterable[str], table: str) -> tuple[str | None, str]:
    """The key that a key of another program stands for, and a sentence about it; None and nothing without one."""
    meant, said = MATERIALS.get(key, (None, "")) if table == "material" else (None, "")
    if said:
        return meant if meant in known else None, said
    plain = ELSEWHERE.get(key.lower().replace("-", "_"))
    return (plain, "") if plain in known else (None, "")
