"""Numbers of the kinds that kernels switch on; importing this compiles nothing."""

COINCIDE, DOT, DOT_DIFFERENCE, IN_PLANE, DISTANCE, RATIO, TURN_RATE, NO_SIDESLIP, ROLL, MESH = range(10)
ROWS_OF = (3, 1, 1, 1, 1, 1, 1, 1, 3, 1)

ANGLE, SLIDE = range(2)

POLYNOMIAL, SINE, SPLINE = range(3)

COORDINATE, COORDINATE_RATE, POSITION, VELOCITY, TURN, LEAN, LEAN_RATE, GAP, OWN_STATE = range(9)

NONE, BAUMGARTE, PROJECTION = range(3)
