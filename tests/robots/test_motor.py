"""The limits of a wheel motor."""

import math

import numpy as np
import pytest

from nhtrack.robots.motor import Motor

INF = math.inf
MOTORS = [Motor(1, 1, INF), Motor(1, 2, 10), Motor(0.3, 5, 10), Motor(INF, INF, 10), Motor(INF, INF, INF)]
LOSSES = [(0.0, 0.0), (0.1, 0.0), (0.0, 0.2), (0.1, 0.2), (0.02, 0.29)]


@pytest.mark.parametrize("motor", MOTORS)
@pytest.mark.parametrize("losses", LOSSES)
def test_the_free_speed_is_the_largest_that_the_motor_holds_against_losses(
    motor: Motor, losses: tuple[float, float]
) -> None:
    damping, dry = losses

    def holds(speed: float) -> bool:
        needed = damping * speed + dry
        return motor.saturate(np.array([needed]), np.array([speed]))[0] == needed and speed < motor.no_load_speed

    fastest = motor.free_speed(damping, dry)
    if fastest < INF:
        assert holds((1 - 1e-9) * fastest)
        assert not holds((1 + 1e-9) * fastest)
    else:
        assert holds(1e9)


@pytest.mark.parametrize("motor", [Motor(1, 1, INF), Motor(1, 5, 10), Motor(1, 1, 10)])
@pytest.mark.parametrize("dry", [1.0001, 6.0])
def test_dry_friction_beyond_the_torque_holds_the_wheel(motor: Motor, dry: float) -> None:
    assert motor.free_speed(0.0, dry) == 0
    assert motor.free_speed(0.1, dry) == 0
