"""The simulated device feels a wall and a mesh, through the installed daemon, builder and command line."""
import math
import pathlib

from guest import hand
from guest.report import ctl, device, ensure, eventually, status_json


def check_a_wall_pushes_back():
    with hand.wall(), hand.armed(), hand.pressing():
        eventually(lambda: hand.force_z() > 1.0, "the wall pushes")
        here = device()
        depth = hand.SURFACE - here["pose"]["p"][2]
        ensure(0 < depth < 0.010, "depth", depth)
        # Hooke, within what the hand still moves between two status answers.
        ensure(abs(here["force"][2] - hand.STIFFNESS * depth) < 0.25 * here["force"][2], here["force"], depth)
    eventually(lambda: not device()["armed"] and hand.force_z() == 0, "zero after the holder has gone")
    return {"force_n": round(here["force"][2], 3), "depth_mm": round(depth * 1e3, 3)}


def ball_stl(radius, rings=24):
    """A sphere as STL text: written here, so that nothing binary is needed."""
    def point(i, j):
        a, b = math.pi * i / rings, 2 * math.pi * j / (2 * rings)
        return (radius * math.sin(a) * math.cos(b), radius * math.sin(a) * math.sin(b), radius * math.cos(a))
    lines = ["solid ball"]
    for i in range(rings):
        for j in range(2 * rings):
            a, b, c, d = point(i, j), point(i + 1, j), point(i + 1, j + 1), point(i, j + 1)
            for corners in ((a, b, c), (a, c, d)):
                if len(set(corners)) < 3 or math.dist(corners[0], corners[1]) < 1e-12 or \
                   math.dist(corners[1], corners[2]) < 1e-12 or math.dist(corners[0], corners[2]) < 1e-12:
                    continue
                lines += ["facet normal 0 0 0", "outer loop", *("vertex %.9g %.9g %.9g" % p for p in corners), "endloop",
                          "endfacet"]
    return "\n".join(lines + ["endsolid ball", ""])


def check_a_mesh_is_loaded_and_felt():
    path = pathlib.Path("/tmp/ball.stl")
    path.write_text(ball_stl(0.020), encoding="ascii")
    ctl("load", str(path), "--scale", "m", "--weld", "0.001", "--name", "ball", "--at", "0,0,-0.030", "--stiffness", "500",
        "--damping", "2", timeout=120)
    triangles = status_json()["triangles"]
    ensure(triangles > 1000, "triangles", triangles)
    with hand.armed(), hand.pressing():
        eventually(lambda: hand.force_z() > 1.0, "the mesh pushes")
        here = device()
        depth = hand.SURFACE - here["pose"]["p"][2]  # its top is where the wall was
        ensure(0 < depth < 0.010, "depth", depth)
        ensure(abs(here["force"][2] - 500 * depth) < 0.25 * here["force"][2], here["force"], depth)
    ctl("remove", "ball")
    return {"triangles": triangles, "force_n": round(here["force"][2], 3)}


def check_stop_is_anybodys_and_latches():
    with hand.wall(), hand.armed(), hand.pressing():
        eventually(lambda: hand.force_z() > 1.0, "the wall pushes")
        ctl("stop")
        eventually(lambda: hand.force_z() == 0 and device()["fault"] != 0, "zero and latched after stop")
    ensure("stop" in device()["fault_text"], device()["fault_text"])
