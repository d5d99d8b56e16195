"""Scenes of many surfaces: Haines' sphereflake, and a bumpy ball of triangles over a floor."""

import numpy as np

import diffwhitted

SKY = diffwhitted.ConstantBackground((0.078, 0.361, 0.753))
WIDE = 12.0
BUMPS = ((7, 6, 8, 0.04), (25, 23, 0, 0.01))


def flake(levels: int) -> diffwhitted.Scene:
    """Spheres, nine at each, a third as large: 9**0 + ... + 9**levels of them, over a floor, under three lamps."""
    lean = np.asarray([[1, 1, 0], [1, 0, -1], [0, 1, -1]]) / np.sqrt(2)
    turn = _turn(np.asarray([1, -1, 0]) / np.sqrt(2), np.arcsin(2 / np.sqrt(6)))
    around = [_turn(np.asarray([0, 0, 1.0]), angle) for angle in np.radians([0, 120, 240])]
    ways = np.concatenate([(lean @ turn.T) @ about.T for about in around])
    centres, radii, heads = np.zeros((1, 3)), np.asarray([0.5]), np.asarray([[0, 0, 1.0]])
    all_centres, all_radii = [centres], [radii]
    for _ in range(levels):
        aims = np.stack([ways @ _from_up(head).T for head in heads])
        centres = (centres[:, None] + aims * (radii * 4 / 3)[:, None, None]).reshape(-1, 3)
        radii, heads = np.repeat(radii / 3, 9), aims.reshape(-1, 3)
        all_centres.append(centres)
        all_radii.append(radii)
    return diffwhitted.Scene(
        objects=[
            diffwhitted.SphereSet("flake", np.concatenate(all_centres), np.concatenate(all_radii), "ball"),
            diffwhitted.Plane("floor", (0, 0, 1), -0.5, "floor"),
        ],
        materials={
            "ball": diffwhitted.Material(k_d=(0.5, 0.45, 0.35), k_s=0.5, k_h=0.5, phong_exponent=3.08),
            "floor": diffwhitted.Material(k_d=(0.8, 0.6, 0.264)),
        },
        lights=[diffwhitted.PointLight(at, (0.577,) * 3) for at in ((4, 3, 2), (1, -4, 4), (-3, 1, 5))],
        cameras={"main": diffwhitted.Camera((2.1, 1.3, 1.7), (0, 0, 0), 45, 512, 512, up=(0, 0, 1))},
        background=SKY,
    )


def bumpy(levels: int) -> tuple[np.ndarray, np.ndarray]:
    """Vertices and 20 * 4**levels triangles of a ball with bumps."""
    vertices, faces = _icosahedron()
    for _ in range(levels):
        sides = np.sort(np.concatenate([faces[:, [0, 1]], faces[:, [1, 2]], faces[:, [2, 0]]]), axis=1)
        keys, number = np.unique(sides[:, 0] * len(vertices) + sides[:, 1], return_inverse=True)
        middles = vertices[np.stack([keys // len(vertices), keys % len(vertices)], axis=1)].mean(axis=1)
        middles /= np.linalg.norm(middles, axis=1, keepdims=True)
        a, b, c = np.split(len(vertices) + number.ravel(), 3)
        corners = [[faces[:, 0], a, c], [faces[:, 1], b, a], [faces[:, 2], c, b], [a, b, c]]
        faces = np.concatenate([np.stack(three, axis=1) for three in corners])
        vertices = np.concatenate([vertices, middles])
    x, y, z = vertices.T
    height = np.ones(len(vertices))
    for a, b, c, most in BUMPS:
        height += most * np.sin(a * x) * np.sin(b * y + 1) * np.cos(c * z + 2)
    return vertices * height[:, None], faces


def mirror_ball(levels: int) -> diffwhitted.Scene:
    """The bumpy ball as a mirror over a floor, under two lamps."""
    return diffwhitted.Scene(
        objects=[
            diffwhitted.Mesh("ball", *bumpy(levels), "mirror"),
            diffwhitted.Plane("floor", (0, 1, 0), -1.1, "floor"),
        ],
        materials={
            "mirror": diffwhitted.Material(k_d=0.3, k_s=0.6, k_h=0.3, phong_exponent=30),
            "floor": diffwhitted.Material(k_d=(0.8, 0.6, 0.3)),
        },
        lights=[diffwhitted.PointLight(at, (0.7,) * 3) for at in ((3, 4, 3), (-4, 3, 1))],
        cameras={"main": diffwhitted.Camera((0, 1.2, 4.2), (0, 0, 0), 40, 640, 480)},
        background=SKY,
    )


def _icosahedron() -> tuple[np.ndarray, np.ndarray]:
    golden = (1 + 5**0.5) / 2
    ring = [(0, s, t * golden) for s in (-1, 1) for t in (-1, 1)]
    points = np.asarray([p[k:] + p[:k] for p in ring for k in range(3)], float)
    points /= np.linalg.norm(points[0])
    near = np.linalg.norm(points[:, None] - points[None], axis=-1) < 1.1
    count = range(len(points))
    faces = [
        (i, j, k) for i in count for j in count for k in count if i < j < k and near[i, j] and near[j, k] and near[i, k]
    ]
    outwards = [f if np.linalg.det(points[list(f)]) > 0 else (f[0], f[2], f[1]) for f in faces]
    return points, np.asarray(outwards)


def _turn(axis: np.ndarray, angle: float) -> np.ndarray:
    """The rotation about a unit axis (Rodrigues)."""
    x, y, z = axis
    cross = np.asarray([[0, -z, y], [z, 0, -x], [-y, x, 0]])
    return np.eye(3) + np.sin(angle) * cross + (1 - np.cos(angle)) * cross @ cross


def _from_up(direction: np.ndarray) -> np.ndarray:
    """The shortest rotation that takes +z to a unit direction."""
    axis = np.cross([0, 0, 1.0], direction)
    size = np.linalg.norm(axis)
    if size < 1e-4:
        return np.eye(3) if direction[2] > 0 else np.diag([-1.0, 1.0, -1.0])
    return _turn(axis / size, np.arctan2(size, direction[2]))
