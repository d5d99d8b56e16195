"""Which of the channels, layers and parts of a file are its picture."""

import numpy as np
import pytest
from image_samples import refusal, store, store_parts

from diffwhitted.image import read_image, read_mask

RGB = ("R", "G", "B")


def flat(*values):
    return np.broadcast_to(np.float32(values), (2, 3, len(values)))


def colour(read):
    return read.pixels[0, 0].tolist()


def test_the_part_with_colour_is_the_picture_and_depth_never_is(tmp_path):
    path = store_parts(tmp_path / "a.exr", ("depth", ("Z",), flat(9)), ("rgba", RGB, flat(1, 2, 3)))
    read = read_image(path)
    assert (colour(read), read.monochrome) == ([1, 2, 3], False)
    assert read.notes == ("Of the 2 parts of the file, 'rgba' was read.",)
    for wanted in ("depth", "Z", "depth.Z"):
        message = refusal(read_image, path, layer=wanted)
        assert "depth: Z, rgba: R, rgba: G, rgba: B" in message and "'rgba'" in message
    for names, values in ((("Z",), flat(9)), (("Depth.Z",), flat(9)), (("A", "Z"), flat(1, 9))):
        assert ", ".join(names) in refusal(read_image, store(tmp_path / "b.exr", values, names=names))
    named = store_parts(tmp_path / "c.exr", ("depth", ("Y",), flat(9)), ("ao", ("AO",), flat(1)))
    assert "depth: Y, ao: AO" in refusal(read_image, named)
    assert colour(read_image(named, layer="ao.AO")) == [1, 1, 1]


def test_a_part_or_layer_by_its_name(tmp_path):
    parts = ("left", RGB, flat(1, 2, 3)), ("right", ("R", "G", "B", "key.R", "key.G", "key.B"), flat(4, 5, 6, 7, 8, 9))
    path = store_parts(tmp_path / "a.exr", *parts)
    message = refusal(read_image, path)
    assert all(name in message for name in ("'left'", "'right'", "'key'", "FILE:NAME", "layer = NAME"))
    expected = {"left": [1, 2, 3], "right": [4, 5, 6], "key": [7, 8, 9], "right.key": [7, 8, 9]}
    for name, light in expected.items():
        assert colour(read_image(path, layer=name)) == light
        read = read_image(f"{path}:{name}")
        assert (colour(read), read.path, read.notes) == (light, path, ())
    assert "'middle'" in refusal(read_image, path, layer="middle")


def test_what_is_outside_of_layers_comes_first(tmp_path):
    names = ("diffuse.R", "diffuse.G", "diffuse.B", *RGB, "Z")
    path = store(tmp_path / "a.exr", flat(1, 2, 3, 4, 5, 6, 7), names=names)
    assert colour(read_image(path)) == [4, 5, 6]
    assert colour(read_image(path, layer="diffuse")) == [1, 2, 3]


def test_a_place_or_a_normal_is_no_picture(tmp_path):
    names = ("N.X", "N.Y", "N.Z", "beauty.R", "beauty.G", "beauty.B")
    path = store(tmp_path / "a.exr", flat(1, 2, 3, 4, 5, 6), names=names)
    assert colour(read_image(path)) == [4, 5, 6]
    assert "has no R, G, B" in refusal(read_image, path, layer="N")


@pytest.mark.parametrize("names", [("R",), ("Y",), ("key.Y",), ("intensity",), ("Y", "Z"), ("R", "A")])
def test_one_channel_is_grey(tmp_path, names):
    read = read_image(store(tmp_path / "a.exr", flat(0.5, 1)[..., : len(names)], names=names))
    assert (colour(read), read.monochrome) == ([0.5] * 3, True)


def test_a_colon_in_the_name_of_a_file_is_a_part_of_it(tmp_path):
    store(tmp_path / "a.exr", flat(1, 2, 3), names=("key.R", "key.G", "key.B"))
    (tmp_path / "a.exr:key").write_bytes((tmp_path / "a.exr").read_bytes())
    assert read_image(tmp_path / "a.exr:key").path == tmp_path / "a.exr:key"
    assert "no such file" in refusal(read_image, tmp_path / "b.exr:key")
    assert "no such file" in refusal(read_image, tmp_path / "a.exr:")


def test_a_mask_may_be_a_layer(tmp_path):
    path = store(tmp_path / "a.exr", flat(9, 9, 9, 0.25), names=(*RGB, "matte.Y"))
    assert (read_mask(f"{path}:matte") == 0.25).all()
    assert (read_mask(store(tmp_path / "b.exr", flat(0.5), names=("A",))) == 0.5).all()


def test_a_file_without_layers_has_none_to_ask_for(tmp_path):
    assert "'key'" in refusal(read_image, store(tmp_path / "a.png", np.zeros((1, 1, 3), np.uint8)), layer="key")
