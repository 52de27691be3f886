"""The Python module against a real daemon with a simulated hand; with_daemon starts it."""
import math
import os
import select
import threading
import time
import unittest

import hapticclient as haptic
import numpy as np
from hapticclient import arrays

from tetrahedron import FACES, corners
from waiting import eventually


class Daemon(unittest.TestCase):
    def setUp(self):
        self.client = haptic.Client(name="python test")
        self.addCleanup(self.client.close)

    def test_tells_about_itself_and_its_devices(self):
        info = self.client.info()
        self.assertEqual(info.protocol_major, 1)
        self.assertFalse(info.administration)
        devices = self.client.devices()
        self.assertTrue(devices[0].open)
        self.assertIn(haptic.Ability.ACTUATES_POSITION, devices[0].abilities)
        status = self.client.status()
        self.assertEqual(status.devices[0].uri, devices[0].uri)
        self.assertGreater(status.devices[0].limits.force, 0)
        statistics = self.client.statistics()
        self.assertIn("cycle", [histogram.name for histogram in statistics.histograms])
        self.assertTrue(self.client.doctor())
        self.assertIsInstance(self.client.dump(), dict)
        self.assertIn("[", self.client.configuration())

    def test_who_waits_for_ever_is_answered(self):
        with haptic.Client(timeout_s=math.inf) as patient:
            self.assertTrue(patient.devices())

    def test_records_a_stream_until_it_is_stopped(self):
        with self.client.record() as recording:
            stream, pieces = os.dup(recording.fileno()), []
            reader = threading.Thread(target=lambda: pieces.extend(iter(lambda: os.read(stream, 65536), b"")))
            reader.start()
            time.sleep(0.2)
            end = recording.stop()
            reader.join()
            os.close(stream)
        self.assertTrue(b"".join(pieces).startswith(b"HRBLOCK1"))
        self.assertGreater(end.cycles, 10)
        self.assertEqual((end.lost, end.reason), (0, "stopped"))

    def test_who_reads_no_recording_hears_of_it(self):
        n = 120  # Its snapshot is more than a socket holds.
        x, y = np.meshgrid(np.linspace(0, 0.1, n), np.linspace(0, 0.1, n))
        i = (np.arange(n - 1)[:, None] * n + np.arange(n - 1)).ravel()
        faces = np.concatenate([np.stack([i, i + 1, i + n], -1), np.stack([i + 1, i + n + 1, i + n], -1)])
        mesh = self.client.scene.upload(np.stack([x, y, 0 * x], -1).reshape(-1, 3), faces)
        with haptic.Client(timeout_s=20) as patient, patient.record() as recording:
            self.assertIn("stands still", recording.stop().reason)
        self.client.scene.drop_mesh(mesh.id)

    def test_history_is_a_numpy_array(self):
        with self.client.open_session() as session:
            self.assertTrue(eventually(lambda: session.counters().cycles > 100))
            session.drain()
            time.sleep(0.1)
            own = np.empty(64, haptic.SAMPLE)
            view = session.drain(own)
            self.assertTrue(np.shares_memory(view, own))
            self.assertGreater(len(view), 10)
            self.assertEqual(view["p"].shape, (len(view), 3))
            self.assertTrue((np.diff(view["tick"].astype(np.int64)) > 0).all())
            self.assertEqual(session.latest()["by_source"].shape, (8, 3))
            with self.assertRaises(ValueError):
                session.drain(np.empty(4))
        self.assertFalse(session.alive)

    def test_a_sphere_keeps_the_hand_out(self):
        with self.client.open_session() as session:
            session.arm()
            session.push_sphere((0, 0, -0.03), 0.02, material=haptic.Material(1000, 2), lease_s=5)
            session.push_intent((0, 0, -0.02), latest=True)
            self.assertTrue(eventually(lambda: session.latest()["by_source"][haptic.Source.LOCAL_MODEL][2] > 1))
            session.clear_model(0)
            self.assertTrue(eventually(lambda: session.latest()["by_source"][haptic.Source.LOCAL_MODEL][2] == 0))
            with self.assertRaises(haptic.HapticError) as caught:
                session.push_force((math.nan, 0, 0))
            self.assertEqual(caught.exception.code, haptic.Code.INVALID_ARGUMENT)

    def test_scene_and_meshes(self):
        scene = self.client.scene
        stages = []
        report = scene.upload(corners(0.01), FACES, progress=lambda fraction, stage: stages.append(stage))
        self.assertTrue(report.closed)
        self.assertEqual(report.triangles, 4)
        number = scene.create("tip", haptic.ShapeKind.MESH, mesh=report.id, pose=haptic.Pose((0, 0, -0.05)),
                              material=haptic.Material(500, 1, 0.5, 0.4))
        found = scene.find("tip")
        self.assertEqual((found.id, found.mesh, found.material.friction_static), (number, report.id, 0.5))
        self.client.set("/objects/tip/pos?value=0.01,0,-0.05")
        self.assertEqual(scene.find("tip").pose.p, (0.01, 0, -0.05))
        self.assertIn("tip", [state.name for state in scene.list()])
        scene.remove("tip")
        scene.drop_mesh(report.id)
        with self.assertRaises(haptic.HapticError) as caught:
            scene.find("tip")
        self.assertEqual(caught.exception.code, haptic.Code.NOT_FOUND)

    def test_effects(self):
        scene = self.client.scene
        scene.create("way")
        scene.set_effect("way", haptic.EffectKind.GUIDE, stiffness=800, force=4, path=[(0, 0, 0), (0.5, 0, 0.25)])
        said = {what: self.client.get(f"/objects/way/effect{what}") for what in
                ("", "_force", "_stiffness", "_damping", "_reach", "_path")}
        self.assertEqual(said, {"": "guide", "_force": 4, "_stiffness": 800, "_damping": 2, "_reach": 0.02,
                                "_path": [[0, 0, 0], [0.5, 0, 0.25]]})
        for wrong, word in (({"reach": 0}, "reach"), ({"force": math.nan}, "force"), ({"path": [(0, 0, 0)]}, "path"),
                            ({"duration_s": 1e9}, "duration")):
            with self.assertRaisesRegex(haptic.HapticError, word):
                scene.set_effect("way", haptic.EffectKind.FORCE, **wrong)
        for wrong in ({"kind": "guide"}, {"kind": 5, "path": [(0, 0)]}):
            with self.assertRaises(ValueError):
                scene.set_effect("way", **wrong)
        self.assertEqual(self.client.get("/objects/way/effect"), "guide")
        scene.remove("way")

    def test_surfaces_and_textures(self):
        scene = self.client.scene
        relief = scene.upload_relief(np.linspace(0, 1, 12).reshape(3, 4))
        self.assertEqual((relief.relief, relief.width, relief.height, relief.uses), (True, 4, 3, 0))
        models = [haptic.VibrationModel(v, f, 1.0, (-0.5, 0.1)) for v, f in ((0.01, 0.2), (0.2, 0.2), (0.01, 2.0))]
        vibration = scene.upload_vibration(10000, models, [[0, 1, 2]])
        self.assertEqual((vibration.relief, vibration.models, vibration.rate_hz), (False, 3, 10000))
        scene.create("wall", haptic.ShapeKind.PLANE, pose=haptic.Pose((0, 0, -0.05)))
        self.assertEqual(scene.find("wall").surface, haptic.Surface())
        surface = haptic.Surface(smooth_deg=40, transient_gain=15, relief=relief.id, vibration=vibration.id)
        scene.set_surface("wall", surface)
        self.assertEqual(scene.find("wall").surface, surface)
        self.assertEqual([entry.uses for entry in scene.textures()], [1, 1])
        with self.assertRaises(haptic.HapticError) as caught:
            scene.drop_texture(relief.id)
        self.assertIn("shown by 1", str(caught.exception))
        with self.assertRaises(haptic.HapticError) as caught:
            scene.set_surface("wall", haptic.Surface(transient_hz=1e4))
        self.assertIn("transientHz", str(caught.exception))
        with self.assertRaises(haptic.HapticError) as caught:
            scene.upload_vibration(10000, [models[0], models[1], haptic.VibrationModel(0.1, 1, 1, (0, 2))], [[0, 1, 2]])
        self.assertIn("model[2]", str(caught.exception))
        with self.assertRaises(ValueError):
            scene.upload_relief([[0.5, 1.5]])
        with self.assertRaises(haptic.HapticError) as caught:
            scene.upload_relief([[0.5]])
        self.assertIn("width", str(caught.exception))
        scene.remove("wall")
        scene.drop_texture(relief.id)
        scene.drop_texture(vibration.id)
        self.assertEqual(scene.textures(), [])

    def test_bad_meshes_and_errors_in_progress(self):
        with self.assertRaises(haptic.HapticError) as caught:
            self.client.scene.upload(np.eye(3), [[0, 1, 9]])
        self.assertEqual(caught.exception.code, haptic.Code.BAD_MESH)
        self.assertIn("triangle 0", str(caught.exception))
        with self.assertRaises(ValueError):
            self.client.scene.upload(np.eye(3), [[0, 1, -1]])

        def stumble(fraction, stage):
            time.sleep(0.1)  # So long that the mesh is built by then.
            raise LookupError(stage)
        for _ in range(3):
            with self.assertRaises(LookupError):
                self.client.scene.upload(np.eye(3), [[0, 1, 2]], progress=stumble)
        self.assertEqual(self.client.scene.meshes(), [])

    def test_reliefs_of_any_depth_are_the_same_picture(self):
        grey = np.array([[0, 51, 102], [153, 204, 255]], np.uint8)
        fine = grey.astype(np.uint16) * 257
        pictures = (grey, fine, fine.astype(">u2"), grey / 255, (grey / 255).astype(np.float32), (grey / 255).tolist())
        for picture in pictures:
            np.testing.assert_array_equal(arrays.pixels(picture, "grey"), fine)
        np.testing.assert_array_equal(arrays.pixels(np.array([[0, 1]], np.float16), "grey"), [[0, 65535]])
        np.testing.assert_array_equal(arrays.pixels(np.array([[False, True]]), "grey"), [[0, 65535]])
        np.testing.assert_array_equal(arrays.pixels(fine[:, ::-1], "grey"), fine[:, ::-1])
        for bad in ([0.5], [[0.5, float("nan")]], np.array([[0, 2]])):
            with self.assertRaisesRegex(ValueError, "^grey: "):
                arrays.pixels(bad, "grey")
        made = [self.client.scene.upload_relief(picture) for picture in pictures]
        self.assertEqual([(relief.width, relief.height) for relief in made], [(3, 2)] * len(pictures))
        for relief in made:
            self.client.scene.drop_texture(relief.id)

    def test_events_wake_a_select(self):
        with self.client.open_session() as session, self.client.subscribe(haptic.EventKind.ARMED) as events:
            self.assertEqual(select.select([events], [], [], 0)[0], [])
            session.arm()
            self.assertEqual(select.select([events], [], [], 10)[0], [events])
            self.assertEqual(events.next().name, "armed")
            self.assertEqual(select.select([events], [], [], 0)[0], [])

    def test_statistics_begin_anew(self):
        self.assertTrue(eventually(lambda: self.client.statistics().cycles > 50))
        with self.assertRaisesRegex(haptic.HapticError, "administration"):
            self.client.statistics(reset=True)
        socket = os.environ["HAPTICD_SOCKET"].replace("control", "admin")
        with haptic.Client(administration=True, socket=socket) as administrator:
            counted = administrator.statistics().histograms[0].count
            self.assertGreater(counted, 50)
            administrator.statistics(reset=True)
            self.assertLess(administrator.statistics().histograms[0].count, counted)

    def test_events_and_limits(self):
        with self.client.open_session() as session, self.client.subscribe(haptic.EventKind.FAULT) as events:
            self.assertIsNone(events.next(0))
            session.arm()
            self.client.stop()
            event = events.next(10)
            self.assertEqual((event.name, event.value), ("fault", 1))
            session.arm()
            later = threading.Timer(0.3, self.client.stop)
            later.start()
            self.assertEqual(events.next(-1).name, "fault")
            later.join()
            limits = self.client.set_limits(force=1.5)
            self.assertEqual(limits.force, 1.5)
            with self.assertRaises(TypeError):
                self.client.set_limits(fource=1)
            for named_by in (self.client.open_session, self.client.open_device, self.client.stop, self.client.record):
                with self.assertRaisesRegex(TypeError, "^a URI, name or serial is needed, not 0$"):
                    named_by(0)
        self.assertEqual(self.client.set_limits("sim"), limits)  # Who holds no lease may ask,
        with self.assertRaises(haptic.HapticError) as caught:
            self.client.set_limits("sim", force=1)  # and change nothing.
        self.assertEqual(caught.exception.code, haptic.Code.LEASE_REQUIRED)

    def test_an_empty_socket_is_no_search(self):
        with self.assertRaisesRegex(haptic.HapticError, "socket: is empty") as caught:
            haptic.Client(socket="")  # As of a variable that is not set; a search would find the daemon of this test.
        self.assertEqual(caught.exception.code, haptic.Code.INVALID_ARGUMENT)


if __name__ == "__main__":
    unittest.main()
