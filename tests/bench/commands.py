#!/usr/bin/python3
"""The commands of haptic-bench as a user types them: results, files, faults and exit codes. Usage: commands.py HAPTIC_BENCH"""
import csv
import os
import pathlib
import signal
import subprocess
import time
import unittest

from bench_case import PROGRAM, BenchCase

# From its 151st step on its force is no number. It says when it starts.
LATE = """
#include <stdio.h>
#include "haptic_algorithm.h"
static int steps;
static void* create(const haptic_algorithm_problem* p, char* e, size_t n) { return (void)p, (void)e, (void)n, &steps; }
static void destroy(void* i) { (void)i; }
static void start(void* i, const double h[3]) { (void)i, (void)h, fputs("it starts\\n", stderr); }
static void step(void* i, const double h[3], const double v[3], double dt, haptic_algorithm_contact* contact) {
  (void)i, (void)h, (void)v, (void)dt;
  if (++steps > 150) contact->force[0] = 0.0 / 0.0;
}
const haptic_algorithm* haptic_algorithm_table(void) {
  static const haptic_algorithm table = {1, sizeof table, "late", 0, create, destroy, start, step, 0};
  return &table;
}
"""

# At its 51st step, or when it is loaded or made, it does what its options say.
WRONG = """
#include <cstdio>
#include <cstdlib>
#include <cstring>
#include <stdexcept>
#include "haptic_algorithm.h"
static char how[32];
static int steps;
static int deep(volatile int* x) { volatile int y[1000]; y[0] = *x; return deep(y) + y[0]; }
static void fail() {
  static volatile int zero = 0;
  if (!std::strcmp(how, "crash")) *(volatile int*)nullptr = 1;
  if (!std::strcmp(how, "divide")) zero = 7 / zero;
  if (!std::strcmp(how, "deep")) zero = deep(&zero);
  if (!std::strcmp(how, "abort")) std::abort();
  if (!std::strcmp(how, "exit")) std::exit(0);
  if (!std::strcmp(how, "throw")) throw std::runtime_error("no luck");
  if (!std::strcmp(how, "throw a number")) throw 7;
}
static void* create(const haptic_algorithm_problem* p, char*, size_t) {
  const bool now = !std::strncmp(p->options, "create ", 7);
  std::strcpy(how, p->options + (now ? 7 : 0));
  if (now) fail();
  return &steps;
}
static void destroy(void*) {}
static void start(void*, const double*) { std::fprintf(stderr, "%s starts\\n", how); }
static void step(void*, const double*, const double*, double, haptic_algorithm_contact*) { if (++steps == 51) fail(); }
extern "C" const haptic_algorithm* haptic_algorithm_table(void) {
  static const haptic_algorithm table = {1, sizeof table, "wrong", 0, create, destroy, start, step, 0};
  return &table;
}
"""


class Commands(BenchCase):
    def test_samples_are_a_trajectory_again(self):
        samples = self.folder / "samples.csv"
        first = self.results("run", "-a", "nearest", "-m", "sphere:stacks=8", "-t", "spiral:seconds=1", "--rounds", 1, "--samples",
                             samples)
        again = self.results("run", "-a", "nearest", "-m", "sphere:stacks=8", "-t", samples, "--rounds", 1)
        self.assertAlmostEqual(first["nearest force MSE"][0], again["nearest force MSE"][0], delta=1e-15)
        self.assertEqual(first["nearest forces"], again["nearest forces"])

    def test_times_of_samples_are_those_that_are_summed_up(self):
        samples = self.folder / "samples.csv"
        values = self.results("run", "-a", "ours", "-m", "plane", "-t", "lissajous:seconds=0.5", "--rounds", 2, "--samples", samples)
        with open(samples, encoding="ascii", newline="") as file:
            times = sorted(float(row["ours_step_ns"]) for row in csv.DictReader(file))
        self.assertEqual(len(times), 500)
        self.assertAlmostEqual(values["ours mean"][0], sum(times) / 500, delta=1e-6)
        for quantity, rank in (("median", 250), ("p99", 495), ("p99.9", 500), ("max", 500)):
            self.assertEqual(values[f"ours {quantity}"][0], times[rank - 1])

    def test_samples_of_algorithms_with_settings_keep_their_columns(self):
        samples = self.folder / "samples.csv"
        self.bench("run", "-a", "local:rate=30,latency=0.01", "ours", "-m", "plane", "-t", "lissajous:seconds=0.1", "--rounds", 1,
                   "--samples", samples)
        with open(samples, encoding="ascii", newline="") as file:
            rows = list(csv.DictReader(file))
        self.assertEqual(len(rows), 100)
        self.assertEqual(float(rows[50]["ours_fz"]), 1)
        self.assertAlmostEqual(float(rows[50]["local:rate=30,latency=0.01_fz"]), 1)
        again = self.results("run", "-a", "ours", "-m", "plane", "-t", samples, "--rounds", 1)
        self.assertLess(again["ours force MSE"][0], 1e-20)

    def test_a_file_of_samples_is_there_whole_or_not_at_all(self):
        nowhere = self.folder / "none" / "samples.csv"
        self.assertIn("cannot be written", self.bench("run", "--rounds", 10000, "--samples", nowhere, code=1))  # At once.
        kept = self.folder / "kept.csv"
        kept.write_text("mine", encoding="ascii")
        self.bench("run", "-a", "theirs", "--samples", kept, code=1)
        self.assertEqual([path.name for path in self.folder.iterdir()], ["kept.csv"])
        self.assertEqual(kept.read_text(encoding="ascii"), "mine")
        link = self.folder / "link.csv"
        link.symlink_to(kept)
        self.bench("run", "-a", "ours", "-t", "spiral:seconds=0.01", "--rounds", 1, "--samples", link)
        self.assertIn("ours_fx", kept.read_text(encoding="ascii"))
        self.assertTrue(link.is_symlink())
        self.assertIn("ours_fx", self.bench("run", "-a", "ours", "--rounds", 1, "--samples", "/dev/stdout"))

    def test_what_is_read_is_not_written_over(self):
        way, cost = self.folder / "way.csv", self.folder / "cost.csv"
        for file, text in ((way, "t,x,y,z\n0,0,0,0.001\n0.001,0,0,0.001\n"), (cost, "benchmark,quantity,unit,round,value\ncost,a,ns,1,2\n")):
            file.write_text(text, encoding="ascii")
        link = self.folder / "link.csv"
        link.symlink_to(way)
        for samples in (way, link):
            for inputs in (("-m", "plane", "-t", way), ("-m", f"{way}:center=1"), ("-t", f"measured:forces={way},poses=p.csv"),
                           ("-t", f"measured:forces=f.csv,poses={way}")):
                said = self.bench("run", "-a", "ours", *inputs, "--rounds", 1, "--samples", samples, code=1)
                self.assertIn(f"{samples}: it is what is read, and would be lost (another name)", said)
        self.assertTrue(way.read_text(encoding="ascii").startswith("t,x,y,z\n0,0,0,0.001\n"))
        # Most likely results were to be shown.
        self.assertIn("cost.csv: it is there and is no page (another name; --with shows results)", self.bench("report", cost, code=1))
        self.assertTrue(cost.read_text(encoding="ascii").startswith("benchmark,"))

    def test_it_says_which_version_it_is(self):
        self.assertRegex(self.bench("--version"), r"^haptic-bench \d+\.\d+\.\d+\n$")

    def test_a_profile_has_its_columns_names_once(self):
        profile = self.folder / "profile.csv"
        for ticks in (200, 400):
            self.bench("cost", "--triangles", 1000, "--radius", 0, "--seconds", 0.1, "--rounds", 1, "--profile", profile)
            with open(profile, encoding="ascii", newline="") as file:
                rows = list(csv.DictReader(file))
            self.assertEqual(list(rows[0]), ["triangles", "radius_mm", "tick", "time_ns", "sweeps", "visited", "gathered"])
            self.assertEqual([float(row["triangles"]) for row in rows], [1152] * len(rows))
            self.assertEqual(len(rows), ticks // 2)

    def test_cost_is_compared(self):
        cost = ("cost", "--triangles", 1000, 1100, "--radius", 0, 0, "--seconds", 0.1, "--csv", "--rounds")
        files = [self.folder / f"{name}.csv" for name in ("one", "many", "again", "fast", "counted")]
        for file, rounds, more in zip(files, (1, 6, 6, 6), ((), (), (), ("--speed", 0.2))):
            file.write_text(self.bench(*cost, rounds, *more), encoding="ascii")
        one, many, again, fast, counted = files
        with open(many, encoding="ascii", newline="") as file:
            rows = list(csv.DictReader(line for line in file if not line.startswith("#")))
        self.assertEqual({row["benchmark"] for row in rows}, {"cost 1152 triangles 0.1 m/s 0.1 s"})
        rounds = {row["quantity"]: int(row["round"]) for row in rows}
        self.assertEqual({rounds[f"{what} {figure}"] for what in ("tick 0 mm", "servo 0 mm", "sweep 0 mm", "nearest")
                          for figure in ("median", "mean", "p99", "p99.9", "max")}, {6})
        self.assertEqual((rounds["build"], rounds["pointer chase"], rounds["snapshot"]), (6, 6, 1))
        # Counts are the same in any two runs, and judged without regard to the machine; times of one round are not judged.
        self.assertEqual(self.bench("compare", "--errors", many, again), "0 of 6 quantities worse or missing\n")
        self.assertRegex(self.bench("compare", one, one), "# 21 not judged: times of fewer than 6 rounds.*\n0 of 7 quantities")
        text = many.read_text(encoding="ascii")
        mean = next(row["value"] for row in rows if row["quantity"] == "tick 0 mm nodes and triangles, mean")
        counted.write_text(text.replace(mean, str(float(mean) * 1.001)), encoding="ascii")
        said = subprocess.run([PROGRAM, "compare", "--errors", many, counted], capture_output=True, text=True, check=False)
        self.assertEqual(said.returncode, 1)
        self.assertRegex(said.stdout, "^worse    cost 1152 .*, tick 0 mm nodes and triangles, mean: .* a tick\n1 of 6")
        # Another stroke is another benchmark.
        self.assertRegex(self.bench("compare", many, fast, code=1), r"fast\.csv, line \d+: it holds \"cost .* 0\.2 m/s .* nothing of what")

    def test_tables_are_compared(self):
        # Each as the program prints it; what changes in one cell is named with its row and its unit.
        for command, column, factor, words in (
                ("zwidth --quick --rate 1000 --delay 0 --damping 0 5".split(), "off", 0.5, r"zwidth rate_hz=1000 .* damping=0, off: .* N/m"),
                (["sixdof"], "torque_rms_nm", 1.01, "sixdof case=box on floor response=constraint rate_hz=1000, torque_rms_nm: .* N m"),
                (["stability", "--quick", "--pair", "peg in hole"], "strongest_n", 2, "stability pair=peg in hole .*, strongest_n: .* N"),
                ("collide --quick --no-peers --pair peg --truths 1".split(), "records", 0.5, "collide pair=peg .*, records: .* records")):
            first, second = self.folder / "first.csv", self.folder / "second.csv"
            first.write_text(self.bench(*command, "--csv"), encoding="ascii")
            self.assertRegex(self.bench("compare", "--errors", first, first), r"^0 of \d+ quantities worse or missing\n$")
            lines = first.read_text(encoding="ascii").splitlines()
            lines.sort(key=lambda line: not line.startswith("#"))  # What is said comes first, then the header.
            at = next(i for i, line in enumerate(lines) if not line.startswith("#"))
            cells = next(csv.reader(lines[at + 1:at + 2]))
            place = lines[at].split(",").index(column)
            self.assertEqual(len(cells), len(lines[at].split(",")))
            cells[place] = str(float(cells[place]) * factor)
            second.write_text("\n".join([*lines[:at + 1], ",".join(cells), *lines[at + 2:]]) + "\n", encoding="ascii")
            said = subprocess.run([PROGRAM, "compare", "--errors", first, second], capture_output=True, text=True, check=False)
            self.assertEqual(said.returncode, 1, said.stderr)
            self.assertRegex(said.stdout, rf"^worse    {words}\n1 of \d+ quantities worse or missing\n$")
            second.write_text("\n".join([*lines[:at + 1], *lines[at + 2:]]) + "\n", encoding="ascii")
            said = subprocess.run([PROGRAM, "compare", first, second], capture_output=True, text=True, check=False)
            self.assertRegex(said.stdout, "missing  .*: all that is compared of it")
            said = self.bench("compare", second, first)
            self.assertRegex(said, r"# \d+ quantities of NEW are not in OLD")

    def test_tables_of_other_settings_are_not_compared(self):
        first, second = self.folder / "first.csv", self.folder / "second.csv"
        for file, push in ((first, 4), (second, 5)):
            file.write_text(self.bench("zwidth", "--csv", "--quick", "--rate", 1000, "--delay", 0, 0, "--damping", 0, 0, "--push", push),
                            encoding="ascii")
        self.assertIn('second.csv: its settings of zwidth are "sim://default, press of 5 N,', self.bench("compare", first, second, code=1))
        lines = second.read_text(encoding="ascii").splitlines(keepends=True)
        second.write_text("".join(line for line in lines if "settings of" not in line), encoding="ascii")
        said = subprocess.run([PROGRAM, "compare", first, second], capture_output=True, text=True, check=False).stdout
        self.assertIn("# NEW does not tell its settings of zwidth", said)
        sixdof = self.folder / "sixdof.csv"
        sixdof.write_text(self.bench("sixdof", "--csv"), encoding="ascii")
        self.assertRegex(self.bench("compare", first, sixdof, code=1), r"sixdof\.csv, line \d+: it holds \"sixdof .* nothing of what .*first\.csv")

    def test_rounds_of_other_settings_are_not_compared(self):
        models = ("models", "--rates", 100, "--stiffness", 300, "--seconds", 0.5, "--triangles", 1000, "--csv")
        for command, option, values in ((models, "--bumps", (0, 0.02)), (("ring", "--rounds", 1, "--csv"), "--messages", (1000, 2000))):
            files = [self.folder / f"{value}.csv" for value in values]
            for file, value in zip(files, values):
                file.write_text(self.bench(*command, option, value), encoding="ascii")
            self.assertRegex(self.bench("compare", *files, code=1), rf"{files[1]}: its settings of {command[0]}.* are \".*, those of {files[0]} \"")

    def test_errors_of_models_are_judged_by_one_round_on_any_machine(self):
        first, second = self.folder / "first.csv", self.folder / "second.csv"
        first.write_text(self.bench("models", "--rates", 100, "--stiffness", 300, "--seconds", 0.5, "--triangles", 1000, "--csv"), encoding="ascii")
        self.assertRegex(self.bench("compare", "--errors", first, first), r"^0 of \d\d quantities worse or missing\n$")
        lines = first.read_text(encoding="ascii").splitlines()
        at = next(i for i, line in enumerate(lines) if "300 N/m plane at 100 Hz - smooth: rms," in line)
        *names, value = lines[at].split(",")
        lines[at] = ",".join([*names, str(1.01 * float(value))])  # As little as a machine's times may differ.
        second.write_text("\n".join(lines) + "\n", encoding="ascii")
        self.assertIn("1 of ", subprocess.run([PROGRAM, "compare", "--errors", first, second], capture_output=True, text=True, check=False).stdout)

    def test_readings_of_one_file_are_told_apart(self):
        way = self.folder / "way.csv"
        way.write_text("t,x,y,z,fn\n" + "".join(f"{i / 1000},{i / 1e4},0,0,1\n" for i in range(9)), encoding="ascii")
        names = set()
        for command in ("run", "sweep"):
            for options in ((), ("--out",), ("--rate", 500)):
                said = self.bench(command, "-a", "ours", "-m", "plane", "-t", way, "--rounds", 1, "--csv", *options)
                names.add(next(line.split(",")[0] for line in said.splitlines() if line.startswith(command)))
        self.assertEqual(len(names), 6)

    def test_what_may_be_wrong_with_a_file_is_told(self):
        way, run = self.folder / "way.csv", [PROGRAM, "run", "-a", "ours", "-m", "plane", "--rounds", "1", "-t"]

        def said(depth, end):
            way.write_text("t,x,y,z\n" + "\n".join(f"{i / 1000},0,0,{-depth}" for i in range(9)) + end, encoding="ascii")
            return subprocess.run([*run, way], capture_output=True, text=True, check=True).stderr
        self.assertEqual(said(0.001, "\n"), "")
        self.assertRegex(said(0.001, ""), r"way\.csv, line 10: its last line does not end")
        for command in ("run", "sweep"):  # Millimetres that are taken for metres.
            run[1] = command
            self.assertIn("no force in any sample", said(-1, "\n"))

    def test_zeros_in_front_of_a_number_mean_nothing(self):
        run = ("run", "-a", "nearest", "-m", "plane:cells=3", "-t", "reach:seconds=0.1", "--csv", "--rounds")
        for said, rounds in (("010", 10), ("08", 8), ("+3", 3)):
            self.assertEqual(self.bench(*run, said).count(",nearest median,ns,"), rounds, said)

    def test_rounds_are_counted(self):
        values = self.results("run", "-a", "ours", "-m", "plane", "-t", "lissajous:seconds=0.1", "--rounds", 4)
        self.assertEqual(len(values["ours mean"]), 4)
        self.assertEqual(len(values["ours force MSE"]), 1)

    def test_a_sweep_runs_every_combination(self):
        values = self.results("sweep", "-m", "plane", "-t", "lissajous:seconds=1", "--stiffness", "500,1000", "--friction", "0,0.4",
                              "--speed", "1,2", "--rounds", 1)
        errors = {name: value[0] for name, value in values.items() if name.endswith("force MSE")}
        self.assertEqual(len(errors), 8)
        for name, error in errors.items():
            self.assertLess(error, 1e-12 if "mu=0 " in name else 0.1, name)

    def test_a_sweep_takes_no_value_twice(self):
        for option, values in (("--stiffness", "500,1000,5e2"), ("--friction", "0.4,0.40"), ("--speed", "1,2,1")):
            said = self.bench("sweep", "-m", "plane", "-t", "lissajous:seconds=0.1", option, values, code=1)
            self.assertRegex(said, rf"{option}: [\d.]+ is named twice \(")

    def test_a_file_behind_csv_is_told_where_to_stand(self):
        for arguments in (("--csv", "out.csv", "run"), ("run", "--csv", "./out", "-a", "ours")):
            self.assertIn("it takes no file and writes to standard output", self.bench(*arguments, code=2))

    def test_a_mesh_file_is_touched(self):
        stl = self.folder / "plate.stl"
        corners = ((-50, -50, 0), (50, -50, 0), (50, 50, 0), (-50, 50, 0))
        facets = "".join("facet normal 0 0 1\nouter loop\n" + "".join("vertex {} {} {}\n".format(*corners[i]) for i in facet) +
                         "endloop\nendfacet\n" for facet in ((0, 1, 2), (0, 2, 3)))
        stl.write_text(f"solid plate\n{facets}endsolid plate\n", encoding="ascii")
        way = self.folder / "way.traj"
        way.write_text("".join(f"{i} {i / 10 - 5} 3 0 {500 + i}\n" for i in range(100)), encoding="ascii")
        values = self.results("run", "-a", "ours", "-m", f"{stl}:scale=0.001", "-t", way, "--columns", "t_ms,x_mm,y_mm,z_mm,fn_mN",
                              "--out", "--rounds", 1)
        self.assertLess(values["ours force MSE"][0], 1e-12)

    def test_a_mesh_file_that_is_cut_short_is_an_error(self):
        ply = self.folder / "cut.ply"
        ply.write_text("ply\nformat binary_little_endian 1.0\nelement vertex 3000\nproperty float x\nproperty float y\n"
                       "property float z\nelement face 7000\nproperty list uchar int vertex_indices\nend_header\n" + 100 * "x",
                       encoding="ascii")
        self.assertRegex(self.bench("run", "-m", ply, code=1), r"^haptic-bench: .*cut\.ply: .+ \(.+\)\n$")

    def test_a_mesh_file_that_keeps_its_reader_busy_is_given_up_at_a_signal(self):
        obj, n = self.folder / "never.obj", 100_000  # One face that crosses itself everywhere.
        obj.write_text("".join(f"v {i * 7919 % 100_003} {i * i * 31 % 100_003} 0\n" for i in range(n)) +
                       "f " + " ".join(map(str, range(1, n + 1))) + "\n", encoding="ascii")

        def nohup():
            signal.signal(signal.SIGHUP, signal.SIG_IGN)

        with subprocess.Popen([PROGRAM, "run", "-m", obj], stderr=subprocess.PIPE, text=True, start_new_session=True,
                              preexec_fn=nohup) as run:
            readers = pathlib.Path(f"/proc/{run.pid}/task/{run.pid}/children")
            end = time.monotonic() + 30
            while not readers.read_text() and time.monotonic() < end:
                time.sleep(0.01)
            time.sleep(0.2)
            os.killpg(run.pid, signal.SIGHUP)  # The reader stays too.
            time.sleep(0.1)
            run.terminate()
            try:
                self.assertRegex(run.communicate(timeout=10)[1], r"never\.obj: it was interrupted \(.+\)\n$")
            finally:
                run.kill()
            self.assertEqual(run.returncode, 1)

    def test_numbers_need_not_be_whole(self):
        self.assertIn("no simulated device", self.bench("zwidth", "mouse://", "--damping", 0.5, "--rate", 1500.5, code=1))
        self.assertIn(" 3 ms late", self.bench("models", "--latency", 2.5, "--rates", 62.5, "--stiffness", 300.5, "--seconds", 0.5, "--triangles", 100))
        self.bench("cost", "--radius", 0.5, "--triangles", 1000, "--seconds", 0.1, "--rounds", 1)

    def test_an_output_that_is_not_whole_ends_with_1(self):
        for rounds in (1, 200):  # In the end, and on the way.
            command = [PROGRAM, "run", "-a", "ours", "-m", "plane", "-t", "lissajous:seconds=0.01", "--csv", "--rounds", str(rounds)]
            with open("/dev/full", "w", encoding="ascii") as full:
                done = subprocess.run(command, stdout=full, stderr=subprocess.PIPE, text=True, check=False)
            self.assertEqual(done.returncode, 1, done.stderr)
            self.assertRegex(done.stderr, "not all could be written|cannot write")
        free = self.folder / "free.csv"
        free.write_text("t,px,py,pz\n" + "".join(f"0.00{i},0,0,0.1\n" for i in range(10)), encoding="ascii")
        with open("/dev/full", "w", encoding="ascii") as full:  # What is said beside it is no result: here of no force.
            done = subprocess.run([*command[:6], "-t", free, "--rounds", "1"], stdout=subprocess.PIPE, stderr=full, check=False)
        self.assertEqual(done.returncode, 0, done.stdout)

    def test_what_no_machine_holds_and_no_surface_has_is_refused(self):
        self.assertIn("3.6e+08 samples", self.bench("run", "-t", "spiral:seconds=3600,rate=100000", code=1))
        self.assertIn("at most 1e+07", self.bench("run", "-m", "ridge", "-t", "profile:speed=0.000001,rate=100000", code=1))
        self.assertIn("--stiffness", self.bench("run", "--stiffness", 0, code=2))
        self.assertIn("--seconds", self.bench("models", "--seconds", 0.1, code=2))
        self.assertIn("at 1000 N/m the hand is pressed 0.001 m in, to the middle of sphere:radius=0.001 (",
                      self.bench("sweep", "-m", "sphere:radius=0.001", "--stiffness", "1e4,1000", code=1))
        self.assertIn("--stiffness: at 500 N/m", self.bench("models", "--stiffness", 1500, 500, "--radius", 0.002, code=1))
        self.assertIn("stays above 16128 flat faces", self.bench("models", "--seconds", 0.5, "--rates", 10, "--radius", 10, code=1))
        self.assertIn("--device: -1 is out of range", self.bench("run", "--device", -1, code=2))
        for command in ("run --stiffness", "run --threshold", "run --radius", "run --max-gap", "sweep --stiffness", "sweep --speed",
                        "models --latency", "zwidth --push", "servo --seconds", "cost --seconds", "load --rates", "device --seconds",
                        "stability --voxel", "collide --peer-seconds"):
            said = self.bench(*command.split(), "nan", code=2)
            self.assertIn(f"{command.split()[1]}: 'nan' is not a finite number\n", said)
        self.assertIn("ours is named twice", self.bench("run", "-a", "ours", "nearest", "ours", code=1))
        self.assertIn("--pair", self.bench("collide", "--pair", "peg", "pegs", code=2))
        self.assertIn("--response", self.bench("stability", "--response", "soft", code=2))
        for name in ("brick on floor", "peg held deep", "skull fragment", "voxel peg"):
            self.assertIn(name, self.bench("stability", "--pair", "brick", code=2))
        self.assertIn("--check: it judges", self.bench("stability", "--response", "impulse", "--check", code=1))
        self.assertIn("none/p.csv: it cannot", self.bench("cost", "--profile", self.folder / "none" / "p.csv", code=1))
        self.assertIn("--friction-static: 0 is less", self.bench("run", "--friction-dynamic", 0.5, "-m", "plane", code=1))
        self.assertTrue(self.bench("run", "-a", "voxel:cells=9999", code=1).startswith("haptic-bench: voxel:cells=9999, cells: "))

    def late(self):
        return self.plugin("late.c", LATE)

    def plugin(self, name, text):
        header = pathlib.Path(__file__).resolve().parents[2] / "tools" / "haptic-bench" / "plugin"
        source = self.folder / name
        source.write_text(text, encoding="ascii")
        compiler = "cc" if source.suffix == ".c" else "c++"
        subprocess.run([compiler, "-shared", "-fPIC", f"-I{header}", "-o", source.with_suffix(".so"), source], check=True)
        return source.with_suffix(".so")

    def test_a_plug_in_that_takes_the_program_with_it_is_named_with_its_sample(self):
        plugin, samples = self.plugin("wrong.cc", WRONG), self.folder / "samples.csv"
        for how, code, words in (("crash", -signal.SIGSEGV, "it crashed"), ("divide", -signal.SIGFPE, "it crashed in its arithmetic"),
                                 ("deep", -signal.SIGSEGV, "it crashed"), ("abort", -signal.SIGABRT, "it aborted"),
                                 ("exit", 1, "it ended the program"), ("throw", 1, 'it has thrown "no luck"'),
                                 ("throw a number", -signal.SIGABRT, "it aborted")):
            run = ("run", "-m", "plane", "-t", "lissajous:seconds=0.1", "--samples", samples, "--rounds", 2, "-a", "ours")
            said = self.bench(*run, f"{plugin}:{how}", code=code)
            self.assertRegex(said, rf"haptic-bench: .*wrong\.so:{how}: {words} at sample 51\b.* \(mend the algorithm")
            said = self.bench(*run, f"{plugin}:create {how}", code=code)
            self.assertRegex(said, rf"haptic-bench: .*wrong\.so:create {how}: {words}.* \(mend the algorithm")
            self.assertNotIn("sample", said.replace("samples", ""))
            self.assertFalse(samples.exists())

    def test_a_plug_in_without_a_table_is_told_from_a_name_that_nobody_has(self):
        plugin = self.plugin("none.c", '#include "haptic_algorithm.h"\nconst haptic_algorithm* haptic_algorithm_table(void) { return 0; }\n')
        self.assertRegex(self.bench("run", "-a", plugin, code=1), r"none\.so: its haptic_algorithm_table\(\) answers null \(")

    def test_no_algorithm_starts_before_all_are_known(self):
        plugin = self.late()
        for command in ("run", "sweep"):
            some = (command, "-m", "plane", "-t", "lissajous:seconds=0.1", "--rounds", 2, "-a", plugin)
            self.assertIn("it starts", self.bench(*some, code=1))
            for wrong, words in (("theirs", "no such algorithm"), ("local:rat=30", "rat"), ("./none.so", "none.so")):
                said = self.bench(*some, wrong, code=1)
                self.assertIn(words, said)
                self.assertNotIn("it starts", said)

    def test_rounds_take_turns(self):
        plugin = self.plugin("turns.cc", WRONG)
        for command, runs in ((("run",), "a b a b a b"), (("sweep", "--stiffness", "100,200"), "a b a b a b a b a b a b")):
            some = (PROGRAM, *command, "-m", "plane", "-t", "lissajous:seconds=0.01", "--rounds", "3", "-a", f"{plugin}:a", f"{plugin}:b")
            said = subprocess.run(some, capture_output=True, text=True, check=True).stderr
            self.assertEqual([line[0] for line in said.splitlines() if line.endswith(" starts")], runs.split())

    def test_a_plug_in_that_does_not_repeat_is_named(self):
        counts = LATE.replace("if (++steps > 150) contact->force[0] = 0.0 / 0.0;", "contact->force[0] = ++steps;")
        plugin = self.plugin("counts.c", counts)
        for command in (("run",), ("sweep", "--stiffness", "100,200")):
            some = (PROGRAM, *command, "-m", "plane", "-t", "lissajous:seconds=0.01", "-a", "ours", plugin, "--rounds")
            for rounds, times in (("1", 0), ("2", 1)):
                said = subprocess.run([*some, rounds], capture_output=True, text=True, check=True).stderr
                self.assertEqual(said.count("counts.so: its rounds differ in their forces"), times)
                self.assertNotIn("ours: ", said)

    def test_a_plug_in_that_fails_in_a_later_round_is_named_with_its_sample(self):
        plugin = self.late()
        run = ("run", "-a", plugin, "-m", "plane", "-t", "lissajous:seconds=0.1", "--rounds")
        self.bench(*run, 1)
        self.assertIn("late.so: its answer to sample 51 at 0.05 s is not finite", self.bench(*run, 2, code=1))
        self.assertEqual(self.bench("run", "-a", self.folder / "none.so", code=1).count("none.so"), 1)

    def test_compare_counts_what_it_compares(self):
        times, other = self.folder / "times.csv", self.folder / "other.csv"
        times.write_text("# cpu: x\n# load: 1\nb,q,ns,1,5\nb,h,hash,1,5\nb,e,N^2,1,5\n", encoding="ascii")
        other.write_text("# cpu: x\n# load: 2\nb,q,ns,1,9\nb,h,hash,1,5\nb,e,N^2,1,5\n", encoding="ascii")
        self.assertRegex(self.bench("compare", times, other),
                         "^# 1 not judged: times of fewer than 6 rounds.*\n0 of 1 quantities worse or missing\n$")
        times.write_text("b,q,ns,1,5\n", encoding="ascii")
        for options in (("--errors",), ()):
            self.assertIn("nothing in it is compared", self.bench("compare", *options, times, times, code=1))

    def test_faults_are_named_and_end_with_1(self):
        bad = self.folder / "bad.csv"
        bad.write_text("t,x,y,z\n0,0,0,0\n0.001,0,nan,0\n", encoding="ascii")
        self.assertIn("bad.csv, line 3, column 3 (y)", self.bench("run", "-t", bad, code=1))
        self.assertIn("no such algorithm", self.bench("run", "-a", "theirs", code=1))
        self.assertIn("no such model", self.bench("run", "-m", "cube", code=1))
        self.assertIn("cannot be read", self.bench("compare", self.folder / "none", bad, code=1))
        self.assertIn("line 1", self.bench("compare", bad, bad, code=1))
        for words in (["compare", "/dev/zero", bad], ["replay", "/dev/zero"]):
            self.assertIn("without an end", self.bench(*words, code=1))
        self.assertIn("without an end", self.bench("report", "--with", "/dev/zero", code=2))
        self.assertIn("its name is empty", self.bench("report", "", code=1))
        for words in (["run", "--samples", ""], ["replay", "x", "--export", ""], ["run", "-m", ""], ["--rounds", ""]):
            self.assertIn(f"{words[-2]}: what follows it is empty", self.bench(*words, code=2))
        self.assertIn("haptic-bench run --help lists its options", self.bench("run", "--colour", "red", code=2))
        self.assertIn("did you mean --friction-", self.bench("run", "--friction", "0.3", code=2))
        self.assertNotIn("did you mean", self.bench("run", "--colour", "red", code=2))
        self.assertIn("haptic-bench --help lists benchmarks and options", self.bench("--colour", "red", code=2))
        self.assertIn("zwith: there is no such benchmark (there is zwidth, ", self.bench("zwith", code=2))
        self.assertIn("subcommand is required", self.bench(code=2))


if __name__ == "__main__":
    unittest.main()
