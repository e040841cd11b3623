"""The 50 coordinates of the vehicle and where each stands in the arrays.

Seven rigid bodies have six coordinates each, in the order x, y, z, roll,
pitch, yaw; then come the pitch angles of the eight axle boxes. Displacements
are small, in the track frame (x along the line, y to the right, z down), and
measured from the static equilibrium in a frame that moves with the car body.

The car body's x is held (it defines the moving frame), and the wheelsets'
pitch angles are cyclic: nothing depends on them, so they are integrated on
their own. The other 45 are the coordinates of the linear system.
"""

import numpy as np

X, Y, Z, ROLL, PITCH, YAW = range(6)

CAR_BODY = 0
BOGIES = (1, 2)
WHEELSETS = (3, 4, 5, 6)
BODY_COUNT = 7
BOX_START = 6 * BODY_COUNT
COORDINATE_COUNT = BOX_START + 8

SIDES = ("left", "right")
SIDE_SIGNS = (-1.0, 1.0)
"""Sign of y on the left and on the right."""

BOGIE_SIGNS = (1.0, -1.0)
"""Sign of x of the bogies in the car body; index 1 leads."""

AXLE_SIGNS = (1.0, -1.0, 1.0, -1.0)
"""Sign of x of the four axles in their bogie frames."""

BOGIE_OF_WHEELSET = (0, 0, 1, 1)


def coordinate(body: int, direction: int) -> int:
    """Return the index of a coordinate of a rigid body (0 car body, 1-2, 3-6)."""
    return 6 * body + direction


def box_coordinate(wheelset: int, side: int) -> int:
    """Return the index of an axle box's pitch (wheelset 0-3, side 0 left, 1 right)."""
    return BOX_START + 2 * wheelset + side


HELD = coordinate(CAR_BODY, X)
SPINS = np.array([coordinate(body, PITCH) for body in WHEELSETS])
FREE = np.setdiff1d(np.arange(COORDINATE_COUNT), np.append(SPINS, HELD))
"""Indices of the 45 coordinates of the linear system."""

LATERAL = np.array([coordinate(body, Y) for body in range(BODY_COUNT)])
"""Indices of the lateral displacements of the seven bodies, shape (7,)."""

WHEELSET_COORDINATES = np.array(
    [[coordinate(body, direction) for direction in range(6)] for body in WHEELSETS]
)
"""Indices, shape (4, 6), in the order of the contact forces' columns."""
