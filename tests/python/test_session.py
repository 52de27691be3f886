"""Each push and question of a Python session against a real daemon with a simulated hand; with_daemon starts it."""
import inspect
import os
import subprocess
import sys
import unittest

import hapticclient as haptic
import numpy as np

from waiting import armed, eventually

MODEL, CLIENT, SURFACE = haptic.Source.LOCAL_MODEL, haptic.Source.CLIENT, haptic.Source.SURFACE


class Arrays(unittest.TestCase):
    """What NumPy or ctypes would cut to size in silence."""

    def test_what_does_not_fit_is_refused(self):
        from hapticclient import _abi, arrays
        for values in ([1.5], [-1], [2**32], [np.nan], [1 + 1j]):
            with self.assertRaisesRegex(ValueError, "^i: an index"):
                arrays.indices(values, "i")
        self.assertEqual(arrays.indices([1.0, 7], "i").tolist(), [1, 7])
        for values in (np.zeros((6, 2)), np.zeros(4), np.zeros((1, 3, 3))):
            with self.assertRaisesRegex(ValueError, "^p: n x 3 numbers are needed, not"):
                arrays.points(values, "p")
            with self.assertRaisesRegex(ValueError, "^c: m x 3 indices are needed, not"):
                arrays.corners(values, "c")
        self.assertEqual(arrays.points(range(6), "p").tolist(), [[0, 1, 2], [3, 4, 5]])
        self.assertEqual(arrays.corners([], "c").shape, (0, 3))
        with self.assertRaisesRegex(ValueError, "zero byte"):
            arrays.text("wall\0x")
        with haptic.Client(name="python names") as client:
            client.scene.create("whole")
            for cut in (lambda: client.scene.remove("whole\0x"), lambda: client.set("/objects/whole/pos?value=0,0,1\0x")):
                with self.assertRaisesRegex(ValueError, "zero byte"):
                    cut()
            self.assertEqual(client.get("/objects/whole/pos"), [0, 0, 0])
        with haptic.Client(name="python numbers") as client, client.open_session() as session:
            self.assertEqual(session.latest(np.uint32(0))["device"], 0)
            for name, cut in (("device", lambda: session.latest(2**32)), ("slot", lambda: session.model(2**32)),
                              ("slot", lambda: session.clear_model(np.int64(2**32))),
                              ("mesh", lambda: client.scene.drop_mesh(2**64 + 5)),
                              ("texture", lambda: client.scene.drop_texture(2**64 + 5)),
                              ("flags", lambda: client.scene.set_flags("whole", 2**32 + 1))):
                with self.assertRaisesRegex(ValueError, f"^{name}: .* is out of range"):
                    cut()
        for slot in (-1, 2**32):
            with self.assertRaisesRegex(ValueError, "slot"):
                _abi.ClearModel(slot=slot)


class Pushes(unittest.TestCase):
    def setUp(self):
        self.client = haptic.Client(name="python pushes")
        self.addCleanup(self.client.close)
        self.session = self.client.open_session()
        self.addCleanup(self.session.close)
        self.session.push_intent((0, 0, 0), latest=True)

    def felt(self, owner, force, within=0.05):
        """Whether the force of that owner comes to what is given, as a function of the hand's place if it is one."""
        def near():
            sample = self.session.latest()
            wanted = force(sample["p"]) if callable(force) else np.asarray(force)
            return np.linalg.norm(sample["by_source"][owner] - wanted) < within
        return eventually(near)

    def none_refused(self):
        self.assertTrue(eventually(lambda: self.session.acks().received_seq >= self.last))
        self.assertEqual(self.session.acks().rejected, 0)

    def test_local_models(self):
        session, soft = self.session, haptic.Material(200, 0)
        session.arm()
        session.push_intent((0, 0, -0.01), latest=True)
        self.assertTrue(eventually(lambda: session.latest()["p"][2] < -0.005))
        session.push_plane((0, 0, 0), (0, 0, 1), material=(200, 0), lease_s=5)  # Numbers will do.
        self.assertTrue(self.felt(MODEL, lambda p: (0, 0, -200 * p[2])))
        self.assertEqual(session.model(0).weight, 1)
        session.push_spring((0.01, 0, 0), material=soft, lease_s=5)
        self.assertTrue(self.felt(MODEL, lambda p: 200 * (np.array((0.01, 0, 0)) - p)))
        session.push_halfspaces((0, 0, 0), [(0, 0, 1, 0.002)], material=soft, lease_s=5)
        self.assertTrue(self.felt(MODEL, lambda p: (0, 0, 200 * (0.002 - p[2]))))
        session.push_halfspaces((0, 0, 0), [(0, 0, 1, 0.002), (0, 0, 1, 0.004)], corner=True, material=soft, lease_s=5)
        self.assertTrue(self.felt(MODEL, lambda p: (0, 0, 200 * (0.004 - p[2]))))  # Any of them is solid: the higher one.
        session.push_spring((0, 0, -0.05), free_length=0.02, material=soft, lease_s=5)
        self.assertTrue(self.felt(MODEL, lambda p: (0, 0, -200 * (p[2] + 0.05 - 0.02))))
        jacobian = ((0, 0, 0), (0, 0, 50), (0, 0, -100))  # By rows: y pushes by depth too.
        self.last = session.push_force_field((0, 0, 0), (0.5, 0, 0), jacobian, 0.1, lease_s=5)
        self.assertTrue(self.felt(MODEL, lambda p: (0.5, 50 * p[2], -100 * p[2])))
        session.clear_model(0)
        self.assertTrue(self.felt(MODEL, (0, 0, 0), 1e-9))
        self.none_refused()

    def test_a_push_that_is_refused_says_why(self):
        session = self.session
        with self.assertRaises(haptic.HapticError) as caught:
            session.push_force((0, 0, 0), latest=True, at_tick=1 << 40)
        self.assertEqual((caught.exception.code, caught.exception.where), (haptic.Code.INVALID_ARGUMENT, "at_tick"))
        with self.assertRaises(haptic.HapticError) as caught:
            for number in range(1, 18):  # Whether there is such an object the daemon says, in its acknowledgements.
                session.push_object_material(number, haptic.Material(700, 3), latest=True)
        self.assertEqual(caught.exception.code, haptic.Code.QUOTA_EXCEEDED)
        self.assertIn("16 targets", str(caught.exception))  # And not: "the user's quota of sessions".
        self.assertIn("latest=True", caught.exception.remedy)
        for wrong, remedy in ((dict(object_id=0, mask=0), "Scene.find()"), (dict(object_id=1, mask=1 << 20), "ObjectFlag.ENABLED, ")):
            with self.assertRaises(haptic.HapticError) as caught:
                session.push_object_flags(value=0, **wrong)
            self.assertIn(remedy, caught.exception.remedy)
            self.assertNotRegex(str(caught.exception), "haptic_|HAPTIC_")
        session.push_object_flags(17, 0, 0)
        with self.assertRaisesRegex(haptic.HapticError, "^normal: is no unit vector"):
            session.push_plane((0, 0, 0), (0, 0, 2))

    def test_an_argument_that_cannot_be_read_is_named(self):
        session, scene = self.session, self.client.scene
        for function, wrong, words in (
                (session.push_plane, {"origin": (0, 0), "normal": (0, 0, 1)}, "^origin: 3 numbers are needed, not 2$"),
                (session.push_plane, {"origin": 5, "normal": (0, 0, 1)}, "^origin: 3 numbers are needed, not 5$"),
                (session.push_plane, {"origin": "abc", "normal": (0, 0, 1)}, "^origin: 3 numbers"),
                (session.push_force, {"force": (0, 0, 1), "lease_s": float("nan")}, "^lease_s: nan is no time"),
                (session.push_force, {"force": (0, 0, 1), "lease_s": float("inf")}, "^lease_s: inf is no time"),
                (session.push_intent, {"p": (0, 0, 1), "q": (1, 0, 0)}, "^q: 4 numbers"),
                (session.push_intent, {"p": (0, 0, 1), "gripper_rad": "shut"}, "^gripper_rad: must be real number, not str$"),
                (session.clear_model, {"slot": "first"}, "^slot: 'str' object "),
                *((push, {"object_id": wrong, **rest}, words)
                  for push, rest in ((session.push_object_pose, {"p": (0, 0, 0)}), (session.push_object_flags, {"mask": 1, "value": 1}),
                                     (session.push_object_material, {"material": (500, 1)}),
                                     (session.push_object_vertices, {"indices": [0], "places": [(0, 0, 0)]}))
                  for wrong, words in (("ball", r"^object_id: a number is needed, not 'ball'; Scene\.find\('ball'\)\.id is its$"),
                                       (1.0, "^object_id: a whole number is needed, not 1.0$"),
                                       (2**32, "^object_id: 4294967296 is out of range$"))),
                (session.push_spring, {"origin": (0, 0, 0), "material": 1000}, "^material: haptic.Material"),
                (scene.create, {"name": "a", "pose": (0, 0, 1)}, r"^pose: haptic.Pose\(\(x, y, z\)\)"),
                (scene.create, {"name": "a", "shape": "sphere"}, "^'sphere' is none of ShapeKind.GROUP, ShapeKind.PLANE, "),
                (scene.create, {"name": "a", "size": (1, 2, 3, 4)}, "^size: at most 3"),
                (scene.create, {"name": "a", "size": 0.01}, "^size: GROUP takes nothing; leave out 0.01$"),
                (scene.create, {"name": "a", "shape": haptic.ShapeKind.SPHERE, "size": (0.01, 0.02)},
                 "^size: SPHERE takes its radius; leave out 0.02$")):
            with self.assertRaisesRegex((TypeError, ValueError), words):
                function(**wrong)
        scene.create("ball", haptic.ShapeKind.SPHERE, 0.01)
        self.assertEqual(scene.find("ball").size, (0.01, 0, 0))
        scene.set_shape("ball", haptic.ShapeKind.SPHERE, scene.find("ball").size)  # As it is told.
        with self.assertRaisesRegex(haptic.HapticError, "^path_count: is 1 "):
            scene.set_effect("ball", haptic.EffectKind.GUIDE, path=[(0, 0, 0)])

    def test_everything_says_what_it_is(self):
        self.assertEqual(repr(self.session), "<Session, open>")
        for name, thing in vars(haptic).items():
            if not inspect.isclass(thing) and not inspect.isfunction(thing):
                continue
            members = vars(thing).items() if inspect.isclass(thing) else ()
            for what, part in [(name, thing), *((f"{name}.{member}", value) for member, value in members
                                                if not member.startswith("_") and (callable(value) or isinstance(value, property)))]:
                words = inspect.getdoc(part) or ""
                self.assertFalse(words.startswith(f"{name}(") or not words, f"{what} has no words of its own")  # A dataclass's own are its fields.

    def test_what_is_closed_says_so(self):
        client = haptic.Client()
        events, recording, session = client.subscribe(), client.record(), client.open_session()
        for handle, use in ((events, events.fileno), (recording, recording.fileno), (session, session.latest), (client, client.devices)):
            handle.close()
            handle.close()
            with self.assertRaisesRegex(haptic.HapticError, "is closed") as caught:
                use()
            self.assertEqual(caught.exception.code, haptic.Code.INVALID_ARGUMENT)
        self.assertEqual((client.connected, session.alive, session.space), (False, False, 0))

    def test_a_device_is_read_by_its_place_in_the_group(self):
        session = self.session
        tick = session.latest()["tick"]
        self.assertTrue(eventually(lambda: session.latest(0)["tick"] > tick))
        self.assertEqual(session.latest(0)["device"], session.describe().device_index)
        with self.assertRaises(haptic.HapticError) as caught:
            session.latest(7)
        self.assertEqual(caught.exception.code, haptic.Code.INVALID_ARGUMENT)

    def test_what_is_dated_waits_for_its_tick(self):
        session = self.session
        session.arm()
        self.assertTrue(eventually(lambda: armed(session)))
        session.drain()
        at = int(session.latest()["tick"]) + 200
        self.last = session.push_force((0, 0.8, 0), lease_s=1, at_tick=at)
        self.assertTrue(eventually(lambda: session.latest()["tick"] > at + 20))
        read = session.drain()
        felt = read["by_source"][:, CLIENT, 1] > 0
        self.assertTrue(felt[read["tick"] >= at].all())
        self.assertFalse(felt[read["tick"] < at].any())
        self.none_refused()

    def test_forces_and_their_limits(self):
        session = self.session
        session.arm()
        # A force that is there before the ramp begins keeps it from beginning.
        self.assertTrue(eventually(lambda: not session.latest()["flags"] & haptic.SampleFlag.RAMPING))
        session.push_force((0, 1.5, 0), lease_s=5)
        self.assertTrue(self.felt(CLIENT, (0, 1.5, 0), 1e-6))
        self.last = session.push_limits(0.5, 0.1)
        self.assertTrue(eventually(lambda: abs(np.linalg.norm(session.latest()["force"]) - 0.5) < 1e-6))
        self.none_refused()
        self.assertGreater(session.space, 200)

    def test_objects_are_moved_and_changed(self):
        scene, session = self.client.scene, self.session
        number = scene.create("ball", haptic.ShapeKind.SPHERE, (0.01,), pose=haptic.Pose((0, 0, 0.3)))
        self.addCleanup(scene.remove, "ball")
        session.push_object_pose(number, (0.01, 0.02, 0.3), (0, 1, 0, 0))
        self.assertTrue(eventually(lambda: scene.find("ball").pose == haptic.Pose((0.01, 0.02, 0.3), (0, 1, 0, 0))))
        self.last = session.push_object_material(number, haptic.Material(700, 3, 0.4, 0.2))
        self.last = session.push_object_flags(number, haptic.ObjectFlag.ENABLED, 0)
        self.none_refused()
        scene.set_pose("ball", haptic.Pose((0, 0, -0.3)))
        scene.set_material("ball", haptic.Material(800, 2, 0.3, 0.1))
        scene.set_flags("ball", haptic.ObjectFlag.ENABLED)
        scene.set_shape("ball", haptic.ShapeKind.BOX, (0.01, 0.02, 0.03))
        found = scene.find("ball")
        self.assertEqual((found.pose.p, found.material, found.flags, found.shape, found.size),
                         ((0, 0, -0.3), haptic.Material(800, 2, 0.3, 0.1), haptic.ObjectFlag.ENABLED, haptic.ShapeKind.BOX,
                          (0.01, 0.02, 0.03)))
        with self.assertRaisesRegex(ValueError, "at most 3"):
            scene.set_shape("ball", haptic.ShapeKind.BOX, (1, 2, 3, 4))

    def test_what_a_hand_holds_is_where_that_is(self):
        scene, session = self.client.scene, self.session
        number = scene.create("pen", haptic.ShapeKind.SPHERE, 0.01, pose=haptic.Pose((0, 0, 0.3)))
        self.addCleanup(scene.remove, "pen")
        self.client.set("/devices/sim/tool?value=pen")
        in_hand = lambda: abs(scene.find("pen").pose.p[2]) < 0.05
        self.assertTrue(eventually(in_hand))
        with self.assertRaisesRegex(haptic.HapticError, "in the hand of .*detach it there first") as caught:
            scene.set_pose("pen", haptic.Pose((0, 0, -0.3)))
        self.assertEqual(caught.exception.code, haptic.Code.WOULD_BLOCK)
        self.last = session.push_object_pose(number, (0, 0, -0.3), (1, 0, 0, 0))  # Does nothing, as docs/client.md says.
        self.none_refused()
        self.assertTrue(eventually(in_hand))
        self.client.set("/devices/sim/tool?value=")
        scene.set_pose("pen", haptic.Pose((0, 0, -0.3)))

    def test_vertices_of_a_deformable_mesh(self):
        scene, session = self.client.scene, self.session
        plate = np.array(((-1, -1, 0), (1, -1, 0), (1, 1, 0), (-1, 1, 0))) * 0.05
        report = scene.upload(plate, ((0, 1, 2), (0, 2, 3)), deformable=True)
        self.assertIn(report.id, [mesh.id for mesh in scene.meshes()])
        number = scene.create("plate", haptic.ShapeKind.MESH, mesh=report.id, pose=haptic.Pose((0, 0, -0.02)),
                              material=haptic.Material(300, 0))
        self.addCleanup(scene.drop_mesh, report.id)
        self.addCleanup(scene.remove, "plate")
        session.arm()
        session.push_intent((0, 0, -0.03), latest=True)
        self.assertTrue(self.felt(SURFACE, lambda p: (0, 0, 300 * (-0.02 - p[2])) if p[2] < -0.021 else (9, 9, 9)))
        self.last = session.push_object_vertices(number, range(4), plate + (0, 0, 0.005))
        self.assertTrue(self.felt(SURFACE, lambda p: (0, 0, 300 * (-0.015 - p[2]))))
        self.none_refused()
        with self.assertRaisesRegex(ValueError, "more than 6656"):
            session.push_object_vertices(number, [0] * 6657, [plate[0]] * 6657)

    def test_a_session_tells_of_itself_and_its_lease(self):
        session = self.session
        info = session.describe()
        self.assertEqual((info.period_ns, info.device_count, info.device.uri), (1_000_000, 1, self.client.devices()[0].uri))
        session.acquire_lease()
        with haptic.Client() as other, other.open_session() as rival:
            self.assertTrue(other.connected)
            with self.assertRaises(haptic.HapticError) as caught:
                rival.acquire_lease()
            self.assertIn("python pushes", str(caught.exception))
            session.release_lease()
            rival.acquire_lease()
        self.assertFalse(session.acks().ended)
        with self.assertRaises(haptic.HapticError):
            session.model(99)

    def test_devices_are_opened_and_closed(self):
        opened = self.client.open_device("sim://touch?serial=second")
        self.assertIn(opened.uri, [device.uri for device in self.client.devices() if device.open])
        with haptic.Client(name="other") as other:
            other.open_device(opened.uri)
            with self.assertRaisesRegex(haptic.HapticError, "administration"):
                self.client.close_device(opened.uri)
        with self.assertRaisesRegex(haptic.HapticError, "administration"):
            self.client.close_device("")
        # By who alone has asked for it, or by administration; the daemon hears in its own time that the other has left.
        self.assertTrue(eventually(lambda: "other" not in [client["name"] for client in self.client.get("/clients")]))
        self.client.close_device(opened.uri)
        self.client.open_device(opened.uri)
        with haptic.Client(administration=True, socket=os.environ["HAPTICD_SOCKET"].replace("control", "admin")) as administrator:
            administrator.close_device(opened.uri)
        self.assertNotIn(opened.uri, [device.uri for device in self.client.devices() if device.open])

    def test_what_follows_a_disarm_or_an_end_need_not_ask_twice(self):
        for _ in range(5):
            device = self.client.open_device("sim://touch?serial=again")
            with self.client.open_session(device.uri) as session:
                session.arm()
                session.disarm()
                self.client.set(f"/devices/{device.name}/scale?value=2")
                session.arm()
                session.disarm()
                with self.client.record(device.uri) as recording:
                    recording.stop()
                session.arm()
            self.client.close_device(device.uri)

    def test_a_killed_program_leaves_no_simulated_device(self):
        uri = "sim://touch?serial=killed"
        program = ("import hapticclient as haptic\n"
                   f"session = haptic.Client().open_session({uri!r})\n"
                   "session.arm()\n"
                   "print('armed', flush=True)\n"
                   "input()\n")
        with subprocess.Popen([sys.executable, "-c", program], stdin=subprocess.PIPE, stdout=subprocess.PIPE, text=True) as killed:
            self.assertEqual(killed.stdout.readline(), "armed\n")
            self.assertIn(uri, [device.uri for device in self.client.devices() if device.open])
            killed.kill()
        self.assertTrue(eventually(lambda: uri not in [device.uri for device in self.client.devices()]))


if __name__ == "__main__":
    unittest.main()
