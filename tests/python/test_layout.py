"""The ctypes structures are the headers': compared with what a C compiler makes of them."""
import ctypes
import os
import pathlib
import subprocess
import sys
import tempfile
import unittest

import hapticclient
from hapticclient import _abi

HEADERS = pathlib.Path(os.environ["HAPTICCLIENT_HEADERS"])


def structures():
    return [value for value in vars(_abi).values()
            if isinstance(value, type) and issubclass(value, ctypes.Structure) and value is not _abi.Struct]


class Layout(unittest.TestCase):
    def test_every_field_lies_where_the_compiler_puts_it(self):
        lines = ['#include <hapticclient/hapticclient.h>', '#include <stdio.h>', 'int main(void) {']
        expected = []

        def ask(expression, value):
            lines.append(f'printf("{expression} %zu\\n", {expression});')
            expected.append(f"{expression} {value}")

        for kind in structures():
            ask(f"sizeof({kind.__name__})", ctypes.sizeof(kind))
            for name, *_ in kind._fields_:
                field = getattr(kind, name)
                ask(f"offsetof({kind.__name__}, {name})", field.offset)
                ask(f"sizeof((({kind.__name__}*)0)->{name})", field.size)
        ask("sizeof(haptic_sample)", hapticclient.SAMPLE.itemsize)
        for name in hapticclient.SAMPLE.names:
            kind, offset = hapticclient.SAMPLE.fields[name]
            ask(f"offsetof(haptic_sample, {name})", offset)
            ask(f"sizeof(((haptic_sample*)0)->{name})", kind.itemsize)
        lines.append("return 0; }")
        self.assertGreater(len(expected), 300)
        with tempfile.TemporaryDirectory() as directory:
            source, program = pathlib.Path(directory, "layout.c"), pathlib.Path(directory, "layout")
            source.write_text("\n".join(lines), encoding="utf-8")
            subprocess.run(["cc", "-std=c11", "-I", HEADERS, source, "-o", program], check=True)
            printed = subprocess.run([program], check=True, capture_output=True, text=True).stdout.splitlines()
        self.assertEqual(printed, expected)

    def test_every_function_of_the_headers_has_a_prototype(self):
        import re
        declared = set()
        for path in HEADERS.rglob("*.h"):
            declared |= set(re.findall(r"^HAPTIC_API [^(]*?\bhaptic_(\w+)\(", path.read_text(encoding="utf-8"), re.M))
        missing = declared - set(_abi._PROTOTYPES) - {"upload_mesh"}  # Which asks for no volume.
        self.assertEqual(missing, set())


class Numbers(unittest.TestCase):
    """Enumerations of the module against those of the headers."""
    MIRRORED = {"Code": ("error_code", ""), "Ability": ("ability", ""), "Calibration": ("calibration", "CALIBRATION_"),
                "EffectKind": ("effect_kind", "EFFECT_"), "EventKind": ("event_kind", "EVENT_"), "Fault": ("fault", "FAULT_"), "Frame": ("frame", "FRAME_"),
                "ObjectFlag": ("object_flag", "OBJECT_"), "SampleFlag": ("sample_flag", "SAMPLE_"),
                "ShapeKind": ("shape_kind", "SHAPE_"), "Source": ("source", "SOURCE_")}
    # These are arguments or methods of their own, or told where they stand.
    LEFT_OUT = {"connect_flag", "push_flag", "model_kind", "mesh_flag", "check_state"}

    def test_each_has_the_headers_names_and_values(self):
        import re
        text = "\n".join(path.read_text(encoding="utf-8") for path in sorted(HEADERS.rglob("*.h")))
        text = re.sub(r"/\*.*?\*/", "", text, flags=re.S)
        declared = {name: dict(re.findall(r"\bHAPTIC_(\w+) = ([\d <]+)", body))
                    for name, body in re.findall(r"^typedef enum haptic_(\w+) \{(.*?)^\}", text, re.M | re.S)}
        self.assertEqual(set(declared), {name for name, _ in self.MIRRORED.values()} | self.LEFT_OUT)
        for ours, (theirs, prefix) in self.MIRRORED.items():
            wanted = {key.removeprefix(prefix): eval(value) for key, value in declared[theirs].items()
                      if key not in ("EVENT_KINDS", "SOURCES", "FAULT_COUNT")}  # How many there are.
            self.assertEqual({member.name: member.value for member in getattr(hapticclient, ours)}, wanted, ours)


class Help(unittest.TestCase):
    def test_everything_public_tells_what_it_does(self):
        import inspect
        silent = []
        for name in hapticclient.__all__:
            value = getattr(hapticclient, name)
            parts = {name: value}
            if inspect.isclass(value):
                parts.update({f"{name}.{inner}": part for inner, part in vars(value).items() if not inner.startswith("_")})
            silent += [name for name, part in parts.items()
                       if (inspect.isroutine(part) or inspect.isclass(part) or isinstance(part, property)) and not inspect.getdoc(part)]
        self.assertEqual(silent, [])


class Frames(unittest.TestCase):
    def test_conversion_and_its_inverse(self):
        import numpy as np
        for values in ([1, 2, 3], [0.5, 0.5, 0.5, 0.5], np.arange(9).reshape(3, 3)):
            for frame in hapticclient.Frame:
                there = hapticclient.convert(values, hapticclient.Frame.HAPTICD, frame)
                back = hapticclient.convert(there, frame, hapticclient.Frame.HAPTICD)
                np.testing.assert_array_equal(back, values)
        with self.assertRaises(ValueError):
            hapticclient.convert([1, 2], hapticclient.Frame.HAPTICD, hapticclient.Frame.ROS)
        for none in (4, 1 << 32 | 2, -1):  # The library would read the lowest 32 bits.
            with self.assertRaisesRegex(ValueError, f"{none} is none of Frame.HAPTICD, "):
                hapticclient.convert([1, 2, 3], none, hapticclient.Frame.HAPTICD)


class Errors(unittest.TestCase):
    def test_nobody_there(self):
        with self.assertRaises(hapticclient.HapticError) as caught:
            hapticclient.Client("/nonexistent/control.sock")
        self.assertEqual(caught.exception.code, hapticclient.Code.DISCONNECTED)
        self.assertEqual(caught.exception.where, "/nonexistent/control.sock")
        self.assertTrue(caught.exception.remedy)

    def test_a_library_that_is_missing_or_another_is_told_with_what_to_do(self):
        for library, what in (("/none/libhapticclient.so.1", "No such file"), ("libc.so.6", "it has no haptic_")):
            done = subprocess.run([sys.executable, "-c", "import hapticclient"], capture_output=True, text=True, check=False,
                                  env={**os.environ, "HAPTICCLIENT_LIBRARY": library})
            told = done.stderr.splitlines()[-1]
            self.assertTrue(told.startswith("ImportError: " + library), told)
            self.assertIn(what, told)
            self.assertIn("libhapticclient1", told)

    def test_codes_are_the_librarys(self):
        for code in hapticclient.Code:
            self.assertEqual(_abi.lib.haptic_error_name(code).decode(), f"HAPTIC_{code.name}")
        self.assertEqual(_abi.lib.haptic_error_name(max(hapticclient.Code) + 1), b"HAPTIC_UNKNOWN")
        known = {code for code in range(max(hapticclient.Code) + 1) if _abi.lib.haptic_error_name(code) != b"HAPTIC_UNKNOWN"}
        self.assertEqual(known, set(hapticclient.Code), "none of them is left out here")
        for kind in hapticclient.EventKind:
            self.assertEqual(_abi.lib.haptic_event_name(kind).decode(), kind.name.lower().replace("_", "-"))


class NewerDaemon(unittest.TestCase):
    def test_numbers_that_are_not_known_yet_pass_as_they_are(self):
        from hapticclient.convert import object_state
        made = _abi.Object(name=b"new", parent=b"", shape=_abi.Shape(kind=99))
        raw = _abi.ObjectState(object=ctypes.pointer(made), surface=ctypes.pointer(_abi.Surface()), path=b"/_objects/new", owner=b"")
        self.assertEqual(object_state(raw).shape, 99)
        made.shape.kind = 3
        self.assertIs(object_state(raw).shape, hapticclient.ShapeKind.BOX)
        self.assertEqual(hapticclient.HapticError(99).code, 99)


if __name__ == "__main__":
    unittest.main()
