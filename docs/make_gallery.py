"""Makes the pictures of the gallery that are scenes of `examples/`, and those that have scripts of their own.

Run from the top of the repository: make gallery
"""

import runpy

import numpy as np

import diffwhitted

PICTURES = {
    "figure_6": ("whitted_figure_6", 480),
    "whitted_7": ("whitted_figure_7", 480),
    "materials": ("materials", 900),
    "wrinkles": ("wrinkles", 720),
}
"""Name of the picture: the example, and its width."""
SCRIPTS = ("make_radiosity", "make_room", "make_standard")

if __name__ == "__main__":
    for name, (example, width) in PICTURES.items():
        scene = diffwhitted.load_scene(f"examples/{example}.toml")
        camera = scene.cameras["main"]
        camera = camera.resized(width, round(width * camera.height / camera.width))
        diffwhitted.write_image(f"docs/{name}.jpg", np.asarray(diffwhitted.render(scene, camera, footprint=1)))
        print(f"docs/{name}.jpg", flush=True)
    for script in SCRIPTS:
        runpy.run_path(f"docs/{script}.py", run_name="__main__")
        print(f"docs/{script}.py", flush=True)
