"""Results of fits, made by hand, for the tests of what is written of them."""

import numpy as np

from fitting._result import FitResult, FitStep, FittedCoefficient, FitView

ODD = '<b>&"glass".k_d'
TITLE = "<script>alert('a')</script> & \"b\""


def coefficient(name, value, error=None, **others):
    known = dict(
        symbol="k_d",
        start=0.5,
        identifiable=error is not None,
        seen=True,
        confounded_with=(),
        at_bound=False,
        bounds=(0.0, 1.0),
        unit="1",
        standard_error=error,
        interval_95=None if error is None else (value - 1.96 * error, value + 1.96 * error),
    )
    return FittedCoefficient(name=name, value=value, **(known | others))


def view(camera="main", height=6, width=8):
    random = np.random.default_rng(3)
    target = random.random((height, width, 3)).astype(np.float32)
    weight = np.ones((height, width), np.float32)
    weight[0] = 0
    residual = (random.normal(0, 0.01, target.shape) * weight[..., None]).astype(np.float32)
    return FitView(camera, target, target + residual, residual, weight)


def save_scene(scene, path):
    assert path.suffix == ".toml"
    path.write_text(str(scene))


def small_result() -> FitResult:
    """A fit of which much cannot be known."""
    coefficients = (
        coefficient(ODD, 0.120345678, 0.00042),
        coefficient("floor.k_d.r", 0.3, seen=False),
        coefficient("glass.k_s", 0.41, confounded_with=("glass.k_h", "glass.k_a")),
        coefficient("glass.k_t", 1.0, 0.002, at_bound=True, interval_95=(0.996, 1.0)),
        coefficient("glass.phong_exponent", 50.3141, 0.27, symbol="n", bounds=(1.0, 1000.0)),
    )
    correlation = np.eye(5)
    correlation[0, 4] = correlation[4, 0] = -0.93
    correlation[1:3] = correlation[:, 1:3] = np.nan
    return FitResult(
        status="not_identifiable",
        message="stopped: a <small> step",
        coefficients=coefficients,
        correlation=correlation,
        rank=3,
        rmse=0.01,
        noise=float("nan"),
        noise_given=False,
        steps=3,
        history=tuple(FitStep(i, 10.0**-i, 0.1 * i, i != 1) for i in range(3)),
        seconds_compile=2.0,
        seconds_solve=0.5,
        starts_tried=1,
        effects=(("shadows", True, "light <1>"), ("refraction", False, "no k_t")),
        views=(view(),),
        scene={"the": "scene"},
        free=("glass.*",),
    )
