"""Every numeric tolerance of the suite, each with its reason; a test carries no tolerance of its own.

A tolerance is a budget: lowered when the code gets better, never raised to make a test pass.
"""

# The spacing of doubles at 1; a correctly rounded operation is wrong by at most half of it.
EPS = 2.0**-52

# Worked by hand to at least thirteen digits.
HAND = 1e-12

# -- SE(2). Errors are taken relative to the largest magnitude that enters the sum (the norm of the positions). ----

# Products of poses, Ad, ad, Jacobians times vectors: about ten rounded operations on values of the norm's size.
ALGEBRA = 16 * EPS

# Rotation by theta_a + theta_b against two rotations: rounding the sum moves the angle by EPS/2 of its magnitude;
# a test multiplies by 1 + |theta|.
ANGLE_SUM = 4 * EPS

# exp, and one trigonometric quotient, against the same in extended precision: six rounded operations.
COEFFICIENT = 8 * EPS

# log against solving V q = p in extended precision: as COEFFICIENT times the condition of V, 1/|sinc(theta/2)|.
LOG = 8 * EPS

# scipy's expm is the side that rounds: Pade with up to four squarings at |theta| < 2 pi.
EXPM = 2e-13

# J_r against sum (-ad)^k/(k+1)! in extended precision: the sum is exact to 1e-17 of its largest term, which is
# (2 pi)^5/6! = 14 at |theta| = 2 pi.
SERIES = 1e-14

# J_r^-1 J_r = I: entries of size |q| cancel; the inverse is large near 2 pi, so the test divides by its norm.
JACOBIAN_INVERSE = 16 * EPS

# Central difference of log(exp(X)^-1 exp(X + h e)) at h = 1e-5: h^2/6 times third derivatives, rounding EPS/h.
FINITE_DIFFERENCE = 1e-8
