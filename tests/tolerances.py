"""Every numeric tolerance of the suite, each with its reason; a test carries no tolerance of its own.

A tolerance is a budget: lowered when the code gets better, never raised to make a test pass.
"""

# The spacing of doubles at 1; a correctly rounded operation is wrong by at most half of it.
EPS = 2.0**-52

# Numbers worked by hand to at least thirteen digits.
HAND = 1e-12

# -- SE(2): relative to the norm of what enters the sum --------------------------------------------

# Products of poses, Ad and ad: about ten rounded operations, sine and cosine within one EPS each.
ALGEBRA = 16 * EPS

# Rotation by theta_a + theta_b against two rotations: the rounded sum moves the angle by EPS/2 of its size,
# once per sum; a test multiplies by the sum of the headings' magnitudes.
ANGLE_SUM = 4 * EPS

# exp, log and the Jacobians against the same in 60 decimal digits: two rounded quotients, a product and a
# sum. V(theta) is a rotation times a number, so log does not lose digits even where V is nearly singular.
COEFFICIENT = 4 * EPS

# exp, then log: both of the above.
ROUND_TRIP = 8 * EPS

# scipy's expm is the side that rounds: Pade with up to four squarings at |theta| < 2 pi.
EXPM = 2e-13

# Central difference at h = 1e-5: h^2/6 times third derivatives of order 1, rounding EPS/h.
FINITE_DIFFERENCE = 1e-8

# -- the ideal integrator --------------------------------------------------------------------------

# scipy's DOP853 at rtol 1e-12 over one control period, relative to the path; the quadrature is exact to rounding.
DOP853 = 1e-11

# -- Reduced model ---------------------------------------------------------------------------------

# A dozen rounded products and sums; a test multiplies by the largest term that enters (forces [N] of order 100).
ROUNDED_SUM = 16 * EPS

# A robot read where its file places it, metres from the origin: EPS of that distance, squared in the inertia.
READING = 1e-13

# -- MuJoCo against the reduced model --------------------------------------------------------------

# MuJoCo's composite inertia and recursive Newton-Euler round some fifty times per robot; the budget of the issue.
MASS_MATRIX = 1e-12

# Wheel loads leave out the products of inertia: I_xz omega^2 = 1.3e-3 N m at 10 rad/s, on a lever of 48 mm, is 0.2 %
# of the weight on each wheel of nh_mini. Share of the weight.
PRODUCTS_OF_INERTIA = 0.003
