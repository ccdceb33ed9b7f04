"""Toutatis as radar saw it in December 1992, and as another program has its free rotation until then."""

import numpy as np
from scipy.spatial.transform import Rotation

import poinsot as pt

OBSERVED = """
1992-12-02T21:40 122.2 86.5 107.0  7.9  5.4  5.9
1992-12-03T19:30  86.3 81.8  24.5  6.6  7.7  4.7
1992-12-04T18:10  47.8 60.7 284.0 13   15    9.4
1992-12-05T18:50  14.6 39.4 207.1  9.4  4.3  8.4
1992-12-06T17:30 331.3 23.7 151.6  2.0  0.6  2.1
1992-12-07T17:20 222.5 25.4 143.9  5.7 15   15
1992-12-08T16:40 169.8 45.5 106.9  3.0  2.6  2.6
1992-12-09T17:50 137.3 71.3  22.3  3.4  3.4  1.1
1992-12-10T17:20 103.1 85.2 292.6  3.1  1.4  3.4
1992-12-11T09:40  77.0 85.7 225.5  2.8  1.6  2.7
1992-12-12T09:20  42.8 70.2 133.2  2.0  3.2  2.6
1992-12-13T08:10  13.7 44.4  51.9  2.5  5.3  5.3
1992-12-14T07:50 323.7 14.0   0.0  4.1  3.8  4.5
1992-12-15T07:50 193.2 24.4  21.4  3.2  8.2  8.0
1992-12-16T07:10 165.1 46.4 310.6  7.3  5.8  8.0
1992-12-17T06:49 130.6 76.1 234.9  0.8  1.1  1.2
1992-12-18T07:09  91.6 81.6 142.4  5.6  6.3  4.1
2008-11-23T10:45  86.2 85.0   0.3 29  122  131
"""
"""UTC and 3-1-3 angles (Takahashi, Busch and Scheeres 2013), then the angles in degrees between the long, middle and
short axes there and those of a free rotation since November 1992, as the tests of Principia have them (Euler solver).
"""


def test_free_rotation_of_toutatis_is_as_far_from_radar_as_another_program_says():
    rows = [line.split() for line in OBSERVED.split("\n") if line]
    numbers = np.array([row[1:] for row in rows], dtype=float)
    dates = np.array([row[0] for row in rows], dtype="datetime64[s]")
    days = (dates - np.datetime64("1992-11-09T17:49:47")) / np.timedelta64(86400, "s")
    days[-1] += 7 / 86400  # leap seconds
    toutatis = pt.Body((3.0836, 3.235, 1))
    attitude = Rotation.from_euler("ZXZ", (145.498, 65.865, 241.524), degrees=True)
    start = toutatis.state(attitude, omega_body=np.radians((14.51, 33.529, -98.709)))
    own = pt.free_motion(toutatis, start, days).attitude.as_matrix()
    seen = Rotation.from_euler("ZXZ", numbers[:, :3], degrees=True).as_matrix()
    apart = np.degrees(np.arccos(np.sum(own * seen, axis=1)))[:, [2, 0, 1]]
    assert np.all(np.abs(apart - numbers[:, 3:]) < np.where(numbers[:, 3:] < 10, 0.1, 1.0))
    assert np.median(apart[:-1]) < 4.5
