"""Makes the pictures of the page on standard scenes.

Run from the top of the repository: python docs/make_standard.py [NAME ...]
"""

import sys

import numpy as np

import diffwhitted

SAMPLES = {"balls": 2, "teapot": 2, "figure_7": 2, "table": 3}

for name in sys.argv[1:] or SAMPLES:
    scene = diffwhitted.standard_scene(name)
    camera = scene.cameras["main"].resized(320, 240)
    picture = np.asarray(diffwhitted.render(scene, camera, samples=SAMPLES[name], footprint=0))
    diffwhitted.write_image(f"docs/{name}.jpg", picture)
