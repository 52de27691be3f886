#!/usr/bin/python3
"""examples/10-grasp.py leaves gravity, fingers and objects as they were. Usage: test_grasp.py PROGRAM; a daemon with two devices in
one group is there."""
import subprocess
import sys
import unittest

import hapticclient as haptic

PROGRAM = sys.argv.pop(1)


class Grasp(unittest.TestCase):
    def test_what_it_changed_is_as_before(self):
        with haptic.Client(name="test") as client:
            index, thumb = (device.name for device in client.status().devices[:2])
            client.set("/world/gravity?value=0,0,-1.5")
            client.set(f"/devices/{index}/finger?value=hertz,radius=0.007,arm=0.004,stiffness=0.3,damping=1,cue=0.5,uncoupled")
            client.scene.create("block", haptic.ShapeKind.SPHERE, 0.001, pose=haptic.Pose((0, 0, 0.5)))  # As in docs/grasping.md.

            def state():
                paths = ("/world/gravity", f"/devices/{index}/finger", f"/devices/{thumb}/finger")
                return [*map(client.get, paths), [item.name for item in client.scene.list()]]
            before = state()
            done = subprocess.run([sys.executable, PROGRAM], capture_output=True, text=True, check=False)
            self.assertEqual(done.returncode, 0, done.stdout + done.stderr)
            self.assertEqual(state(), before)


if __name__ == "__main__":
    unittest.main()
