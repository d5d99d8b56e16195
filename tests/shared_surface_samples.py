"""Blocks and balls of glass that touch, and their pictures by an own tracer that knows one index for each place."""

import itertools

import numpy as np

import diffwhitted as dw

LOW, HIGH = np.array([0.1, 0.2, 0.3]), np.array([0.9, 0.8, 0.7])
EYE, WIDTH, HEIGHT, ANGLE = (0.9, 0.7, 4.0), 24, 18, 40.0


def box(name, low, high, material, turned=False):
    """Six polygons, counter-clockwise seen from outside unless turned."""
    for axis, side in itertools.product(range(3), (0, 1)):
        u, v = (axis + 1) % 3, (axis + 2) % 3
        corners = np.empty((4, 3))
        corners[:, axis] = (low, high)[side][axis]
        corners[:, u] = np.array([low[u], high[u], high[u], low[u]])
        corners[:, v] = np.array([low[v], low[v], high[v], high[v]])
        counter_clockwise = (side == 1) != turned
        yield dw.Polygon(f"{name}_{axis}{side}", corners if counter_clockwise else corners[::-1], material)


def scene(objects, materials, eye=EYE, **settings):
    return dw.Scene(
        objects=list(objects),
        materials=materials,
        background=dw.GradientBackground(LOW, HIGH),
        cameras={"main": dw.Camera(eye, (0, 0, 0), ANGLE, WIDTH, HEIGHT)},
        **{"max_depth": 8, "shadows": "tinted"} | settings,
    )


def picture(scene, **how):
    return np.asarray(dw.render(scene, scene.cameras["main"], **how), np.float64)


def rays(eye=EYE):
    ahead = -np.array(eye) / np.linalg.norm(eye)
    right = np.cross(ahead, [0, 1, 0])
    right /= np.linalg.norm(right)
    up, half = np.cross(right, ahead), np.tan(np.radians(ANGLE) / 2)
    x = ((np.arange(WIDTH) + 0.5) / WIDTH * 2 - 1) * half * WIDTH / HEIGHT
    y = (1 - (np.arange(HEIGHT) + 0.5) / HEIGHT * 2) * half
    directions = ahead + x[None, :, None] * right + y[:, None, None] * up
    return np.array(eye), directions / np.linalg.norm(directions, axis=-1, keepdims=True)


def planes(*walls):
    """Distances at which a ray meets the planes x_axis = value, with the normals."""

    def met(point, direction):
        return [((v - point[a]) / direction[a], np.eye(3)[a]) for a, v in walls if direction[a] != 0]

    return met


def spheres(*balls):
    def met(point, direction):
        for centre, radius in balls:
            away = point - np.array(centre)
            middle = -away @ direction
            square = middle**2 - away @ away + radius**2
            for t in (middle - np.sqrt(square), middle + np.sqrt(square)) if square > 0 else ():
                yield t, (away + t * direction) / radius

    return met


def traced(met, index_at, eye=EYE, levels=8):
    """The picture where light only bends: Snell's law, or total reflection, wherever `index_at` changes."""

    def light(point, direction):
        for _ in range(levels):
            index = index_at(point + 1e-9 * direction)
            ahead = [(t, normal) for t, normal in met(point, direction) if t > 1e-9]
            ahead = [(t, n, index_at(point + (t + 1e-6) * direction)) for t, n in ahead]
            ahead = [found for found in ahead if found[2] != index]
            if not ahead:
                share = (direction[1] + 1) / 2
                return (1 - share) * LOW + share * HIGH
            t, normal, there = min(ahead, key=lambda found: found[0])
            point = point + t * direction
            normal = -normal * np.sign(normal @ direction)
            cosine, ratio = -normal @ direction, index / there
            square = 1 - ratio**2 * (1 - cosine**2)
            if square < 0:
                direction = direction + 2 * cosine * normal
            else:
                direction = ratio * direction + (ratio * cosine - np.sqrt(square)) * normal
        return np.zeros(3)

    start, directions = rays(eye)
    return np.array([[light(start, d) for d in row] for row in directions])
