"""Makes the picture of the guide to radiosity from `examples/bleeding.toml`: without it, and with it.

Run from the top of the repository: python docs/make_radiosity.py
"""

import numpy as np

import diffwhitted
from diffwhitted.records import changed

if __name__ == "__main__":
    scene = diffwhitted.load_scene("examples/bleeding.toml")
    dark = changed(scene, radiosity=None, lights=(diffwhitted.PointLight((1, 1.9, 1), (0.9, 0.75, 0.5)),))
    pictures = [np.asarray(diffwhitted.render(one, scene.cameras["main"])) for one in (dark, scene)]
    diffwhitted.write_image("docs/radiosity.jpg", np.concatenate(pictures, axis=1))
