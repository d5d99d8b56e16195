"""The hard cases of a ray tracer, each with the value that algebra gives for it."""

import equinox as eqx
import jax
import jax.numpy as jnp
import numpy as np
import pytest

import diffwhitted as dw
from diffwhitted.illumination import halfway_apart, lobe, reflected_apart
from diffwhitted.illumination import lit as before_the_surface
from diffwhitted.numerics._vector import Vec3
from diffwhitted.tree import make_plan

BOTTOM, TOP = np.array([0.9, 0.5, 0.1]), np.array([0.1, 0.3, 0.8])
SKY = dw.GradientBackground(BOTTOM, TOP)
GREY = dw.ConstantBackground((1.0, 1.0, 1.0))


def sky(height):
    """The background in a direction whose y is `height`."""
    share = 0.5 * (1 + np.asarray(height)[..., None])
    return (1 - share) * BOTTOM + share * TOP


def of(objects, lights=(), background=SKY, precision="float64", **settings):
    """A scene in which every object brings its material along."""
    materials = {thing.name: material for thing, material in objects}
    return dw.Scene(
        objects=[thing for thing, _ in objects],
        materials=materials,
        lights=lights,
        background=background,
        precision=precision,
        **settings,
    )


def ball(name, centre, radius, **material):
    return dw.Sphere(name, centre, radius, name), dw.Material(**({"k_h": 0.0} | material))


def ground(name, offset, normal=(0, 1, 0), **material):
    return dw.Plane(name, normal, offset, name), dw.Material(**({"k_h": 0.0} | material))


def camera_of(scene, origin, direction, vfov_deg=20, width=1, height=1):
    origin, direction = np.asarray(origin, float), np.asarray(direction, float)
    up = np.eye(3)[np.abs(direction).argmin()]
    made = dw.Camera(origin, origin + direction, vfov_deg, width, height, up=up)
    return jax.tree.map(lambda a: a.astype(scene.dtype), made)


def seen(scene, origin, direction, **how):
    """The colour along one ray."""
    return np.asarray(dw.render(scene, camera_of(scene, origin, direction), **how)[0, 0])


def downwards(angle):
    return np.array([np.sin(angle), -np.cos(angle), 0.0])


# Bending


@pytest.mark.parametrize("treatment, share", [("full", 1.0), ("whitted", 0.25)])
def test_critical_angle_from_both_sides(treatment, share):
    """From inside a sea of glass: the refracted sky just below the critical angle, the deep mirrored just above it.

    "full" sends everything to the mirror ray; in Whitted's reading T = 0 and k_s stays.
    """
    scene = of([ground("sea", 0, k_s=0.25, k_t=0.5, refractive_index=1.5)], total_internal_reflection=treatment)
    critical = np.arcsin(1 / 1.5)
    for little in (1e-2, 1e-6):
        below, above = critical - little, critical + little
        sin_out = 1.5 * np.sin(below)
        expected = 0.5 * sky(np.sqrt(1 - sin_out**2)) + 0.25 * sky(-np.cos(below))
        np.testing.assert_allclose(seen(scene, (0, -1, 0), -downwards(below)), expected, atol=1e-9)
        np.testing.assert_allclose(seen(scene, (0, -1, 0), -downwards(above)), share * sky(-np.cos(above)), atol=1e-12)


def test_grazing_incidence():
    """Nearly along a sea of glass: the sky just above the horizon, and in the water the critical angle."""
    scene = of([ground("sea", 0, k_s=0.25, k_t=0.5, refractive_index=1.5)])
    for glance in (1e-3, 1e-9):
        inside = -np.sqrt(1 - np.cos(glance) ** 2 / 1.5**2)
        expected = 0.25 * sky(np.sin(glance)) + 0.5 * sky(inside)
        np.testing.assert_allclose(seen(scene, (0, 1e-6, 0), downwards(np.pi / 2 - glance)), expected, atol=1e-9)


AWAY = (0.0, 0.0, 1e3)
"""Behind the camera, where a ball is as good as absent but the compiled program is the same."""


def balls_over_tiles(small=(AWAY, 1.0), large=(AWAY, 1.0)):
    """Two clear balls, each with its place and index, over a lit checkerboard."""
    scene = of(
        [
            ground("ground", -1, k_d=0.8, k_d_texture="tiles"),
            ball("small", small[0], 0.5, k_t=1.0, refractive_index=small[1]),
            ball("large", large[0], 0.9, k_t=1.0, refractive_index=large[1]),
        ],
        lights=[dw.PointLight((3, 5, 4), 1.0)],
        textures={"tiles": dw.Checker(((0.1, 0.2, 0.3), (1, 0.8, 0.6)), 0.7, "xz")},
        shadows="tinted",
        max_depth=6,
    )
    camera = camera_of(scene, (0, 0.5, 4), (0, -0.12, -1), 50, 16, 12)
    return np.asarray(dw.render(scene, camera, plan=make_plan(scene, camera, free=("small.refractive_index",))))


def test_clear_glass_of_index_one_is_invisible():
    """k_t = 1 and no change of index: the picture without the ball. Likewise a ball of water in water."""
    place, drop = (0.2, 0, 0.1), ((0, 0, 0), 1.33)
    nothing = balls_over_tiles()
    np.testing.assert_allclose(balls_over_tiles((place, 1.0)), nothing, atol=1e-9)
    np.testing.assert_allclose(balls_over_tiles((place, 1.33), drop), balls_over_tiles(large=drop), atol=1e-9)
    assert np.abs(balls_over_tiles((place, 1.33)) - nothing).max() > 0.3


def in_the_plane(angle):
    return np.array([np.cos(angle), np.sin(angle), 0.0])


@pytest.mark.parametrize("height", [0.0, 0.5])
def test_camera_inside_glass(height):
    """A ray that meets the inside of a ball at an angle i is thrown back by pi - 2 i, and leaves a part at each turn.

    sin(i) is the distance from the centre over the radius, and 1.5 sin(i) the sine outside: a geometric series.
    """
    scene = of([ball("glass", (1, 2, 3), 0.7, k_s=0.3, k_t=0.6, refractive_index=1.5)], max_depth=7)
    i = np.arcsin(height)
    turn = np.arange(6) * -(np.pi - 2 * i)
    out = i - np.arcsin(1.5 * height)
    for start in (0.0, 1.0, -2.0):
        expected = (0.6 * 0.3 ** np.arange(6)[:, None] * sky(np.sin(start + turn + out))).sum(axis=0)
        origin = np.array([1, 2, 3]) + 0.7 * height * in_the_plane(start + np.pi / 2)
        np.testing.assert_allclose(seen(scene, origin, in_the_plane(start)), expected, atol=1e-12)


def test_glass_in_water_in_air():
    """Flat layers keep n sin, so in the glass it is as if there were no water; and concentric balls deviate by
    Bouguer's rule.
    """
    scene = of([ground("water", 0, k_t=0.9, refractive_index=1.33), ground("glass", -1, k_t=0.8, refractive_index=1.7)])
    for angle in (0.0, 0.5, 1.4):
        inside = -np.sqrt(1 - (np.sin(angle) / 1.7) ** 2)
        np.testing.assert_allclose(seen(scene, (0, 1, 0), downwards(angle)), 0.72 * sky(inside), atol=1e-12)

    scene = of(
        [
            ball("drop", (0, 0, 0), 1, k_t=0.9, refractive_index=1.33),
            ball("bead", (0, 0, 0), 0.5, k_t=0.8, refractive_index=1.7),
        ]
    )
    b = 0.4
    # n r sin is the same everywhere on the ray, here the distance b at which it passes the centre outside.
    deviation = 2 * (np.arcsin(b) - np.arcsin(b / 1.33) + np.arcsin(b / (1.33 * 0.5)) - np.arcsin(b / (1.7 * 0.5)))
    np.testing.assert_allclose(seen(scene, (-3, b, 0), (1, 0, 0)), 0.72**2 * sky(-np.sin(deviation)), atol=1e-12)


# Light


def lit(position, **settings):
    return [dw.PointLight(position, (0.9, 0.8, 0.7), **settings)]


@eqx.filter_jit
def value_and_derivative_in_the_light(scene, camera):
    def image(position):
        return dw.render(eqx.tree_at(lambda s: s.lights[0].position, scene, position), camera)

    return jax.jvp(image, (scene.lights[0].position,), (jnp.ones(3),))


@pytest.mark.parametrize(
    "position",
    [(0, 0, 0), (0, -2, 0), (5, 0, 0), (5, -1e-9, 0)],
    ids=["at the point", "behind", "in the plane", "just behind"],
)
@pytest.mark.parametrize("exponent", [0.0, 1.0, 50.0])
def test_light_at_or_behind_the_surface(position, exponent):
    """Only ambient light is left, also where the highlight's exponent is 0; and its derivatives are finite."""
    scene = of(
        [ground("ground", 0, k_a=0.1, k_d=0.5, k_h=0.6, phong_exponent=exponent)],
        lights=lit(position, attenuation=(0.0, 1.0, 0.0)),
        shadows="off",
    )
    value, slope = value_and_derivative_in_the_light(scene, camera_of(scene, (0, 1, 0), (0, -1, 0)))
    np.testing.assert_allclose(value[0, 0], 0.1, atol=1e-12)
    assert np.isfinite(slope).all()


def glass_ball_over_ground(light, shadows, k_t):
    return of(
        [ball("glass", (0, 0, 0), 1, k_d=0.2, k_t=k_t, refractive_index=1.5), ground("ground", -2, k_d=0.5)],
        lights=lit(light),
        background=GREY,
        shadows=shadows,
    )


@pytest.mark.parametrize("shadows, below, crossing", [("opaque", 0, 0), ("tinted", 1, 1), ("off", 1, 0)])
def test_glass_between_ground_and_light(shadows, below, crossing):
    """A light in the middle of a ball and one above it: one surface or two on the way, each with its k_t a channel."""
    light, k_t = np.array([0.9, 0.8, 0.7]), np.array([0.9, 0.5, 0.0])
    inside, above = (glass_ball_over_ground(p, shadows, k_t) for p in ((0, 0, 0), (0, 9, 0)))
    # The far side of the ball, lit from within and seen through the near side, and the background through both.
    np.testing.assert_allclose(seen(inside, (0, 0, 4), (0, 0, -1)), k_t * 0.2 * light + k_t**2, atol=1e-12)
    # The ground at (4, -2, 0), where N.L = 2 / sqrt(20), and straight below.
    np.testing.assert_allclose(
        seen(inside, (4, -1, 0), (0, -1, 0)), below * k_t**crossing * 0.5 * light * 2 / np.sqrt(20), atol=1e-12
    )
    np.testing.assert_allclose(
        seen(above, (-2, -1.5, 0), (2, -0.5, 0)), below * k_t ** (2 * crossing) * 0.5 * light, atol=1e-12
    )


@pytest.mark.parametrize("precision", ["float32", "float64"])
@pytest.mark.parametrize("model", ["halfway", "reflected"])
def test_highlight_exponents(model, precision):
    """Exponents 0, 1 and a million, a thousandth of a radian off the peak: 1, cos(angle) and exp(10**6 log
    cos(angle)).
    """
    aside = 1e-3 if model == "halfway" else 5e-4
    for exponent in (0.0, 1.0, 1e6):
        scene = of(
            [(dw.Plane("wall", (0, 0, 1), 0, "wall"), dw.Material(k_h=0.6, phong_exponent=exponent, highlight=model))],
            lights=[dw.DirectionalLight((np.sin(2 * aside), 0, np.cos(2 * aside)), 0.5)],
            shadows="off",
            precision=precision,
        )
        expected = 0.3 * np.exp(exponent * np.log1p(-2 * np.sin(5e-4) ** 2))
        np.testing.assert_allclose(
            seen(scene, (0, 0, 3), (0, 0, -1)), expected, rtol=1e-11 if precision == "float64" else 1e-3
        )


@jax.jit
def highlights_at_a_right_angle(along, exponent):
    """(V.R) with the light at the eye, 45 degrees off; (N.H) of two lights in the surface, one opposite to the eye."""
    one, zero = jnp.sqrt(0.5), jnp.zeros(())
    normal, to_eye = Vec3(zero, 1 + zero, zero), Vec3(one, one, zero)
    eye_in_surface = Vec3(zero, zero, 1 + zero)
    lights = Vec3(along, zero, jnp.sqrt(1 - along**2)), -eye_in_surface
    at_eye = before_the_surface(normal, to_eye) * lobe(reflected_apart(normal, to_eye, -to_eye), exponent)
    in_surface = [
        before_the_surface(normal, light) * lobe(halfway_apart(normal, light, -eye_in_surface), exponent)
        for light in lights
    ]
    return jnp.stack([at_eye, *in_surface])


@pytest.mark.parametrize("exponent, value", [(0.0, 1.0), (1.0, 0.0), (1e6, 0.0)])
def test_highlight_at_a_right_angle(exponent, value):
    """V.R = 0 gives 0 ** n; N.H = 0 needs a light in the surface, which is unlit. The derivatives are finite."""
    arguments = (jnp.asarray(0.6), jnp.asarray(exponent))
    # cos(90 degrees) is 1e-16 in floating point, as good as 0
    np.testing.assert_allclose(highlights_at_a_right_angle(*arguments), [value, 0, 0], atol=1e-15)
    for mode in (jax.jacfwd, jax.jacrev):
        assert all(np.isfinite(d).all() for d in mode(highlights_at_a_right_angle, argnums=(0, 1))(*arguments))


@pytest.mark.parametrize("footprint", [0, 1])
@pytest.mark.parametrize("inside, around", [(1000.0, 1.5), (1.5, 1000.0), (100.0, 2.0)])
def test_float32_at_extreme_indices(inside, around, footprint):
    """A camera in glass within glass before a sky from 0 to 1: no light below 0, and the picture of float64."""

    def picture(precision):
        scene = of(
            [
                ball("inner", (0.1, -0.05, 0), 1, k_s=0.5, k_t=1.0, refractive_index=inside),
                ball("outer", (0, 0, 0), 3, k_s=0.5, k_t=1.0, refractive_index=around),
            ],
            background=dw.GradientBackground((0, 0, 0), (1, 1, 1)),
            precision=precision,
            total_internal_reflection="whitted",
            footprint=footprint,
        )
        return np.asarray(dw.render(scene, camera_of(scene, (0.3, 0.2, -0.4), (2, 1, 1), 90, 16, 12)))

    low, high = picture("float32"), picture("float64")
    assert (low >= 0).all()
    np.testing.assert_allclose(low, high, atol=2e-3)


# Shapes


def test_tiny_sphere_far_away():
    """A mirror of radius 1e-4 at distance 1e4: the sky along u + 2 n_z n, over the whole of its disc."""
    scene = of([ball("bead", (0, 0, -1e4), 1e-4, k_s=1.0)])
    size = 9
    image = np.asarray(dw.render(scene, camera_of(scene, (0, 0, 0), (0, 0, -1), np.degrees(2.1e-8), size, size)))
    # Which way is right and up does not matter for a round bead, so the picture is compared by its sorted heights.
    offset = ((np.arange(size) + 0.5) / size - 0.5) * 2.1
    across, up = np.meshgrid(offset, -offset)
    on_it = across**2 + up**2 < 1
    n_z = np.sqrt(np.where(on_it, 1 - across**2 - up**2, 0))
    expected = np.where(on_it[..., None], sky(2 * n_z * up), sky(0 * up))
    turned = [np.rot90(image, k) for k in range(4)] + [np.rot90(image, k)[:, ::-1] for k in range(4)]
    assert min(np.abs(t - expected).max() for t in turned) < 1e-5


def test_hall_of_mirrors():
    """Between two mirrors that glow with 0.1: the geometric series, and its derivative in k_s. Under `jit` without a
    plan.
    """

    def glow(k_s):
        scene = of(
            [ground("floor", -1, k_a=0.1, k_s=0.5), ground("ceiling", 1, normal=(0, 1, 0), k_a=0.1, k_s=0.5)],
            max_depth=12,
        )
        for name in ("floor.k_s", "ceiling.k_s"):
            scene = dw.replace_coefficient(scene, name, k_s)
        return dw.render(scene, camera_of(scene, (0, 0, 0), (0.6, -0.8, 0)))[0, 0]

    terms = np.arange(12)
    forward = jax.jit(lambda k: jax.jvp(glow, (k,), (jnp.ones_like(k),)))
    for k_s in (1.0, 0.5, 0.0):
        value, slope = forward(jnp.asarray(k_s))
        np.testing.assert_allclose(value, 0.1 * sum(k_s**j for j in terms), rtol=1e-12)
        np.testing.assert_allclose(slope, 0.1 * sum(j * k_s ** (j - 1) for j in terms[1:]), rtol=1e-12)


@pytest.mark.parametrize("shift", [(0.0, 0.0), (1e-12, -1e-7)])
def test_touching_spheres_in_a_furnace(shift):
    """Whatever sends back as much as it receives, k_a + k_s + k_t = 1, cannot be seen before a background of 1.

    The rays go into the gap of balls of glass and metal that touch, and at the point of touch itself; what is cut off
    at depth 12 is less than 0.4 ** 12.
    """
    scene = of(
        [
            ball("glass", (-0.7, 0, 0), 0.7, k_a=0.6, k_s=0.1, k_t=0.3, refractive_index=1.3),
            ball("metal", (0.5, 0, 0), 0.5, k_a=0.6, k_s=0.4),
            ground("ground", -0.7, k_a=0.6, k_s=0.4),
        ],
        background=GREY,
        max_depth=12,
    )
    camera = camera_of(scene, (*shift, 6), (0, 0, -1), 30, 15, 15)
    image = dw.render(scene, camera, plan=make_plan(scene, camera, capacity=30 * 15 * 15))
    assert (np.asarray(image) <= 1 + 1e-12).all() and (np.asarray(image) >= 1 - 0.4**12).all()


@pytest.mark.parametrize("precision", ["float32", "float64"])
@pytest.mark.parametrize("scale", [1e-3, 1e4])
def test_a_scaled_scene_is_the_same_picture(scale, precision):
    """Every length in metres times the scale: no offset and no limit in the renderer has a length of its own."""

    def picture(scale):
        scene = of(
            [
                ball("glass", (0, 0, 0), 1 * scale, k_d=0.1, k_h=0.3, k_s=0.2, k_t=0.7, refractive_index=1.5),
                ball("metal", np.array([1.2, -0.5, -1]) * scale, 0.5 * scale, k_d=0.1, k_s=0.8),
                ground("ground", -1 * scale, k_d=0.8, k_d_texture="tiles"),
                (
                    dw.Polygon("sheet", np.array([(-3, -1, -2), (-1, -1, -3), (-2, 2, -2.5)]) * scale, "sheet"),
                    dw.Material(k_d=0.5),
                ),
            ],
            lights=lit(np.array([3, 5, 4]) * scale),
            textures={"tiles": dw.Checker(((0.2, 0.2, 0.2), (1, 1, 1)), 0.8 * scale, "xz")},
            precision=precision,
        )
        return np.asarray(
            dw.render(
                scene, camera_of(scene, np.array([0, 0.6, 5]) * scale, np.array([0, -0.1, -1]) * scale, 45, 16, 12)
            )
        )

    same = np.abs(picture(scale) - picture(1.0)).max(axis=-1) < (1e-8 if precision == "float64" else 1e-3)
    # In float32 the rounding of a few rays falls on the other side of an edge.
    assert same.all() if precision == "float64" else same.mean() > 0.97


# Depth, room and sizes


def test_the_camera_ray_is_depth_one():
    """A ray past the last depth is black, not the background: a mirror needs depth 2, a ball of glass depth 3."""
    scene = of([ground("mirror", 0, k_a=0.1, k_s=0.5), ball("glass", (0, 5, 0), 1, k_t=0.5)])
    for depth in (1, 2, 3):
        mirrored = 0.1 + (0.5 * sky(1.0) if depth > 1 else np.zeros(3))
        refracted = 0.25 * sky(0.0) if depth > 2 else np.zeros(3)
        np.testing.assert_allclose(seen(scene, (3, 1, 0), (0, -1, 0), max_depth=depth), mirrored, atol=1e-12)
        np.testing.assert_allclose(seen(scene, (0, 5, 4), (0, 0, -1), max_depth=depth), refracted, atol=1e-12)
        np.testing.assert_allclose(seen(scene, (3, 5, 4), (0, 0, -1), max_depth=depth), sky(0.0), atol=1e-12)


def mirrored_view(width, height, precision="float64"):
    """A mirror seen from above and the picture that algebra gives: half the sky along the mirrored ray."""
    scene = of([ground("mirror", -1, k_s=0.5)], precision=precision)
    camera = camera_of(scene, (0, 0, 0), (0.1, -2, -1), 2, width, height)
    ray = camera.rays(*camera.place(jnp.arange(width * height), jnp.asarray([0.5, 0.5], scene.dtype)))
    return scene, camera, 0.5 * sky(-np.asarray(ray.direction.y)).reshape(height, width, 3)


@pytest.mark.parametrize("width, height", [(1, 1), (13, 7), (301, 229)])
def test_pictures_of_any_size(width, height):
    """One pixel, less and more than a block of rays, and more than one pass of them."""
    scene, camera, expected = mirrored_view(width, height)
    image = dw.render(scene, camera)
    assert image.shape == (height, width, 3)
    np.testing.assert_allclose(image, expected, atol=1e-12)


def test_an_empty_scene_is_its_background():
    empty = dw.Scene(objects=[], materials={}, background=SKY, precision="float64")
    camera = camera_of(empty, (0, 0, 0), (1, 1, 1), 90, 5, 4)
    ray = camera.rays(*camera.place(jnp.arange(20), jnp.asarray([0.5, 0.5])))
    np.testing.assert_allclose(dw.render(empty, camera), sky(np.asarray(ray.direction.y)).reshape(4, 5, 3), atol=1e-12)


def test_samples_are_the_mean_of_shifted_pictures():
    """Nine rays a pixel: the mean over 3 x 3 pixels of a picture three times as fine."""
    scene = of(
        [ball("metal", (0, 0, 0), 1, k_a=0.2, k_s=0.5), ground("ground", -1, k_a=1.0, k_a_texture="tiles")],
        textures={"tiles": dw.Checker(((0.2, 0.2, 0.2), (1, 1, 1)), 0.8, "xz")},
    )
    camera = camera_of(scene, (0, 0.6, 5), (0, -0.1, -1), 45, 16, 12)
    finer = np.asarray(dw.render(scene, camera.resized(width=48, height=36)))
    expected = finer.reshape(12, 3, 16, 3, 3).mean(axis=(1, 3))
    np.testing.assert_allclose(dw.render(scene, camera, samples=3), expected, atol=1e-12)
    assert np.abs(expected - finer[1::3, 1::3]).max() > 0.1


def crowded():
    """Two mirrors, eleven rays behind every camera ray."""
    scene = of([ground("floor", -1, k_a=0.1, k_s=0.5), ground("ceiling", 1, k_a=0.1, k_s=0.5)], max_depth=12)
    return scene, camera_of(scene, (0, 0, 0), (0.6, -0.8, 0), 20, 16, 12)


def test_no_ray_is_dropped_in_silence():
    """Too little room: an error with a plan, more room without one; a plan that is made for the scene has enough."""
    scene, camera = crowded()
    needed = 11 * 16 * 12
    small = make_plan(scene, camera, capacity=int(1.5 * 16 * 12))
    assert small.capacity < needed <= dw.plan(scene, camera).capacity < 1.5 * needed
    with pytest.raises(dw.CapacityError, match=f"more room than the plan's {small.capacity} rays.*diffwhitted.plan"):
        dw.render(scene, camera, plan=small)
    np.testing.assert_allclose(dw.render(scene, camera), 0.1 * (1 - 0.5**12) / 0.5, rtol=1e-12)


def test_a_camera_of_another_precision():
    """A camera that is not one of the scene's own: the scene decides the precision."""
    scene, camera, expected = mirrored_view(4, 3, "float32")
    image = dw.render(scene, jax.tree.map(lambda a: a.astype("float64"), camera))
    assert image.dtype == "float32"
    np.testing.assert_allclose(image, expected, atol=1e-6)
