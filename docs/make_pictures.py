"""Makes the pictures of the README: target, start and fit of the example side by side; points and footprints
enlarged; displays of few levels; textures; error against time; where the rays are; the four ways to shade a mesh.

Run from the top of the repository, after `make demo`: python docs/make_pictures.py
"""

import timeit
from pathlib import Path

import jax
import numpy as np

import diffwhitted
from diffwhitted import display
from diffwhitted.shapes import SHADING
from diffwhitted.standard._teapot import pot
from fitting.comparing._error_plot import write_figure
from fitting.comparing._tradeoff import sentences, tradeoff
from fitting.comparing._tradeoff_plot import tradeoff_figure
from fitting.telling._maps_plot import write_maps

EXAMPLES = Path("examples")
target = diffwhitted.read_image(EXAMPLES / "three_spheres_antialiased.exr").pixels
panels = [target]
for path in (EXAMPLES / "three_spheres.toml", Path("demo-output/fitted.toml")):
    scene = diffwhitted.load_scene(path)
    panels.append(np.asarray(diffwhitted.render(scene, scene.cameras["main"])))
gap = np.ones((target.shape[0], 8, 3), np.float32)
row = np.concatenate([panels[0], gap, panels[1], gap, panels[2]], axis=1)
diffwhitted.write_image("docs/fit.png", row[20:])

scene = diffwhitted.load_scene(EXAMPLES / "three_spheres_truth.toml")
image = display.fit_range(np.asarray(diffwhitted.render(scene, scene.cameras["main"].resized(240, 180))))
panels = [
    image, display.ordered_dither(image, 4), display.halftone(image[::3, ::3], 3), display.error_diffusion(image),
    display.dot_diffusion(image), display.random_dither(image, jax.random.key(0)),
]  # fmt: skip
gap, rows = np.ones((180, 6, 3), np.float32), []
for first, second, third in (panels[:3], panels[3:]):
    rows.append(np.concatenate([first, gap, second, gap, third], axis=1))
sheet = np.concatenate([rows[0], np.ones_like(rows[0][:6]), rows[1]])
diffwhitted.write_image("docs/display.png", sheet.repeat(2, axis=0).repeat(2, axis=1))

scene = diffwhitted.load_scene(EXAMPLES / "glass_between_spheres.toml")
camera = scene.cameras["main"].resized(320, 240)
area = np.asarray(diffwhitted.render(scene, camera, samples=64))
panels = []
for name, how in {"one point": {}, "4x4 points": {"samples": 4}, "one filtered tree": {"footprint": 1}}.items():
    picture = np.asarray(diffwhitted.render(scene, camera, **how))
    seconds = min(timeit.repeat(lambda: np.asarray(diffwhitted.render(scene, camera, **how)), number=1, repeat=9))  # noqa: B023
    print(f"{name}: RMSE {np.sqrt(np.mean((picture - area) ** 2)):.4f}, {seconds * 1e3:.0f} ms")
    panels.append(picture[85:185, 90:210].repeat(3, axis=0).repeat(3, axis=1))
gap = np.ones((panels[0].shape[0], 8, 3), np.float32)
diffwhitted.write_image("docs/edges.png", np.concatenate([panels[0], gap, panels[1], gap, panels[2]], axis=1))

scene = diffwhitted.load_scene(EXAMPLES / "globe.toml")
camera = scene.cameras["main"].resized(640, 480)
diffwhitted.write_image("docs/textures.jpg", np.asarray(diffwhitted.render(scene, camera)))

jax.config.update("jax_enable_x64", True)
scene = diffwhitted.load_scene(EXAMPLES / "three_spheres.toml")
found = tradeoff(scene, scene.cameras["main"].resized(320, 240))
print(*sentences(found), *(f"{p.settings}: {p.rmse:.2g}, {p.seconds * 1e3:.0f} ms" for p in found.points), sep="\n")
write_figure(tradeoff_figure(found), Path("docs/tradeoff.png"))

scene = diffwhitted.load_scene(EXAMPLES / "glass_between_spheres.toml")
camera = scene.cameras["main"].resized(320, 240)
write_maps(diffwhitted.ray_maps(scene, camera), np.asarray(diffwhitted.render(scene, camera)), Path("docs/rays.png"))

vertices, normals, faces = pot(2)
camera = diffwhitted.Camera((3.6, 5.2, 3.6), (0.1, 0, 1.35), up=(0, 0, 1), vfov_deg=33, width=300, height=240)
panels = []
for shading in SHADING:
    scene = diffwhitted.Scene(
        objects=[diffwhitted.Mesh("pot", vertices, faces, "pot", normals=normals, shading=shading)],
        materials={"pot": diffwhitted.Material(k_a=0.1, k_d=(0.6, 0.3, 0.1), k_h=0.5, phong_exponent=25)},
        lights=[diffwhitted.PointLight((-3.1, 9.8, 12.1), 0.7), diffwhitted.PointLight((11.3, 5.1, 8.8), 0.7)],
        background=diffwhitted.ConstantBackground((1, 1, 1)),
    )
    panels.append(np.asarray(diffwhitted.render(scene, camera, samples=4)))
diffwhitted.write_image("docs/shading.jpg", np.concatenate(panels, axis=1))
