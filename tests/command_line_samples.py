"""The scenes that tests of the command line work on, in the folder that the fixture `place` makes."""

from pathlib import Path

import numpy as np

import diffwhitted

ROOT = Path(__file__).parents[1]
SCENE = """
[scene]
background = [0.2, 0.3, 0.4]

[[camera]]
look_from = [0, 0, 4]
look_at = [0, 0, 0]
vfov_deg = 40
width = 16
height = 12

[[light]]
type = "point"
position = [3, 5, 4]
colour = [0.9, 0.9, 0.9]

[[material]]
name = "paint"
k_a = 0.05
k_d = 0.5
k_h = 0.3
phong_exponent = 20

[[material]]
name = "hidden"
k_d = 0.5

[[object]]
name = "ball"
type = "sphere"
centre = [0, 0, 0]
radius = 1
material = "paint"

[[object]]
name = "behind the camera"
type = "sphere"
centre = [0, 0, 9]
radius = 1
material = "hidden"
"""
SECOND_CAMERA = """
[[camera]]
name = "side"
look_from = [4, 0, 0]
look_at = [0, 0, 0]
vfov_deg = 40
width = 8
height = 6
"""


def rendered(path, **options):
    scene = diffwhitted.load_scene(path)
    return np.asarray(diffwhitted.render(scene, scene.cameras["main"], **options))
