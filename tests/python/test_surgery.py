#!/usr/bin/python3
"""examples/surgery says what it cannot use, and where it cuts. Usage, within with_daemon: test_surgery.py EXAMPLE_DIRECTORY"""
import pathlib
import subprocess
import sys
import tempfile
import types
import unittest
import unittest.mock

import numpy as np

EXAMPLE = pathlib.Path(sys.argv.pop())
sys.path.insert(0, str(EXAMPLE))
import hand  # noqa: E402
import meshes  # noqa: E402
import surgery  # noqa: E402

# A box from 0 to 10, 20 and 30 mm; its upper half alone is a lid that nothing below meets.
CORNERS = np.array([[x, y, z] for x in (0.0, 10) for y in (0.0, 20) for z in (0.0, 30)])
SQUARES = [(0, 1, 3, 2), (4, 6, 7, 5), (0, 4, 5, 1), (2, 3, 7, 6), (0, 2, 6, 4), (1, 5, 7, 3)]  # Outwards.
BOX = CORNERS, np.array([t for a, b, c, d in SQUARES for t in ((a, b, c), (a, c, d))])
TOP = CORNERS, BOX[1][-2:]


class Place(unittest.TestCase):
    def test_is_above_where_the_ray_leaves(self):
        for way, hit in (((0, 0, 1), (5, 10, 30)), ((0, 0, -2), (5, 10, 0)), ((3, 0, 0), (10, 10, 15)), ((0, -1, 0), (5, 0, 15))):
            at, out = meshes.vault_of(BOX, np.array(way, float), 7)
            unit = np.array(way) / np.linalg.norm(way)
            np.testing.assert_allclose(out, unit, atol=1e-12)
            np.testing.assert_allclose(at, np.array(hit) + 7 * unit, atol=1e-12)

    def test_needs_something_there(self):
        apart = np.vstack([CORNERS, [[5, 10, -30]]]), TOP[1]  # The box's middle is now below the lid.
        np.testing.assert_allclose(meshes.vault_of(apart, np.array([0.0, 0, 1]), 0)[0], [5, 10, 30], atol=1e-12)
        for way in ((0.0, 0, -1), (1.0, 0, 0)):  # What lies behind is not there; nor what the ray runs along.
            with self.assertRaisesRegex(meshes.Unusable, "nothing of the skull"):
                meshes.vault_of(apart, np.array(way), 0)
        for way in ((0, 0, 0), (np.nan, 0, 1), (np.inf, 0, 1)):
            with self.assertRaisesRegex(meshes.Unusable, "no direction"):
                meshes.vault_of(BOX, np.array(way, float), 0)
        with self.assertRaisesRegex(meshes.Unusable, "inwards"):
            meshes.vault_of((CORNERS, BOX[1][:, ::-1]), np.array([0.0, 0, 1]), 0)


class HeldUp(unittest.TestCase):
    def test_the_hand_waits_with_its_program(self):
        # Else it comes to its rest before it has yielded to what it feels, 0.9 mm from home.
        clock, asked = [5.0], []

        class Slow(hand.Hand):
            def intent(self, t, force, torque):
                asked.append(t)
                return super().intent(t, force, torque)

        sample = {"force": np.zeros(3), "torque": np.zeros(3)}
        session = types.SimpleNamespace(latest=lambda: sample, push_intent=lambda *_, **__: None, drain=lambda: np.zeros(1))
        device = types.SimpleNamespace(name="sim")
        values = {"/objects/fragment/pos": np.zeros(3), "/objects/fragment/rot": np.array([1.0, 0, 0, 0]),
                  "/devices/sim/tool": {"contacts": 0}}
        client = types.SimpleNamespace(status=lambda: types.SimpleNamespace(devices=[device]), get=values.get)
        with unittest.mock.patch.object(surgery, "time", types.SimpleNamespace(
                monotonic=lambda: clock[0], sleep=lambda s: clock.__setitem__(0, clock[0] + 0.4))):
            rows, _ = surgery.bring_home(session, client, Slow(approach_s=0.1, press_s=0.1, ease_s=0.1, rest_s=0.1))
        self.assertEqual(asked[0], 0)
        self.assertLess(np.diff(asked).max(), 0.021)
        self.assertEqual([row[0] for row in rows[:-1]], asked[1:])


class Program(unittest.TestCase):
    def refused(self, skull, *options):
        done = subprocess.run(["/usr/bin/python3", EXAMPLE / "surgery.py", "--skull", skull, *options], capture_output=True,
                              text=True, check=False)
        self.assertEqual(done.returncode, 1, done.stdout + done.stderr)
        self.assertNotIn("Traceback", done.stderr)
        return done.stderr

    def test_says_what_it_cannot_use(self):
        with tempfile.TemporaryDirectory() as folder:
            skull = pathlib.Path(folder) / "skull.ply"
            meshes.write_ply(skull, TOP)
            self.assertIn("surgery: --toward 0 0 -1: nothing of the skull", self.refused(skull, "--toward", "0", "0", "-1"))
            self.assertIn("none.ply", self.refused(skull.with_name("none.ply")))
            whole = skull.read_bytes()
            for damaged in (b"", whole[:40], whole[:-1], whole.replace(b"element face", b"element fac"), whole[:-4] + b"\xff" * 4):
                skull.write_bytes(damaged)
                self.assertIn("skull.ply", self.refused(skull))


if __name__ == "__main__":
    unittest.main()
