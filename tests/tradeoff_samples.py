"""What tests of accuracy against time share: a small scene, candidates, and their front by its definition."""

import dataclasses

SCENE = """
[scene]
background = [0.2, 0.3, 0.5]
max_depth = 2

[[camera]]
look_from = [0, 1, 5]
look_at = [0, 0, 0]
vfov_deg = 40
width = 32
height = 24

[[light]]
type = "directional"
direction = [1, 2, 2]
colour = [0.8, 0.8, 0.8]

[[texture]]
name = "tiles"
type = "checker"
colours = [[0.1, 0.1, 0.1], [1, 1, 1]]
axes = "xz"

[[material]]
name = "mirror"
k_a = 0.1
k_s = 0.8

[[material]]
name = "floor"
k_d = 0.8
k_s = 0.4
k_d_texture = "tiles"

[[object]]
name = "ball"
type = "sphere"
centre = [0, 0, 0]
radius = 1
material = "mirror"

[[object]]
name = "ground"
type = "plane"
normal = [0, 1, 0]
offset = -1
material = "floor"
"""


@dataclasses.dataclass
class Candidate:
    seconds: float
    error: float


def brute_force(points):
    return [
        not any(
            o.seconds <= p.seconds and o.error <= p.error and (o.seconds < p.seconds or o.error < p.error)
            for o in points
        )
        for p in points
    ]
