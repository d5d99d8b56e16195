"""What is wrong with a scene file: one readable message that names the place, the value and the way out."""

import functools
import tomllib
from pathlib import Path

import jax
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from diffwhitted._errors import SceneError
from diffwhitted.formats import load_scene, parse_scene, scene_schema

FILE = Path(__file__).with_name("every_key.toml").read_text()


def refused(text: str, **options) -> str:
    """The message for a broken file, on one subject and free of the machinery behind it."""
    with pytest.raises(SceneError) as caught:
        parse_scene(text, source="objects.toml", **options)
    message = str(caught.value)
    assert message.startswith("objects.toml: ")
    assert not any(word in message.lower() for word in ("pydantic", "traceback", "validation error", "input_value"))
    assert len(message) < 1500
    return message


def changed(old: str, new: str) -> str:
    assert old in FILE
    return FILE.replace(old, new, 1)


# What is wrong with a file, by what is changed in it and the words that its message must hold

FAULTS = {
    "negative radius": ("radius = 1", "radius = -1", 'object "ball" (1st [[object]])', "radius = -1", "allowed is > 0"),
    "index below 1": (
        "refractive_index = 1.5",
        "refractive_index = 0.9",
        'material "glass" (1st [[material]])',
        "= 0.9",
        ">= 1",
    ),
    "negative colour": ("k_a = 0.012", "k_a = [1, -2, 1]", 'material "glass"', "k_a = [1, -2, 1]", ">= 0"),
    "negative light": ("[0.9, 0.9, 0.9]", "[0.9, -0.9, 0.9]", "1st [[light]]", "colour = [0.9, -0.9, 0.9]", ">= 0"),
    "no such key": (
        "radius = 1",
        "radus = 1",
        'object "ball"',
        '"radius"?',
        "centre, radius, scale, rotate_deg, translate, matrix",
    ),
    "center": ("centre =", "center =", 'object "ball"', "unknown key center", 'Did you mean "centre"?'),
    "color": ("colour =", "color =", "1st [[light]]", "unknown key color", 'Did you mean "colour"?'),
    "ior": ("refractive_index =", "ior =", 'material "glass"', "ior = 1.5", 'Did you mean "refractive_index"?'),
    "bubble by radius": ("radius = 1", "radius = -0.7", "put a sphere of refractive_index 1 inside the glass"),
    "bubble by index": (
        "refractive_index = 1.5",
        "refractive_index = 0.75",
        "put a sphere of index 1 inside the glass",
        "the camera inside the water",
    ),
    "MTL Ks": (
        "k_h = 0.3",
        "Ks = 0.3",
        "unknown key Ks = 0.3. MTL's Ks is the highlight, k_h here (k_s is the mirror).",
    ),
    "MTL Kd": ("k_d =", "Kd =", "MTL's Kd is k_d here."),
    "MTL Ns": ("phong_exponent =", "Ns =", "MTL's Ns is phong_exponent here."),
    "MTL Ni": ("refractive_index =", "Ni =", "MTL's Ni is refractive_index here."),
    "MTL d": ("k_t =", "d =", "MTL's d is the opacity; here k_t = 1 - d"),
    "MTL illum": ("k_a = 0.012", "illum = 2", "each is there where its coefficient is not zero. Allowed are"),
    "Mitsuba": ("refractive_index =", "int_ior =", "Mitsuba's int_ior is refractive_index here."),
    "Blender": ("k_s =", "metallic =", 'Blender\'s metallic is class = "metal" here'),
    "POV-Ray": ("phong_exponent =", "phong_size =", "POV-Ray's phong_size is phong_exponent here."),
    "kd": ("k_d =", "kd =", 'material "glass"', "unknown key kd", 'Did you mean "k_d"?'),
    "key of another shape": (
        "offset = -1",
        "offset = -1\nradius = 2",
        'object "floor"',
        "unknown key radius = 2",
        "normal, offset",
    ),
    "no such setting": ("max_depth", "depth", "scene: unknown key depth = 5", '"max_depth"', "shadows"),
    "no such table": ("[[material]]", "[[materials]]", "[materials]", "[[material]]?", "[[camera]]"),
    "shape as a table": ("[[object]]", "[[sphere]]", "[sphere]", "[[object]]?", "[[light]]"),
    "key outside a table": ("[scene]", "depth = 1\n[scene]", "depth = 1 is in no table", "[scene]", "[[object]]"),
    "single brackets": ("[[texture]]", "[texture]", "texture = {", "allowed is", "[[texture]] in double brackets"),
    "double brackets": ("[scene]", "[[scene]]", "scene = [", "allowed is", "[scene] in single brackets"),
    "missing key": (
        "radius = 1\n",
        "",
        'object "ball" (1st [[object]])',
        "radius is missing",
        "a number > 0 (Radius, metres)",
    ),
    "missing name": ('name = "glass"\n', "", "1st [[material]]", "name is missing", "text in quotes"),
    "missing type": ('type = "plane"\n', "", 'object "floor" (2nd [[object]])', "type is missing", '"sphere", "plane"'),
    "text as number": ("radius = 1", 'radius = "1"', 'object "ball"', 'radius = "1"', "Leave out the quotes"),
    "text as numbers": ("radius = 1", 'radius = "wide"', 'object "ball"', 'radius = "wide"', "a number > 0"),
    "date as number": ("radius = 1", "radius = 1979-05-27", 'object "ball"', "1979-05-27", "a number > 0"),
    "number as text": ('name = "glass"', "name = 5", "1st [[material]]", "name = 5", "text in quotes"),
    "empty name": ('name = "floor"', 'name = ""', "2nd [[object]]", 'name = ""', "at least one letter"),
    "bool as number": ("radius = 1", "radius = true", 'object "ball"', "radius = true", "a number > 0"),
    "bool in a colour": (
        "k_t = 0.7",
        "k_t = [1, true, 0]",
        'material "glass"',
        "k_t = [1, true, 0]",
        "a list of 3 numbers >= 0",
    ),
    "bool as count": ("width = 320", "width = true", 'camera "main"', "width = true", "a whole number >= 1"),
    "fraction as count": (
        "max_depth = 5",
        "max_depth = 5.5",
        "scene",
        "max_depth = 5.5",
        "a whole number >= 1 and <= 64",
    ),
    "depth 0": ("max_depth = 5", "max_depth = 0", "scene", "max_depth = 0", "from 1"),
    "no pixels": ("width = 320", "width = 0", 'camera "main"', "width = 0", "from 1 to 32768"),
    "vast picture": ("width = 320", "width = 100000000000", 'camera "main"', "100000000000", "from 1 to 32768"),
    "two numbers": ("centre = [0, 0, 0]", "centre = [0, 0]", 'object "ball"', "centre = [0, 0]", "a list of 3 numbers"),
    "number for list": ("centre = [0, 0, 0]", "centre = 0", 'object "ball"', "centre = 0", "a list of 3 numbers"),
    "four in a colour": (
        "k_t = 0.7",
        "k_t = [1, 1, 1, 1]",
        'material "glass"',
        "[1, 1, 1, 1]",
        "or a list of 3 numbers",
    ),
    "colour of a number": (
        "phong_exponent = 50",
        "phong_exponent = [1, 1, 1]",
        'material "glass"',
        "[1, 1, 1]",
        "a number >= 0",
    ),
    "flat vertex": (
        "[1, 1, 0]",
        "[1, 1]",
        'object "sheet" (3rd [[object]])',
        "vertices[2] = [1, 1]",
        "a list of 3 numbers",
    ),
    "four in a triangle": (
        '"flag"\ntype = "triangle"\nvertices = [',
        '"flag"\ntype = "triangle"\nvertices = [[1, 1, 0], ',
        'object "flag"',
        "vertices = [[1, 1, 0]",
        "a list of 3 lists of 3 numbers",
    ),
    "bad gradient": (
        "background = [0.4, 0.6, 0.9]",
        "background = { gradient = 1 }",
        "scene",
        "background.gradient = 1",
        "a list of 2 lists of 3 numbers >= 0",
    ),
    "no gradient": (
        "background = [0.4, 0.6, 0.9]",
        "background = { gradent = 1 }",
        "scene",
        "unknown key background.gradent = 1",
        '"gradient"?',
    ),
    "empty background": (
        "background = [0.4, 0.6, 0.9]",
        "background = {}",
        "scene",
        "background.gradient is missing",
        "2 lists",
    ),
    "text as background": (
        "background = [0.4, 0.6, 0.9]",
        'background = "sky"',
        "scene",
        '"sky"',
        "or { gradient = a list of 2",
    ),
    "no such shape": ('"sphere"', '"spere"', 'object "ball"', 'type = "spere"', 'Did you mean "sphere"?'),
    "number as shape": (
        '"sphere"',
        "7",
        'object "ball"',
        "type = 7",
        '"sphere", "plane", "polygon", "triangle", "box", ',
    ),
    "no such light": (
        '"point"',
        '"lantern"',
        "1st [[light]]",
        'type = "lantern"',
        '"point", "directional", "spot", "warn", "sphere" or "rectangle"',
    ),
    "no such texture": ('"checker"', '"marble"', 'texture "tiles" (1st [[texture]])', 'type = "marble"', '"checker"'),
    "no such shadow": ('"opaque"', '"soft"', "scene", 'shadows = "soft"', '"opaque", "tinted" or "off"'),
    "no such highlight": ('"reflected"', '"refleted"', 'material "glass"', '"refleted"', 'Did you mean "reflected"?'),
    "bad axes": ('axes = "xz"', 'axes = "xw"', 'texture "tiles"', "'xw'", "x, y, z"),
    "no cell": ("size = 1.0", "size = 0", 'texture "tiles"', "size = 0", "> 0"),
    "view of nothing": (
        "look_at = [0, 0.5, 0]",
        "look_at = [0, 0.52, 6]",
        'camera "main" (1st [[camera]])',
        "look_at",
        "move one",
    ),
    "up along the view": ("up = [0, 1, 0]", "up = [0, 0, 0]", 'camera "main"', "up = [0", "choose another"),
    "half turn": ("vfov_deg = 61.9275", "vfov_deg = 180", 'camera "main"', "vfov_deg = 180", "between 0 and 180"),
    "no area": (
        "vertices = [[0, 0, 0], [1, 0, 0], [0, 1, 0]]",
        "vertices = [[0, 0, 0], [1, 1, 1], [2, 2, 2]]",
        'object "flag" (4th [[object]])',
        "no area",
        "move one",
    ),
    "no normal": (
        "normal = [0, 1, 0]",
        "normal = [0, 0, 0]",
        'object "floor"',
        "normal = [0, 0, 0]",
        "any vector but zero",
    ),
    "same object": ('"flag"', '"ball"', 'object "ball"', "1st and the 4th [[object]]", "one of a kind"),
    "same material": (
        "[[object]]",
        '[[material]]\nname = "glass"\n[[object]]',
        'material "glass"',
        "1st and the 2nd",
        "one of a kind",
    ),
    "no such material": ('material = "glass"', 'material = "glas"', "object 'ball'", "'glas'", "Did you mean 'glass'?"),
    "no such texture name": (
        'k_d_texture = "tiles"',
        'k_d_texture = "tile"',
        "material 'glass'",
        "'tile'",
        "there is 'tiles'",
    ),
    "nan": ("radius = 1", "radius = nan", 'object "ball"', "radius = nan", "finite"),
    "inf": ("offset = -1", "offset = -inf", 'object "floor"', "offset = -inf", "finite"),
    "nan in a vertex": ("[1, 1, 0]", "[1, nan, 0]", 'object "sheet"', "vertices[2][1] = nan", "finite"),
    "beyond float32": ("radius = 1", "radius = 1e300", 'object "ball"', "radius = 1e+300", "up to 3.4e+38"),
    "list beyond float32": (
        "[0.4, 0.6, 0.9]",
        "{ gradient = [[0, 0, 0], [0, 1e99, 0]] }",
        "scene",
        "gradient = 1e+99",
        "3.4e+38",
    ),
    "huge integer": (
        "radius = 1",
        "radius = 1" + 400 * "0",
        'object "ball"',
        "a whole number of 1329 bits",
        "a number > 0",
    ),
    "huge hexadecimal": ("radius = 1", "radius = 0x1" + 6000 * "0", 'object "ball"', "24001 bits", "a number > 0"),
    "unreadable integer": ("radius = 1", "radius = 1" + 6000 * "0", "broken TOML", "thousands of digits", "allowed is"),
    "deep brackets": ("radius = 1", "radius = " + 99999 * "[", "brackets", "too deeply", "allowed is"),
    "broken value": ("radius = 1", "radius = = 1", "line 64, column 10", '"radius = = 1"', "broken TOML"),
    "open bracket": ("[[texture]]", "[[texture", "line 37, column 10", '"[[texture"', "broken TOML"),
    "key twice": ("radius = 1", "radius = 1\nradius = 2", "line 65", '"radius = 2"', "overwrite"),
    "open text": ('"glass"\n\n[[object]]\nname = "floor"', '"""glass', "broken TOML", "Unterminated", "not closed"),
}


@pytest.mark.parametrize("case", FAULTS)
def test_a_fault_is_named_with_its_place_value_and_way_out(case):
    old, new, *words = FAULTS[case]
    message = refused(changed(old, new))
    assert [word for word in words if word not in message] == [], message
    assert "\n" not in message, "a misspelt key and its missing namesake are one fault"


@pytest.mark.parametrize("table", ["camera", "light", "texture", "material", "object"])
def test_an_entry_that_is_no_table_is_named(table):
    assert (
        refused(f"{table} = [5]") == f"objects.toml: 1st [[{table}]] = 5; allowed is a table of keys under [[{table}]]"
    )


@pytest.mark.parametrize("table", ["camera", "texture"])
def test_two_of_one_name_are_refused(table):
    entry = FILE[FILE.index(f"[[{table}]]") :].split("\n\n")[0]
    name = tomllib.loads(entry)[table][0]["name"]
    message = refused(FILE + entry)
    assert f'{table} "{name}": the 1st and the 2nd [[{table}]]' in message and "Rename one" in message


def test_several_faults_are_one_message():
    replaced = {"glass": "", "centre": "center", "0.9": "nan", "vertices": "points"}
    message = refused(functools.reduce(lambda text, old: text.replace(old, replaced[old]), replaced, FILE))
    first, *lines = message.splitlines()
    assert first.startswith("objects.toml: ") and first.endswith(" faults")
    assert len(lines) == 6 and lines[-1].strip() == f"and {int(first.split()[1]) - 5} more"


def test_values_are_checked_in_every_table_before_the_message():
    message = refused(
        changed("radius = 1", "radius = 0").replace("offset = -1", "offset = 1e99").replace("= 320", "= 0")
    )
    assert [line.split(":")[0].strip() for line in message.splitlines()[1:]] == [
        'camera "main" (1st [[camera]])',
        'object "ball" (1st [[object]])',
        'object "floor" (2nd [[object]])',
    ]


@pytest.mark.parametrize("text", ["", "\n\n", "# only a comment\n"])
def test_an_empty_file_says_what_belongs_in_it(text):
    message = refused(text)
    assert "is empty" in message and "[[object]]" in message


def test_float64_reads_what_float32_cannot_hold():
    with jax.enable_x64(True):
        assert (
            float(parse_scene(changed("radius = 1", "radius = 1e300"), precision="float64").objects[0].radius) == 1e300
        )


@pytest.mark.parametrize("precision, words", [("float16", "float32, float64"), ("float64", "jax_enable_x64")])
def test_a_precision_that_is_not_there_is_named(precision, words):
    with jax.enable_x64(False), pytest.raises(SceneError, match=words):
        parse_scene(FILE, precision=precision)


def test_a_missing_file_suggests_its_neighbour(tmp_path):
    (tmp_path / "spheres.toml").write_text(FILE)
    with pytest.raises(SceneError, match=r"sphere\.toml: there is no such file. Did you mean 'spheres\.toml'\?"):
        load_scene(tmp_path / "sphere.toml")
    with pytest.raises(SceneError, match="there is no such file"):
        load_scene(tmp_path / "nowhere" / "scene.toml")


@pytest.mark.parametrize(
    "content, words",
    [
        (b"\xff\xfe[\x00", "line 1: byte 0xff is not UTF-8"),
        (b"[scene]\n# caf\xe9\n", "line 2: byte 0xe9 is not UTF-8"),
        (b"\x00\x01\x02", "line 1, column 1"),
        (b"\x89PNG\r\n\x1a\n", "0x89 is not UTF-8"),
    ],
)
def test_bytes_that_are_no_scene(tmp_path, content, words):
    path = tmp_path / "scene.toml"
    path.write_bytes(content)
    with pytest.raises(SceneError) as caught:
        load_scene(path)
    assert str(caught.value).startswith(f"{path}: ") and words in str(caught.value)


def test_what_is_no_readable_file(tmp_path, monkeypatch):
    with pytest.raises(SceneError, match="this is a folder; name the scene file in it"):
        load_scene(tmp_path)
    for name in ("a\0b", 300 * "n", "/dev/null/scene.toml"):
        with pytest.raises(SceneError, match="cannot be read"):
            load_scene(name)

    def shut(*_):
        raise PermissionError(13, "Permission denied")

    monkeypatch.setattr("builtins.open", shut)
    with pytest.raises(SceneError, match="scene.toml: no permission to read it; allow it with: chmod"):
        load_scene("scene.toml")


def test_a_huge_file_and_an_endless_one_are_refused(monkeypatch, tmp_path):
    monkeypatch.setattr("diffwhitted.formats._load.LARGEST_FILE", 2**20)
    (tmp_path / "huge.toml").write_bytes(bytes(2**20 + 1))
    with pytest.raises(SceneError, match="more than 1 MiB"):
        load_scene(tmp_path / "huge.toml")
    with pytest.raises(SceneError, match="a device"):
        load_scene("/dev/zero")


ODD = st.recursive(
    st.sampled_from([True, -1, 0, 0.5, 10**400, float("nan"), 1e300, "", "glass", "sphere", {}, []]),
    lambda part: st.lists(part, max_size=4) | st.dictionaries(st.sampled_from(["type", "name", "gradient"]), part),
    max_leaves=6,
)


@settings(max_examples=150, deadline=None)
@given(st.data())
def test_no_odd_value_ends_in_anything_but_a_scene_or_its_error(data):
    document = tomllib.loads(FILE)
    table = document[data.draw(st.sampled_from(sorted(document)))]
    entry = table if isinstance(table, dict) else data.draw(st.sampled_from(table))
    where = data.draw(st.sampled_from([document, entry]))
    key = data.draw(st.sampled_from(sorted(where)))
    where[key] = data.draw(ODD)
    try:
        with pytest.MonkeyPatch.context() as patch:
            patch.setattr("diffwhitted.formats.toml._reading._document", lambda text, source: document)
            parse_scene("")
    except SceneError as error:
        assert str(error).startswith("scene: ")


PARALLEL = FILE.replace("vfov_deg = 61.9275", 'type = "orthographic"\nview_height = 2.5')


BALL = 'type = "sphere"\ncentre = [0, 0, 0]\nradius = 1\n'
RING = FILE.replace(BALL, 'type = "torus"\ncentre = [0, 0, 0]\naxis = [0, 1, 0]\nmajor_radius = 2\nminor_radius = 1\n')
CONE = FILE.replace(BALL, 'type = "cone"\nbase = [0, 0, 0]\ntop = [0, 1, 0]\nbase_radius = 2\ntop_radius = 1\n')


SHOT = FILE + '\n\n[[shot]]\nname = "one"\nexposure = 1.0\ngamma = 2.2\n'


SPOT = FILE.replace(
    'type = "point"\n', 'type = "spot"\ndirection = [0, -1, 0]\nexponent = 2\ninner_cone_deg = 10\ncone_deg = 20\n'
)


LAMP = FILE.replace('type = "point"\nposition', 'type = "sphere"\nradius = 0.1\nsamples = 3\ncentre')


def limited_keys():
    """(model, key, limit, first value past it) for each limit of a number in the schema."""
    past = {"minimum": -1, "maximum": 1, "exclusiveMinimum": 0, "exclusiveMaximum": 0}
    models = scene_schema()["$defs"]
    models.pop("RectangleEntry")  # Its samples are tested with the lamps.
    # Tested with shots, environments, dispersion, wrinkles.
    for other in ("NoiseEntry", "EnvironmentEntry", "DispersionTable", "Noise_textureEntry", "DimplesEntry"):
        models.pop(other)
    models.pop("RadiosityTable")  # In a file of its own.
    models["MaterialEntry"]["properties"].pop("height_scale")  # Likewise.
    for name, model in models.items():
        for key, field in model["properties"].items():
            for limit in sorted(past.keys() & field.keys()):
                yield pytest.param(model, key, field[limit] + past[limit], id=f"{name}-{key}-{limit}")


@pytest.mark.parametrize("model, key, value", list(limited_keys()))
def test_a_limit_of_the_schema_is_a_limit_of_the_records(model, key, value):
    file = next(text for text in (SPOT, LAMP, PARALLEL, SHOT, RING, CONE) if f"\n{key} = " in text)
    table = next(
        name
        for name in ("scene", "camera", "light", "texture", "material", "object", "shot")
        if f"\n{key} = " in file[file.index(f"[{name}]") :].split("\n\n")[0]
    )
    start = file.index(f"\n{key} = ", file.index(f"[{table}]"))
    end = file.index("\n", start + 1)
    message = refused(f"{file[:start]}\n{key} = {value:g}{file[end:]}")
    assert f"{key} = {value:g}; allowed is" in message


@pytest.mark.parametrize(
    "text, line, said",
    [
        ("[[material]]\nname = 'a'\nk_d = [#ff8800]\nk_h = 0.3\n", 3, "# begins a comment"),
        ("[[material]]\nname = 'a'\nk_d = [0.1, 0.2\nk_h = 0.3\n", 3, 'the line is "k_d = [0.1, 0.2"'),
        ("[[object]]\nvertices = [[0, 0, 0],\n  [1, 0, 0]\n\n[[light]]\nname = 'b'\n", 2, "vertices"),
        ("[[object]]\nvertices = [[0, 0, 0],\n  [1, 0, 0]\n", 2, "vertices"),
        ("[[object]]\nname = 'a ['\nvertices = [[0, 0, 0],  # [\n  [1, 0, x]]\nk = 1\n", 4, "Invalid value"),
    ],
)
def test_an_array_that_is_not_closed_is_where_it_began(text, line, said):
    message = refused(text)
    assert f"line {line}" in message and said in message
    assert ("the array that begins here is not closed" in message) == (said != "Invalid value")


@pytest.mark.parametrize("look_at", [(0, 0, -5), (0, 3, 0), (4, 0, 0), (1, 2, 3)])
def test_the_axis_that_is_suggested_in_place_of_up_can_be_taken(look_at):
    text = "[[camera]]\nlook_from = [0, 0, 0]\nlook_at = {}\nup = {}\nvfov_deg = 40\nwidth = 4\nheight = 3\n"
    message = refused(text.format(list(look_at), list(look_at)))
    suggested = message.rpartition("such as ")[2]
    assert parse_scene(text.format(list(look_at), suggested)).cameras
