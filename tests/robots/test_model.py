"""The reduced model: equations by hand, Euler-Poincare in general, loads, friction demand, motor limits."""

from dataclasses import replace

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from nhtrack import se2
from nhtrack.ground import GRAVITY, Gravity
from nhtrack.robots.diff_drive import DiffDrive, Motor
from nhtrack.robots.diff_drive.losses import WheelLosses
from nhtrack.robots.diff_drive.model import utilisation
from tolerances import HAND, ROUNDED_SUM

MOTOR = Motor(torque_limit=1.0, stall_torque=2.0, no_load_speed=10.0)
# 2 I_w / r^2 = 0.4 kg; the caster stands 0.1 m behind the axle.
CART = DiffDrive(0.05, 0.1, 2.0, 0.03, 0.0005, (-0.02, 0.0, 0.04), ((-0.1, 0.0),), MOTOR)
LOPSIDED = replace(CART, com=(-0.02, 0.01, 0.04))
MOTION = (0.5, 2.0, 1.0, 3.0)  # v, omega, u_x, u_theta


def motion(*values: float) -> tuple[np.ndarray, ...]:
    return tuple(np.array(value) for value in values)


speeds = st.floats(-5.0, 5.0)
motions = st.tuples(speeds, speeds, speeds, speeds).map(lambda values: motion(*values))
carts = st.builds(
    lambda c_x, c_y, spin: replace(CART, com=(c_x, c_y, 0.04), wheel_inertia=spin),
    st.floats(-0.05, 0.05),
    st.floats(-0.05, 0.05),
    st.floats(0.0, 1e-3),
)


class TestInertia:
    def test_spinning_wheels_add_mass_and_yaw_inertia(self) -> None:
        assert CART.m_eff == pytest.approx(2.4, rel=HAND)
        assert CART.J_eff == pytest.approx(0.034, rel=HAND)
        assert CART.wheel_separation == pytest.approx(0.2, rel=HAND)

    def test_a_centre_of_mass_off_the_axis_couples_speed_and_yaw(self) -> None:
        assert LOPSIDED.first_moment == pytest.approx((-0.04, 0.02), rel=HAND)
        np.testing.assert_allclose(LOPSIDED.mass_matrix, [[2.4, -0.02], [-0.02, 0.034]], rtol=HAND)


class TestLosses:
    LOSSY = replace(LOPSIDED, losses=WheelLosses((0.01, 0.02), (0.1, 0.3)))

    def test_wheel_torques_by_hand(self) -> None:
        # On (0.052, 0.073) of MOTION: wheels at 6 and 14 rad/s lose 0.06 + 0.1 and 0.28 + 0.3 N m.
        np.testing.assert_allclose(self.LOSSY.wheel_torques(*motion(*MOTION)), (0.212, 0.653), rtol=HAND)

    def test_a_wheel_at_rest_loses_in_the_direction_in_which_it_starts(self) -> None:
        started = self.LOSSY.wheel_losses(*motion(0.0, 0.0, 0.1, 3.0))  # wheels speed up by -4 and 8 rad/s^2
        np.testing.assert_allclose(started, (-0.1, 0.3), rtol=HAND)
        assert (self.LOSSY.wheel_losses(*motion(0.0, 0.0, 0.0, 0.0)) == 0).all()

    def test_losses_ask_nothing_of_the_ground(self) -> None:
        for demand in ("friction_demand", "wheel_loads"):
            lossy, lossless = (getattr(cart, demand)(*motion(*MOTION)) for cart in (self.LOSSY, LOPSIDED))
            np.testing.assert_array_equal(lossy, lossless)

    @given(st.floats(-0.1, 0.1), st.floats(-0.3, 0.3))
    def test_what_is_at_rest_stays_at_rest_until_torques_are_larger(self, left: float, right: float) -> None:
        held = self.LOSSY.acceleration(*motion(0.0, 0.0), np.array([left, right]))
        np.testing.assert_allclose(held, 0.0, atol=100 * ROUNDED_SUM)
        pushed = self.LOSSY.acceleration(*motion(0.0, 0.0), np.array([0.11 + abs(left), 0.31 + abs(right)]))
        assert (self.LOSSY.wheel_speeds(*pushed) > 0).all()

    @given(
        st.tuples(st.sampled_from([0.0, -3.0, 5.0]), st.sampled_from([0.0, -4.0, 2.0])),
        st.tuples(st.floats(-1.0, 1.0), st.floats(-1.0, 1.0)),
    )
    def test_dry_friction_is_coulombs(self, speeds: tuple[float, float], torque: tuple[float, float]) -> None:
        """Against a turning wheel it is c; a wheel at rest has less, or all of it against where it starts."""
        cart = replace(self.LOSSY, losses=WheelLosses((0.0, 0.0), (0.1, 0.3)))
        lossless, speed = replace(cart, losses=WheelLosses()), np.array(speeds)
        v, omega = np.linalg.solve(cart.rolling_map, speed)
        v, omega = (np.array(0.0) if speeds == (0.0, 0.0) else np.array(value) for value in (v, omega))
        mobility = cart.torque_gain @ cart.rolling_map.T
        rate = lossless.acceleration(v, omega, np.array(torque)) @ cart.rolling_map.T
        taken = cart.losses.held(speed, rate, mobility)
        left_over = rate - taken @ mobility
        for wheel, c in enumerate((0.1, 0.3)):
            if speed[wheel] != 0:
                assert taken[wheel] == np.sign(speed[wheel]) * c
            elif abs(left_over[wheel]) > 1e-9:
                assert taken[wheel] == pytest.approx(np.sign(left_over[wheel]) * c, rel=HAND)
            else:
                assert abs(taken[wheel]) <= c

    @given(motions)
    def test_acceleration_is_the_inverse_of_wheel_torques(self, at: tuple) -> None:
        found = self.LOSSY.acceleration(at[0], at[1], self.LOSSY.wheel_torques(*at))
        np.testing.assert_allclose(found, at[2:], rtol=0, atol=1e4 * 150 * ROUNDED_SUM)

    @given(st.lists(motions, min_size=1, max_size=5))
    def test_a_batch_is_its_members(self, rows: list) -> None:
        columns = [np.array(column) for column in zip(*rows, strict=True)]
        torque = np.stack([np.array([float(u_x), float(u_theta)]) / 10 for _, _, u_x, u_theta in rows])
        found = self.LOSSY.acceleration(columns[0], columns[1], torque)
        expected = [self.LOSSY.acceleration(*row[:2], each) for row, each in zip(rows, torque, strict=True)]
        np.testing.assert_allclose(found, expected, rtol=HAND, atol=1e4 * ROUNDED_SUM)

    @pytest.mark.parametrize(
        ("motor", "loss", "speed"),
        [
            (MOTOR, (0.0, 0.0), 10.0),
            (MOTOR, (0.05, 0.0), 8.0),  # 2 (1 - 0.8) = 0.05 (8)
            (MOTOR, (0.05, 0.25), 7.0),  # 2 (1 - 0.7) = 0.05 (7) + 0.25
            (MOTOR, (0.5, 0.2), 1.6),  # the driver allows 1 N m only
            (MOTOR, (0.0, 1.5), 0.0),  # and not the 1.5 that would be needed
            (replace(MOTOR, stall_torque=float("inf")), (0.05, 0.25), 10.0),
            (replace(MOTOR, no_load_speed=float("inf")), (0.05, 0.25), 15.0),  # 1 = 0.05 (15) + 0.25
            (replace(MOTOR, no_load_speed=float("inf")), (0.0, 0.25), float("inf")),
        ],
    )
    def test_the_speed_that_motors_hold_against_losses_by_hand(
        self, motor: Motor, loss: tuple[float, float], speed: float
    ) -> None:
        assert motor.free_speed(*loss) == pytest.approx(speed, rel=HAND)
        losses = WheelLosses((0.0, loss[0]), (0.0, loss[1]))  # the weaker wheel decides
        assert replace(CART, motor=motor, losses=losses).top_speed == pytest.approx(0.05 * speed, rel=HAND)


class TestWrenchAndTorque:
    def test_wheel_torques_by_hand(self) -> None:
        # f = 2.10 + 0.4 (1) = 2.5, t = 0.03 + 0.4 (0.01) (3) = 0.042, r/2 (2.5 -+ 0.42)
        np.testing.assert_allclose(LOPSIDED.wheel_torques(*motion(*MOTION)), (0.052, 0.073), rtol=HAND)

    def test_gravity_along_a_slope_by_hand(self) -> None:
        # On MOTION's 2.10, 1.80, 0.03 N: f_x - 2 (0.5), f_y - 2 (-0.25), tau + 0.02 (0.5) + 0.04 (-0.25)
        wrench = LOPSIDED.ground_wrench(*motion(*MOTION), Gravity(0.5, -0.25, 9.0))
        np.testing.assert_allclose(wrench, (1.10, 2.30, 0.03), rtol=HAND)

    @given(carts, motions, st.tuples(st.floats(-9, 9), st.floats(-9, 9)))
    def test_the_maps_are_wrench_and_torques_term_by_term(self, cart: DiffDrive, at: tuple, along: tuple) -> None:
        v, omega, u_x, u_theta = at
        gravity = Gravity(np.array(along[0]), np.array(along[1]), 9.0)
        columns = np.broadcast_arrays(u_x, u_theta, omega**2, omega * v, gravity.x, gravity.y)
        terms = np.stack(columns, axis=-1)
        size = np.abs(terms) @ np.abs(cart.ground_map)
        wrench = np.stack(cart.ground_wrench(*at, gravity), axis=-1)
        np.testing.assert_array_less(np.abs(terms @ cart.ground_map - wrench), ROUNDED_SUM * size + 1e-300)
        size = np.abs(terms) @ np.abs(cart.torque_map)
        torques = cart.wheel_torques(*at, gravity)
        bound = ROUNDED_SUM * (size + cart.wheel_radius * (1 + 1 / cart.half_separation) * np.abs(terms).sum())
        np.testing.assert_array_less(np.abs(terms @ cart.torque_map - torques), 10 * bound + 1e-300)

    def test_wheel_speeds_by_hand(self) -> None:
        np.testing.assert_allclose(CART.wheel_speeds(*motion(0.5, 2.0)), (6.0, 14.0), rtol=HAND)

    @given(carts, motions)
    def test_ground_wrench_is_euler_poincare_without_lateral_motion(self, cart: DiffDrive, at: tuple) -> None:
        v, omega, u_x, u_theta = at
        zero, (m_x, m_y) = np.zeros_like(v), cart.first_moment
        xi, u = np.stack([v, zero, omega]), np.stack([u_x, zero, u_theta])
        inertia = np.array([[cart.mass, 0.0, -m_y], [0.0, cart.mass, m_x], [-m_y, m_x, cart.axle_inertia]])
        expected = inertia @ u - se2.ad_transpose(xi, inertia @ xi)
        np.testing.assert_allclose(np.stack(cart.ground_wrench(*at)), expected, rtol=0, atol=150 * ROUNDED_SUM)

    @given(carts, motions)
    def test_acceleration_is_the_inverse_of_wheel_torques(self, cart: DiffDrive, at: tuple) -> None:
        v, omega, u_x, u_theta = at
        found = cart.acceleration(v, omega, cart.wheel_torques(*at))
        # 100: condition of the mass matrix, largest over smallest of its entries.
        np.testing.assert_allclose(found, (u_x, u_theta), rtol=0, atol=100 * 150 * ROUNDED_SUM)

    @given(st.lists(motions, min_size=1, max_size=5))
    def test_a_batch_is_its_members_bit_for_bit(self, rows: list) -> None:
        columns = [np.array(column) for column in zip(*rows, strict=True)]
        for method in (LOPSIDED.wheel_torques, LOPSIDED.wheel_loads):
            expected = np.stack([method(*row) for row in rows])
            np.testing.assert_array_equal(method(*columns), expected)


def loads_by_balance_at_the_centre_of_mass(cart: DiffDrive, at: tuple[np.ndarray, ...]) -> np.ndarray:
    """Loads [N] of left, right and caster: moments of all floor forces about the CoM spin the wheels only."""
    v, omega, u_x, _ = at
    f_x, f_y, _ = cart.ground_wrench(*at)
    com = np.array(cart.com)
    feet = np.array([(0, cart.half_separation, 0), (0, -cart.half_separation, 0), (*cart.casters[0], 0)])
    per_load = np.cross(feet - com, (0, 0, 1))
    friction = np.cross(-com, (f_x, f_y, 0))
    spin = 2 * cart.wheel_inertia / cart.wheel_radius  # of both wheels, per forward speed
    change = np.array([-omega * spin * v, spin * u_x, 0])  # of the spin's angular momentum, turning frame
    balance = np.vstack([np.ones(3), per_load.T[:2]])
    return np.linalg.solve(balance, [cart.mass * GRAVITY, *(change - friction)[:2]])


class TestWheelLoads:
    @given(carts, motions)
    def test_as_moments_about_the_centre_of_mass(self, cart: DiffDrive, at: tuple) -> None:
        expected = loads_by_balance_at_the_centre_of_mass(cart, at)
        # 20: a moment over the shortest lever, 0.05 m; 100 N: the largest force at these speeds.
        np.testing.assert_allclose(cart.wheel_loads(*at), expected[:2], rtol=0, atol=20 * 100 * ROUNDED_SUM)

    def test_two_casters_share_by_least_squares(self) -> None:
        # In front and behind alike, CoM over the axle: least squares gives all four feet the same load.
        cart = replace(CART, com=(0.0, 0.0, 0.04), casters=((-0.1, 0.0), (0.1, 0.0)))
        np.testing.assert_allclose(cart.wheel_loads(*motion(0, 0, 0, 0)), (4.905, 4.905), rtol=HAND)


class TestUtilisation:
    def test_a_wheel_bears_force_moment_and_half_the_side_force(self) -> None:
        # Motion (0.5, 2, 1, 3): f_x = 2.16, f_y = 1.88, tau = 0.05; longitudinal 1.08 -+ 0.25, lateral 0.94
        loads = CART.wheel_loads(*motion(*MOTION))
        expected = np.hypot((0.83, 1.33), 0.94) / (0.5 * loads)
        np.testing.assert_allclose(CART.friction_utilisation(*motion(*MOTION), 0.5), expected, rtol=HAND)

    def test_without_friction_any_force_is_infinitely_much(self) -> None:
        assert np.isposinf(CART.friction_utilisation(*motion(0, 0, 1, 0), 0.0)).all()
        assert (CART.friction_utilisation(*motion(0.5, 0, 0, 0), 0.0) == 0).all()

    def test_a_lifted_wheel_holds_nothing(self) -> None:
        # At v omega = 40 m/s^2 the moment 0.04 (2) (40) exceeds what the inner wheel's weight can balance.
        fast = motion(4, 10, 0, 0)
        assert CART.wheel_loads(*fast)[0] < 0
        left, right = CART.friction_utilisation(*fast, 1.0)
        assert np.isposinf(left)
        assert np.isfinite(right)

    def test_of_a_limit_that_is_nothing(self) -> None:
        found = utilisation(np.array([1.0, 0.0, 1.0, 3.0]), np.array([0.0, 0.0, -1.0, 2.0]))
        np.testing.assert_array_equal(found, [np.inf, 0.0, np.inf, 1.5])


class TestMotor:
    @pytest.mark.parametrize(
        ("torque", "speed", "delivered"),
        [
            (0.5, 0.0, 0.5),  # inside: as asked
            (3.0, 0.0, 1.0),  # the driver's limit, below stall
            (3.0, 8.0, 0.4),  # the line: 2 (1 - 0.8)
            (-3.0, 8.0, -1.0),  # braking: the driver's limit again
            (-3.0, -8.0, -0.4),  # the line in reverse
            (3.0, -8.0, 1.0),
            (0.0, 12.0, -0.4),  # above the no-load speed the motor brakes by itself
            (-0.7, 12.0, -0.7),  # and may be asked to brake harder
            (0.0, 40.0, -1.0),  # never beyond what the driver allows
        ],
    )
    def test_envelope_by_hand(self, torque: float, speed: float, delivered: float) -> None:
        assert MOTOR.saturate(np.array(torque), np.array(speed)) == pytest.approx(delivered, rel=HAND)

    @pytest.mark.parametrize("name", ["torque_limit", "stall_torque", "no_load_speed"])
    @pytest.mark.parametrize("value", [0.0, -1.0, float("nan")])
    def test_refuses_what_is_not_positive(self, name: str, value: float) -> None:
        with pytest.raises(ValueError, match=f"{name}: expected a positive number, got"):
            replace(MOTOR, **{name: value})
