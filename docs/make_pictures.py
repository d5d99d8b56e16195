"""Makes the picture of the README: target, start and fit of the example side by side.

Run from the top of the repository, after `make demo`: python docs/make_pictures.py
"""

from pathlib import Path

import numpy as np

import diffwhitted

EXAMPLES = Path("examples")
target = diffwhitted.read_image(EXAMPLES / "three_spheres_povray.exr").pixels
panels = [target]
for path in (EXAMPLES / "three_spheres.toml", Path("demo-output/fitted.toml")):
    scene = diffwhitted.load_scene(path)
    panels.append(np.asarray(diffwhitted.render(scene, scene.cameras["main"])))
gap = np.ones((target.shape[0], 8, 3), np.float32)
row = np.concatenate([panels[0], gap, panels[1], gap, panels[2]], axis=1)
diffwhitted.write_image("docs/fit.png", row[20:])
