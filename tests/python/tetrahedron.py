"""The smallest closed mesh: corners at the origin and `edge` along each axis [m], faces turned outward."""
import numpy as np

FACES = [[0, 2, 1], [0, 1, 3], [1, 2, 3], [2, 0, 3]]


def corners(edge):
    return np.array([[0, 0, 0], [1, 0, 0], [0, 1, 0], [0, 0, 1]]) * edge
