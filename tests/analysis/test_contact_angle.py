"""The contact angle of synthetic caps of known angle."""

from __future__ import annotations

import numpy as np
import pytest

from pydlpoly import InputError
from pydlpoly.analysis import ContactAngle, frames_of_arrays
from pydlpoly.analysis.contact_angle import fit_cap

CELL = np.diag([24.0, 22.0, 30.0])
WALL = -9.0
DENSITY = 3.0


def cap(angle: float, radius: float, rng: np.random.Generator, shift: tuple[float, float]) -> np.ndarray:
    """Uniform beads of a sphere that a plane cuts at the angle, anywhere on the wall, also across its edges."""
    count = rng.poisson(DENSITY * (2.0 * radius) ** 3)
    places = (2.0 * rng.random((count, 3)) - 1.0) * radius
    height = -radius * np.cos(np.radians(angle))
    inside = (np.linalg.norm(places, axis=1) < radius) & (places[:, 2] + height > 0.0)
    return places[inside] + [*shift, height + WALL]


@pytest.mark.parametrize("angle", [60.0, 90.0, 120.0, 150.0])
def test_angle_of_a_cap(angle: float) -> None:
    """Within 2 degrees: 60 frames of about 1000 beads place each layer's edge to about 0.05 Å of 6 Å."""
    rng = np.random.default_rng(4)
    positions = [cap(angle, 6.0 if angle > 70 else 8.0, rng, (11.0 + 0.1 * k, -10.5)) for k in range(60)]
    frames = [next(frames_of_arrays(places, CELL, species="L")) for places in positions]
    found = ContactAngle("L", WALL, bin_width=0.4, skip=0.8).of(frames)
    assert found.angle == pytest.approx(angle, abs=2.0)
    assert found.radius == pytest.approx(6.0 if angle > 70 else 8.0, abs=0.2)
    assert found.liquid == pytest.approx(DENSITY, rel=0.05)
    assert 0.0 < found.error < 1.5
    assert found.base == pytest.approx(found.radius * np.sin(np.radians(found.angle)), rel=1e-9)
    assert found.numbers()[0].name == "contact angle"
    assert len(found.curves()[0].x) == len(found.surface)


def test_points_on_a_sphere_give_it_back() -> None:
    z = np.linspace(0.5, 7.0, 9)
    r = np.sqrt(25.0 - (z - 2.5) ** 2)
    assert fit_cap(np.column_stack([r, z])) == pytest.approx((5.0, 2.5), rel=1e-12)


def test_what_is_no_droplet() -> None:
    empty = next(frames_of_arrays([[0.0, 0.0, -12.0]], CELL, species="L"))
    with pytest.raises(InputError, match="no beads of the droplet"):
        ContactAngle("L", WALL).of([empty])
    with pytest.raises(InputError, match="no frames"):
        ContactAngle("L", WALL).result()
    with pytest.raises(InputError, match="right angles"):
        ContactAngle("L", WALL).of(frames_of_arrays([[0.0, 0.0, 0.0]], CELL + np.eye(3, k=-1), species="L"))
    with pytest.raises(InputError, match="bin width"):
        ContactAngle("L", WALL, bin_width=0.0)
    with pytest.raises(InputError, match="2 layers only"):
        fit_cap(np.ones((2, 2)))
