#!/usr/bin/python3
"""hapticctl against a real daemon with its simulator, and against none: what it prints, and how it ends.

Usage: hapticctl_test.py BUILD_DIRECTORY [unittest arguments]
"""
import csv
import io
import json
import math
import os
import signal
import subprocess
import time
import unittest

from daemon_case import HAPTICCTL, Case, eventually, png, stl


class WithoutDaemon(Case):
    wants_daemon = False

    def test_every_command_says_that_nobody_answers(self):
        path = self.file("t.stl", stl(["0 0 0", "2 0 0", "0 3 0", "0 0 5"]))
        for command in (["status"], ["list"], ["info"], ["top", "-b", "-n", "1"], ["monitor"], ["events"], ["arm"], ["disarm"],
                        ["stop"], ["limits"], ["load", path, "--scale", "mm"], ["add", "plane"], ["remove", "x"], ["objects"],
                        ["get", "/objects"], ["set", "/objects/x/pos?value=0,0,0"]):
            self.assertIn(str(self.socket), self.run_ctl(*command, exit_code=3).stderr)
        unknown = json.loads(self.run_ctl("--json", "--timeout", "1", "stauts", exit_code=2).stderr)
        self.assertEqual(unknown["error"]["where"], "stauts")
        for words in (["stauts", "--json"], ["top", "--json", "-n"], ["limits", "--json", "--force"]):
            self.assertIn("what", json.loads(self.run_ctl(*words, exit_code=2).stderr)["error"], "it stands behind the command, too")
        failure = json.loads(self.run_ctl("--json", "status", exit_code=3).stderr)
        self.assertEqual(failure["error"]["code"], "DISCONNECTED")

    def test_doctor_and_dump_work_without_one(self):
        self.assertIn("kernel preemption", self.run_ctl("doctor", exit_code=1).stdout)
        if os.geteuid() == 0:  # Who is root needs no group.
            stranger = ["setpriv", "--reuid", "65534", "--regid", "65534", "--clear-groups"]
            told = subprocess.run([*stranger, HAPTICCTL, "doctor"], capture_output=True, text=True, check=False).stdout
            self.assertRegex(told, r"RED +group haptic .*\n +(groupadd --system haptic && )?adduser nobody haptic")
            self.assertLess(told.index("group haptic"), told.index("@haptic - rtprio"), "there must be one to give it to")
        host = json.loads(self.run_ctl("dump", exit_code=3).stdout)["host"]
        self.assertTrue(all(check["remedy"] for check in host if check["state"] == "red"))

    def test_wrong_command_lines(self):
        for words, expected in ((["stauts"], "did you mean status?"), (["frobnicate"], "no such subcommand"), ([], "--help"),
                                (["load"], "FILE is required"), (["arm", "--for", "0"], "--for"), (["get", "objects"], "begins with '/'"),
                                (["get", "/a?value=1"], "hapticctl set"), (["set", "/a"], "write hapticctl set /a VALUE"), (["set", "/a=3"], "write hapticctl set /a 3"), (["--sockt", "x", "status"], "--sockt: no such option\n  did you mean --socket?"), (["set", "/a?value=1", "2"], "another behind it"), (["set", "/a", ""], "write '/a?value=' to set nothing"), (["add", "cone"], "no such shape"),
                                (["add", "sphere", "--size", "-1"], "at least 1e-06 m"),
                                (["add", "sphere", "--size", "1e-308"], "at least 1e-06 m"), (["arm", ""], "arm: what follows it is empty"), (["load", "", "--scale", "mm"], "load: what follows it is empty"),
                                (["add", "plane", "--parent", ""], "--parent: what follows it is empty"), (["--socket", ""], "is empty"), (["--socket=", "status"], "--socket: what follows it is empty"), (["add", "box", "--size=", "--name", "x"], "--size: what follows it is empty"), (["--socket=", "import", "x"], "--socket: what follows it is empty"), (["--socket", "/", "status"], "is a folder"),
                                (["--socket", "/" + 107 * "x", "status"], "at most 107 bytes"), (["add", "plane", "--at", "0,0"], "3 lengths"),
                                (["add", "plane", "--friction", "0.2,0.4"], "dynamic at most static"),
                                (["monitor", "--csv", "--json"], "--json"), (["events", "--kinds", "tuch"], "touch"),
                                (["add", "plane", "--stifness", "100"], "did you mean --stiffness?"), (["stop", "--al=1"], "not expected: --al=1"),
                                (["top"], "no terminal"), (["limits", "--force", "nan"], "not a finite number"),
                                (["load-texture", "x.png", "wall", "--size", "0.1,nan"], "--size: ")):
            if words and words[0] in ("events", "top"):
                continue  # These need a daemon first; see below.
            self.assertIn(expected, self.run_ctl(*words, exit_code=2).stderr)

    def test_files(self):
        good = self.file("good.stl", stl(["0 0 0", "2 0 0", "0 3 0", "0 0 5"]))
        message = self.run_ctl("load", good, exit_code=2).stderr
        for part in ("a scale is needed", "2 x 3 x 5 file units", "--scale mm", "--scale inch", "50.8 mm"):
            self.assertIn(part, message)
        self.run_ctl("load", good, "--scale", "0", exit_code=2)
        bad = self.file("nan.stl", stl(["nan 0 0", "2 0 0", "0 3 0", "0 0 5"]))
        points = self.file("p.ply", "ply\nformat ascii 1.0\nelement vertex 1\nproperty float x\nproperty float y\n"
                                    "property float z\nend_header\n0 0 0\n")
        for path, expected in ((self.directory / "none.stl", "no such file"), (bad, "triangle 0"),
                               (points, "no triangle")):
            done = self.run_ctl("load", path, "--scale", "mm", exit_code=5)
            self.assertIn(str(path), done.stderr)
            self.assertIn(expected, done.stderr)

    def test_a_file_that_keeps_its_reader_busy_is_given_up_at_a_signal(self):
        path, n = self.directory / "never.obj", 100_000  # One face that crosses itself everywhere.
        path.write_text("".join(f"v {i * 7919 % 100_003} {i * i * 31 % 100_003} 0\n" for i in range(n)) +
                        "f " + " ".join(map(str, range(1, n + 1))) + "\n")
        with subprocess.Popen([HAPTICCTL, "load", path, "--scale", "mm"], stderr=subprocess.PIPE, text=True) as load:
            time.sleep(0.5)
            load.terminate()
            try:
                self.assertIn("cancelled", load.communicate(timeout=300)[1])
            finally:
                load.kill()
            self.assertEqual(load.returncode, 1)

    def test_programs_become_commands(self):
        program = self.file("hapticctl-greet", "#!/bin/sh\necho hello \"$@\"\nexit 7\n")
        program.chmod(0o755)
        environment = {**os.environ, "PATH": f"{self.directory}:{os.environ['PATH']}"}
        done = subprocess.run([HAPTICCTL, "greet", "a b", "--flag"], capture_output=True, text=True, env=environment, check=False)
        self.assertEqual((done.returncode, done.stdout), (7, "hello a b --flag\n"))


class AnEditedConfiguration(Case):
    def test_doctor_says_that_it_is_not_in_force(self):
        def check():
            checks = json.loads(self.run_ctl("--json", "doctor", exit_code=1).stdout)["checks"]
            return next(one for one in checks if one["name"] == "configuration")
        file = self.directory / "hapticd.toml"
        self.assertEqual((check()["state"], check()["detail"]), ("green", str(file)))
        time.sleep(1.1)  # What is edited within a second of the start may have been read.
        file.write_text(file.read_text() + "# edited\n")
        self.assertEqual(check()["state"], "red")
        self.assertIn(f"hapticd --check-config --config {file}", check()["remedy"])


class WithDaemon(Case):
    def test_looking(self):
        self.assertIn("sim://default", self.run_ctl("list").stdout)
        self.assertIn("peak force", self.run_ctl("info", "sim").stdout)
        self.assertIn("DEVICE", self.run_ctl("status").stdout)
        status = self.json("status")
        self.assertEqual(status["devices"][0]["name"], self.json("list")[0]["name"])
        if not status["daemon"]["realtime"]:
            self.assertIn("NOT REAL-TIME", self.run_ctl("status").stdout)
        self.assertIn("no such device", self.run_ctl("info", "nobody", exit_code=1).stderr)
        checks = {check["name"]: check for check in json.loads(self.run_ctl("--json", "doctor", exit_code=1).stdout)["checks"]}
        self.assertIn("daemon", checks)
        self.assertEqual([name for name in checks if "real-time scheduling" in name or "RTPRIO" in name], ["daemon: real-time scheduling"])
        for mine in ("real-time priority", "locked memory", "CPU sleep states"):  # the daemon says its own: once is enough
            self.assertEqual(checks[mine]["state"], "not applicable")
        self.assertIn("devices", json.dumps(self.json("dump")["daemon"]))

    def test_top_in_batches(self):
        self.assertEqual(self.run_ctl("top", "-b", "-n", "010", "-d", "0.02").stdout.count("MISSES"), 10)
        screens = self.run_ctl("top", "-b", "-n", "2", "-d", "0.1").stdout
        self.assertEqual(screens.count("MISSES"), 2)
        lines = [json.loads(line) for line in self.run_ctl("--json", "top", "-n", "2", "-d", "0.2").stdout.splitlines()]
        self.assertGreater(lines[1]["statistics"][0]["cycles"], lines[0]["statistics"][0]["cycles"])
        self.assertEqual([lines[0]["statistics"][0]["collide_" + what] for what in ("queries", "exhausted", "unsent")], [0, 0, 0])
        self.assertNotIn("cut short", screens)
        self.assertIn("no terminal", self.run_ctl("top", exit_code=2).stderr)

    def test_monitor_writes_every_sample(self):
        done = self.run_ctl("monitor", "--csv", "--for", "0.5")
        rows = list(csv.DictReader(io.StringIO(done.stdout)))
        self.assertGreater(len(rows), 100)
        ticks = [int(row["tick"]) for row in rows]
        self.assertEqual(ticks, sorted(set(ticks)))
        # What is missing between ticks was missed by the servo, and not by monitor.
        self.assertEqual(ticks[-1] - ticks[0] + 1 - len(ticks), int(rows[-1]["missed"]) - int(rows[0]["missed"]), done.stderr)
        for row in rows[:: len(rows) // 10]:
            for axis in "xyz":
                shares = sum(float(row[f"{source}_{axis}"]) for source in
                             ("surface", "effect", "local_model", "client", "gravity", "guard"))
                self.assertAlmostEqual(shares, float(row[f"f{axis}"]), places=5)
        table = self.run_ctl("monitor", "--rate", "20", "--duration", "0.5").stdout.splitlines()
        self.assertTrue(5 <= len(table) - 1 <= 11, table)
        line = json.loads(self.run_ctl("--json", "monitor", "--rate", "10", "--duration", "0.2").stdout.splitlines()[0])
        self.assertEqual(len(line["p"]), 3)

    def test_counts_are_counts(self):
        for command in (["events"], ["top", "-b"]):
            for count in ("0", "-1", "nan"):  # -1 was 2^64 - 1, and 0 for ever.
                self.assertIn("--count: ", self.run_ctl(*command, "-n", count, exit_code=2).stderr)

    def test_volumes_that_are_not_kept(self):
        path = self.file("kept.stl", stl(["0 0 0", "2 0 0", "0 3 0", "0 0 5"]))
        self.run_ctl("load", path, "--scale", "mm", "--voxel", "0.5")
        self.assertIn("builder.cache", self.run_ctl("volumes").stderr)
        told = self.run_ctl("export", "kept", "x.vdb", exit_code=1).stderr
        for words in ("kept: volumes are not kept", "builder.cache in hapticd.toml"):
            self.assertIn(words, told)
        self.run_ctl("remove", "kept")

    def test_mistakes_are_told_in_the_words_of_the_command_line(self):
        path = self.file("word.stl", stl(["0 0 0", "2 0 0", "0 3 0", "0 0 5"]))
        self.run_ctl("load", path, "--scale", "mm")
        self.run_ctl("add", "box", "--size", "1cm,1cm,1cm", "--name", "crate")
        for command, expected in ((["load", path, "--scale", "mm"], ("--name", "'word'", "--replace")),
                                  (["add", "plane", "--name", "word"], ("--name", "'word'", "--replace")),
                                  (["add", "plane", "--name", "a b"], ("--name: byte 1",)),
                                  (["add", "plane", "--parent", "none"], ("--parent",)),
                                  (["add", "plane", "--at", "1000,0,0"], ("--at: 1000 is not within",)),
                                  (["add", "plane", "--friction", "9"], ("--friction: 9 is not between",)),
                                  (["load", path, "--scale", "30", "--name", "far"], (f"{path}: vertex", "check the scale")),
                                  (["export", "word", "x.vdb"], ("word: it has no volume", "--voxel")),
                                  (["export", "crate", "x.vdb"], ("crate: it is no mesh", "hapticctl load --voxel")),
                                  (["remove", "crat"], ("hapticctl: there is no object 'crat'", "nearest: crate")),
                                  (["arm", "simm"], ("simm", "number\n  hapticctl list shows them; a URI opens one, as sim://omega3\n")),
                                  (["info", "sim://falcon"], ("neither open nor found", "hapticctl monitor 'sim://falcon'"))):
            said = self.run_ctl(*command, exit_code=1).stderr
            for words in expected:
                self.assertIn(words, said, command)
        self.assertEqual(json.loads(self.run_ctl("--json", "remove", "crat", exit_code=1).stderr)["error"]["where"], "name")
        self.assertIn("make its folder first", self.run_ctl("record", "/nowhere/x.hrec", exit_code=5).stderr)
        self.run_ctl("remove", "word", "crate")

    def test_lengths_have_units(self):
        made = self.run_ctl("add", "sphere", "--size", "10mm", "--at", "-30cm,0,10in", "--name", "bead")
        self.assertEqual(made.stderr, "")
        self.assertIn("bead: sphere of radius 10.0 mm, ", made.stdout)
        self.assertEqual(self.json("get", "/objects/bead/shape")["radius"], 0.01)
        self.assertEqual(self.json("get", "/objects/bead/pos"), [-0.3, 0, 0.254])
        # A bare number is metres, as everywhere, and who meant another unit is told.
        made = self.run_ctl("add", "cylinder", "--size", "10,0.02", "--at", "0,0,-0.9", "--name", "tower")
        self.assertIn("tower: cylinder of radius 10.0 m, half length 20.0 mm, ", made.stdout)
        self.assertIn("--size: 10 without a unit is 10.0 m; write 10mm or 10m", made.stderr)
        self.run_ctl("remove", "bead", "tower")

    def test_a_name_has_one_greatest_length(self):
        for length in (64, 65):
            self.assertIn("63 is the most", self.run_ctl("add", "sphere", "--size", "0.01", "--name", length * "a", exit_code=1).stderr)

    def test_what_cannot_take_a_place_leaves_it_as_it_was(self):
        self.run_ctl("add", "group", "--name", "frame", "--at", "0,0,1")
        self.run_ctl("add", "sphere", "--size", "0.01", "--name", "ball", "--at", "0.3,0,0", "--mass", "0.2")
        before = self.json("get", "/objects/ball")
        for words, expected in ((["--at", "1000,0,0"], "--at: 1000 is not within"), (["--stiffness", "1e9"], "--stiffness: "),
                                (["--mass", "0.001"], "is not between"), (["--parent", "frame"], "--parent: 'ball' hangs on no object")):
            self.assertIn(expected, self.run_ctl("add", "box", "--size", "0.5,0.5,0.5", "--name", "ball", "--replace", *words, exit_code=1).stderr)
            self.assertEqual(self.json("get", "/objects/ball"), before, words)
        self.assertIn("plane", self.run_ctl("add", "plane", "--name", "ball", "--replace", "--mass", "1", exit_code=1).stderr)
        self.assertEqual(self.json("get", "/objects/ball"), before)
        self.run_ctl("add", "plane", "--name", "ball", "--replace")
        self.assertEqual(self.json("get", "/objects/ball/shape"), {"kind": "plane"})
        self.run_ctl("remove", "ball", "frame")

    def test_scene(self):
        path = self.file("t.stl", stl(["0 0 0", "20 0 0", "0 30 0", "0 0 50"]))
        loaded = self.json("load", path, "--scale", "mm", "--name", "tetra", "--at", "0,0,-0.05", "--friction", "0.4,0.3")
        self.assertEqual((loaded["vertices"], loaded["triangles"], loaded["closed"]), (4, 4, True))
        self.assertIn("ALREADY_EXISTS", self.run_ctl("--json", "load", path, "--scale", "mm", "--name", "tetra", exit_code=1).stderr)
        self.assertIn("too large", self.run_ctl("load", path, "--scale", "mm", "--weld", "11", exit_code=2).stderr)
        self.assertIn("too small", self.run_ctl("load", path, "--scale", "mm", "--weld", "0.0001", exit_code=2).stderr)
        gone = self.run_ctl("load", path, "--size", "0.005", "--weld", "10", "--name", "gone", exit_code=1).stderr
        self.assertIn("no triangle has an area", gone)  # 5 mm long, all within 10
        solid = self.json("load", path, "--scale", "mm", "--voxel", "0.1cm", "--points", "2mm", "--name", "solid", "--at", "0,0,0.2")
        self.assertTrue(any(note.startswith("volume: voxels of 1 mm") for note in solid["notes"]), solid["notes"])
        self.assertAlmostEqual(self.json("get", f"/meshes/{solid['mesh']}")["voxel"], 0.001)
        self.assertIn("MB to build", self.run_ctl("load", path, "--scale", "mm", "--voxel", "0.002", exit_code=1).stderr)
        whole = stl(["0 0 0", "20 0 0", "0 30 0", "0 0 50"])
        hole = self.file("hole.stl", whole[:whole.rindex("facet normal")] + "endsolid t\n")
        refused = self.run_ctl("load", hole, "--scale", "mm", "--voxel", "1", "--name", "hole", exit_code=1).stderr
        self.assertIn("--fill-holes", refused)
        filled = self.json("load", hole, "--scale", "mm", "--voxel", "1", "--fill-holes", "--name", "hole", "--at", "0,0,0.3")
        self.assertTrue(any(note.startswith("holes: closed") for note in filled["notes"]), filled["notes"])
        self.assertFalse(filled["closed"])
        self.run_ctl("remove", "hole")
        self.run_ctl("remove", "solid")
        again = self.json("load", path, "--size", "0.1", "--name", "tetra", "--replace", "--rotate", "z,90")
        self.assertEqual(again["object"], loaded["object"])
        self.assertAlmostEqual(again["upper"][2], 0.1, places=6)
        self.run_ctl("add", "box", "--size", "0.01,0.02,0.03", "--name", "crate", "--parent", "tetra", "--at", "0,0,-0.2")
        objects = {o["name"]: o for o in self.json("objects")}
        self.assertEqual(objects["crate"]["path"], "/_objects/tetra/crate")
        self.assertEqual(objects["crate"]["size"], [0.01, 0.02, 0.03])
        self.assertAlmostEqual(objects["tetra"]["pose"]["q"][3], math.sqrt(0.5))
        self.assertEqual(self.json("set", "/objects/crate/pos?value=0,0.25,0"), [0, 0.25, 0])
        self.assertEqual(self.json("set", "/objects/crate/pos", "0,-0.25,0"), [0, -0.25, 0])
        self.assertEqual(self.json("set", "/objects/crate/pos", "-0.1", "0.2", "-0.3"), [-0.1, 0.2, -0.3])
        for words in (["0.1 0.2 -0.3"], [" 0.1, 0.2 ,\t-0.3 "], ["0.1  0.2", "-0.3"], ["0.1,", "0.2,-0.3"]):
            self.assertEqual(self.json("set", "/objects/crate/pos", *words), [0.1, 0.2, -0.3], words)
        for words in (["0.1,,0.2"], ["1 2"], [" "]):
            self.run_ctl("set", "/objects/crate/pos", *words, exit_code=1)
        self.assertIn("stiffness: '50%' is not", self.run_ctl("set", "/objects/crate/stiffness", "50%", exit_code=1).stderr)
        for name, value, how in (("pos", "20mm,0,0", "x,y,z in metres"), ("rot", "0,0,30", "w,x,y,z of a quaternion"),
                                 ("pose", "0,0,0", "then w,x,y,z of a quaternion"), ("velocity", "1", "metres a second"),
                                 ("material", "800", "N/m, N s/m, static and dynamic friction"),
                                 ("relief", "weave.png", "hapticctl load-texture"),
                                 ("effect", "guide,path=0,0", "2 numbers are not three for each of 2 to 32 points"),
                                 ("friction", "0.3", "there is friction_dynamic, friction_static, ")):
            self.assertIn(how, self.run_ctl("set", f"/objects/crate/{name}", value, exit_code=1).stderr)
        self.json("set", "/objects/crate/pos", "0", "0.25", "0")
        self.assertEqual(self.json("get", "/objects/crate/pos"), [0, 0.25, 0])
        self.assertEqual(self.json("set", "/objects/crate/velocity", "0.05", "0", "0"), [0.05, 0, 0])
        self.assertEqual(self.json("set", "/objects/crate/pos", "0", "0.25", "0"), [0, 0.25, 0])
        self.assertEqual(self.json("get", "/objects/crate/velocity"), [0, 0, 0])  # So says docs/scenes.md.
        self.assertIn("/objects/nobody", self.run_ctl("get", "/objects/nobody/pos", exit_code=1).stderr)
        self.assertIn("nobody", self.run_ctl("remove", "tetra", "nobody", exit_code=1).stderr)
        self.assertEqual(len(self.json("objects")), 2, "none goes where one is not there")
        self.run_ctl("remove", "tetra", "crate", "crate")
        self.assertEqual(self.json("objects"), [], "a child goes with its parent")
        self.assertIn("tetra", self.run_ctl("remove", "tetra", exit_code=1).stderr)
        self.assertIn("--name", self.run_ctl("add", "plane", "--name", "", exit_code=2).stderr)

    def test_textures(self):
        self.run_ctl("add", "plane", "--name", "wall")
        picture = self.directory / "ramp.png"
        picture.write_bytes(png(8, 4, lambda x, y: 30 * x))
        laid = self.json("load-texture", picture, "wall", "--depth", "0.001", "--size", "0.08,0.04")
        self.assertEqual(laid["kind"], "relief")
        self.assertEqual(self.json("get", "/objects/wall/relief"), laid["texture"])
        self.assertEqual(self.json("get", "/objects/wall/relief_depth"), 0.001)
        shown = self.json("get", f"/textures/{laid['texture']}")
        self.assertEqual((shown["width"], shown["height"], shown["uses"]), (8, 4, 1))
        steep = self.run_ctl("load-texture", picture, "wall", "--size", "0.0001,0.04", exit_code=1).stderr
        self.assertIn("pixel", steep)
        self.assertIn("--depth: ", self.run_ctl("load-texture", picture, "wall", "--depth", "9", exit_code=1).stderr)
        self.assertEqual(self.json("get", "/objects/wall/relief"), laid["texture"], "a refusal changes nothing")
        self.assertEqual(len(self.json("get", "/textures")), 1, "nor does it leave anything behind")
        lines = "<ARlsf><value>0.4</value><value>1.3</value></ARlsf><var>1</var>"
        models = "".join(f"<model>{lines}<speedMod>{v}</speedMod><forceMod>{f}</forceMod></model>"
                         for v, f in ((10, 0.2), (200, 0.2), (10, 2)))
        triangle = "<tri><value>1</value><value>2</value><value>3</value></tri>"
        toolkit = self.file("cloth.xml", f"<modelSet>{triangle}{models}</modelSet>")
        self.assertIn("vibration of 3 models", self.run_ctl("load-texture", toolkit, "wall", "--mass", "0.02").stdout)
        self.assertEqual(self.json("get", "/objects/wall/vibration_mass"), 0.02)
        rubs = self.file("CLOTH.XML", f"<modelSet><mu>0.35</mu>{triangle}{models}</modelSet>")
        self.assertIn("recorded at friction 0.35", self.run_ctl("load-texture", rubs, "wall").stdout)
        self.assertEqual(self.json("load-texture", rubs, "wall")["friction"], 0.35)
        self.assertIn("tri[1]", self.run_ctl("load-texture", self.file("bad.xml", f"<modelSet>{models}<tri/></modelSet>"),
                                             "wall", exit_code=5).stderr)
        self.assertIn("--depth", self.run_ctl("load-texture", toolkit, "wall", "--depth", "1", exit_code=2).stderr)
        self.assertEqual(self.json("set", "/objects/wall/transient_gain?value=20"), 20)
        self.assertIn("transientHz", self.run_ctl("set", "/objects/wall/transient_hz?value=1000", exit_code=1).stderr)
        self.assertIn("not the number", self.run_ctl("set", "/objects/wall/relief?value=1.5", exit_code=1).stderr)
        self.run_ctl("remove", "wall")
        self.assertEqual(self.json("get", "/textures"), {}, "textures go with the last surface that shows them")

    def test_what_is_read_reads_well(self):
        device = self.run_ctl("get", "/devices/sim").stdout
        self.assertRegex(device, r'\n  "pos": \[[^\n]+\],\n')
        self.assertRegex(device, r'\n  "by_source": {\n    "client": \[[^\n]+\],\n')
        self.assertEqual(json.loads(device)["by_source"]["client"], [0, 0, 0])
        self.assertIn("\n[servo]\n", self.run_ctl("get", "/config").stdout)
        self.assertIn("\n[servo]\n", self.json("get", "/config"))
        self.assertIn('"sim://default"', self.run_ctl("get", "/devices/sim/uri").stdout)

    def test_help_of_a_command_names_the_options_that_all_take_and_no_more(self):
        for command in (["arm"], ["tool", "attach"]):
            text = self.run_ctl(*command, "--help").stdout
            self.assertIn("--timeout SECONDS", text)
            self.assertNotIn("hapticctl-NAME", text)
        self.assertIn("hapticctl-NAME", self.run_ctl("--help").stdout)

    def test_arming_ends_in_order(self):
        arm = subprocess.Popen([HAPTICCTL, "--socket", self.socket, "arm"], stdout=subprocess.PIPE, text=True)
        try:
            self.assertIn("ramping", arm.stdout.readline())
            self.assertTrue(self.json("status")["devices"][0]["armed"])
            self.assertIn("stop", self.run_ctl("disarm", exit_code=1).stderr)
            arm.send_signal(signal.SIGTERM)
            self.assertIn("disarmed", arm.communicate(timeout=300)[0])
            self.assertEqual(arm.returncode, 0)
        finally:
            arm.kill()
            arm.wait()
            arm.stdout.close()
        self.assertFalse(self.json("status")["devices"][0]["armed"])
        self.run_ctl("arm", "--for", "0.2")

    def test_arming_within_an_object_says_that_it_waits(self):
        def start(*words):
            program = subprocess.Popen([HAPTICCTL, "--socket", self.socket, *words], stdout=subprocess.PIPE, stderr=subprocess.DEVNULL, text=True)
            self.addCleanup(lambda: (program.terminate(), program.communicate()))
            return program

        self.run_ctl("add", "box", "--size", "0.02,0.02,0.01", "--at", "0.2,0,0", "--name", "plate")
        self.addCleanup(self.run_ctl, "remove", "plate")
        start("hand", self.file("press.csv", "t,x,y,z\n0,0,0,0.03\n1,0,0,0.03\n1.5,0,0,0\n60,0,0,0\n"))
        self.assertTrue(eventually(lambda: self.json("get", "/devices/sim/pos")[2] > 0.02))
        self.run_ctl("set", "/objects/plate/pos?value=0,0,0")
        self.assertTrue(eventually(lambda: self.json("get", "/devices/sim/depth") > 0.005))
        arm = start("arm")
        self.assertIn("waiting", arm.stdout.readline())
        self.assertIs(self.json("get", "/devices/sim/waiting"), True)
        self.assertEqual(self.json("get", "/devices/sim/force"), [0, 0, 0])
        self.assertIn(" waiting ", self.run_ctl("monitor", "--duration", "0.3").stdout)
        self.run_ctl("set", "/objects/plate/enabled?value=false")
        self.assertIn("ramping", arm.stdout.readline())

    def test_a_client_that_hangs_is_seen(self):
        with subprocess.Popen([HAPTICCTL, "--socket", self.socket, "arm"], stdout=subprocess.PIPE, text=True) as arm:
            try:
                arm.stdout.readline()
                of_arm = lambda: next(line for line in self.run_ctl("status").stdout.splitlines() if f" {arm.pid}  sim " in line)
                self.assertNotIn("silent", of_arm())
                arm.send_signal(signal.SIGSTOP)
                self.assertTrue(eventually(lambda: "silent for" in of_arm()), of_arm())
                self.assertIn("yes", of_arm(), "it has the lease still")
                arm.send_signal(signal.SIGCONT)
                self.assertTrue(eventually(lambda: "silent" not in of_arm()), of_arm())
            finally:
                arm.send_signal(signal.SIGCONT)
                arm.send_signal(signal.SIGINT)

    def test_stop_ends_arming_with_a_fault(self):
        # Also where variables of a script are not set.
        for words in (["stop"], ["--socket", "", "stop", ""], ["--socket=", "stop"], ["stop", "--socket="]):
            with subprocess.Popen([HAPTICCTL, "--socket", self.socket, "arm"], stdout=subprocess.PIPE, stderr=subprocess.PIPE, text=True) as arm:
                arm.stdout.readline()
                try:
                    self.run_ctl(*words)
                    self.assertIn("fault", arm.communicate(timeout=300)[1])
                finally:
                    arm.kill()
                self.assertEqual(arm.returncode, 1)
        self.run_ctl("arm", "--for", "0.2")  # Arming again clears it.

    def test_an_emergency_stop_has_one_name(self):
        with subprocess.Popen([HAPTICCTL, "--socket", self.socket, "events", "--kinds", "fault", "-n", "1"],
                              stdout=subprocess.PIPE, text=True) as events:
            time.sleep(0.5)
            self.run_ctl("stop")
            told = events.communicate(timeout=300)[0]
        self.assertEqual(told.count("emergency stop"), 1, told)
        self.assertNotIn("line", told)
        for shown in (self.run_ctl("status").stdout, self.run_ctl("monitor", "--duration", "0.2").stdout,
                      self.run_ctl("get", "/devices/sim/fault").stdout):
            self.assertIn("emergency stop", shown)
        self.run_ctl("arm", "--for", "0.2")

    def test_limits(self):
        before = self.json("limits")
        refused = self.run_ctl("limits", "--force", str(before["force"] / 2), exit_code=1).stderr
        self.assertIn("--admin", refused)
        admin = self.directory / "admin.sock"
        lowered = json.loads(self.run_ctl("--json", "--admin", "--socket", admin, "limits", "--force", str(before["force"] / 2)).stdout)
        self.assertEqual(lowered["force"], before["force"] / 2)
        self.assertEqual({**lowered, "force": before["force"]}, before)
        self.run_ctl("--admin", "--socket", admin, "limits", "--force", str(before["force"]))

    def test_events(self):
        with subprocess.Popen([HAPTICCTL, "--socket", self.socket, "--json", "events", "--kinds", "armed,disarmed", "-n", "2"],
                              stdout=subprocess.PIPE, text=True) as events:
            time.sleep(0.5)
            self.run_ctl("arm", "--for", "0.3")
            kinds = [json.loads(line)["kind"] for line in events.communicate(timeout=300)[0].splitlines()]
        self.assertEqual(kinds, ["armed", "disarmed"])
        self.assertIn("did you mean touch?", self.run_ctl("events", "--kinds", "tuch", exit_code=2).stderr)

    def test_events_end_with_their_reader(self):
        with subprocess.Popen([HAPTICCTL, "--socket", self.socket, "events", "--kinds", "fault"],
                              stdout=subprocess.PIPE) as events:
            time.sleep(0.3)
            events.stdout.close()
            try:
                self.assertEqual(events.wait(60), 0)  # Although no event comes that it could write.
            finally:
                events.kill()

    def test_hand_follows_the_file(self):
        rows = "".join(f"{i / 10},0.0{i},0,0\n" for i in range(5))
        self.run_ctl("hand", self.file("path.csv", "t,x,y,z\n" + rows))
        time.sleep(0.5)
        self.assertAlmostEqual(self.json("status")["devices"][0]["pose"]["p"][0], 0.04, delta=0.002)
        self.assertIn("bad.csv:2", self.run_ctl("hand", self.file("bad.csv", "t,x,y,z\n0,a,0,0\n"), exit_code=5).stderr)
        for device, why in (("sim://default?motion=circle&serial=own", "motion of its own"),
                            (f"replay://{self.directory / 'path.csv'}", "not simulated")):
            self.assertIn(why, self.run_ctl("hand", self.directory / "path.csv", device, exit_code=1).stderr)

    def test_a_reader_that_leaves_is_no_error(self):
        with subprocess.Popen([HAPTICCTL, "--socket", self.socket, "monitor", "--csv"], stdout=subprocess.PIPE, stderr=subprocess.PIPE) as monitor:
            monitor.stdout.readline()
            monitor.stdout.close()
            self.assertEqual(monitor.wait(60), 0)
            self.assertEqual(monitor.stderr.read(), b"")


class Tool(Case):
    def test_a_tool_that_is_asked_for_wrongly_names_the_word(self):
        self.run_ctl("add", "box", "--size", "0.01,0.01,0.01", "--at", "0,0,0.2", "--name", "stick")
        for value, wrong in (("stick,0.1,0,weighs,foo", "'foo'"), ("stick,,", "''"), ("stick,weighs,0.1", "'0.1'"), ("stick,0.1,0,5", "'5'")):
            self.assertIn(wrong, self.run_ctl("set", f"/devices/sim/tool?value={value}", exit_code=1).stderr)
        self.assertIsNone(self.json("get", "/devices/sim/tool"))
        held = self.json("set", "/devices/sim/tool?value=stick,0.2,200,direct,weighs")
        self.assertEqual((held["mass"], held["rendering"], held["weight"]), (0.2, "direct", "felt"))
        self.assertIn("detach it there first", self.run_ctl("set", "/objects/stick/pos", "0.1,0,0", exit_code=1).stderr)
        self.run_ctl("add", "sphere", "--size", "0.01", "--name", "stick", "--replace")  # In the hand, too.
        self.assertEqual(self.json("get", "/objects/stick/shape")["kind"], "sphere")
        self.run_ctl("tool", "detach")
        self.assertIn("tool attach --help", self.run_ctl("tool", "attach", "stick", "--mass", "100", exit_code=2).stderr)
        self.run_ctl("remove", "stick")


class DaemonDies(Case):
    def test_monitor_ends_where_the_servo_stands(self):
        command = [HAPTICCTL, "--socket", self.socket, "monitor", "--duration", "1"]
        with subprocess.Popen(command, stdout=subprocess.PIPE, stderr=subprocess.PIPE, text=True) as monitor:
            monitor.stdout.readline()
            monitor.stdout.readline()
            self.daemon.process.send_signal(signal.SIGSTOP)
            try:
                self.assertIn("does the servo stand?", monitor.communicate(timeout=300)[1])
            finally:
                self.daemon.process.send_signal(signal.SIGCONT)
                monitor.kill()
            self.assertEqual(monitor.returncode, 0)

    def test_monitor_tells(self):
        with subprocess.Popen([HAPTICCTL, "--socket", self.socket, "monitor"], stdout=subprocess.PIPE, stderr=subprocess.PIPE, text=True) as monitor:
            monitor.stdout.readline()
            self.daemon.kill()
            self.assertNotEqual(monitor.communicate(timeout=300)[1], "")
            self.assertEqual(monitor.returncode, 4)


if __name__ == "__main__":
    unittest.main()
