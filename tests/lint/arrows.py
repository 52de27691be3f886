#!/usr/bin/python3
"""Keeps the include arrows of docs/architecture.md: which room may include which.

Usage: arrows.py ROOT. Prints each include that breaks an arrow and exits 1.
"""
import pathlib
import re
import sys

# A room is the longest prefix that fits. (rooms it may include, libraries it may include besides the standard ones)
ROOMS = {
    "proto": ({"proto"}, set()),
    "rt": ({"rt", "proto"}, {"Eigen"}),
    "drivers": ({"drivers", "rt", "proto"}, {"Eigen", "fmt", "libusb-1.0", "hidapi", "gpiod.h"}),
    "daemon": ({"daemon", "drivers", "rt", "proto"},
               {"Eigen", "capnp", "kj", "spdlog", "fmt", "toml++", "CLI", "nlohmann", "systemd"}),
    "daemon/builder": ({"daemon/builder", "daemon/ipc", "rt", "proto"}, {"Eigen", "fmt"}),
    # The one room of the daemon's that may see OpenVDB; hapticd itself links none of it.
    "daemon/builder/vdb": ({"daemon/builder", "daemon/ipc/cached_build.h", "daemon/version.h", "rt", "proto"},
                           {"Eigen", "fmt", "openvdb"}),
    "libclient/include": ({"libclient/include"}, set()),
    "libclient/src": ({"libclient", "proto", "rt/ring", "rt/base/contract.h", "rt/base/error.h"}, {"capnp", "kj"}),
    "examples": ({"libclient/include"}, set()),
    "tools/hapticctl": ({"tools/hapticctl", "tools/mesh_file", "tools/options", "libclient/include",
                         "rt/base/edit_distance.h", "rt/base/standard_streams.h"}, {"CLI", "fmt", "nlohmann"}),
    "tools/hapticctl-cut": ({"tools/hapticctl-cut", "tools/hapticctl-import", "tools/hapticctl", "tools/mesh_file",
                             "tools/options", "rt/base/standard_streams.h"}, {"Eigen", "CLI", "fmt"}),
    "tools/options": ({"tools/options"}, {"CLI", "fmt"}),
    "tools/mesh_file": ({"tools/mesh_file"}, {"Eigen", "fmt", "assimp", "nlohmann"}),
    "tools/hapticctl-import": ({"tools/hapticctl-import", "tools/options", "daemon/builder/volume", "daemon/builder/vdb",
                                "rt/volume", "rt/base/standard_streams.h"}, {"CLI", "fmt", "openvdb", "ITK"}),
    "tools/haptic-bench": ({"tools/haptic-bench", "tools/haptic-emu", "tools/mesh_file", "tools/options", "daemon",
                            "drivers", "rt", "proto", "libclient/include"},
                           {"Eigen", "CLI", "fmt", "nlohmann", "benchmark", "hdf5.h", "fcl", "BulletCollision",
                            "btBulletCollisionCommon.h"}),
    # Never a driver's own folder: with its encoders the played device would agree with its bugs.
    "tools/haptic-emu": ({"tools/haptic-emu", "tools/options", "drivers/usb", "drivers/hid", "drivers/serial", "drivers/sim/body.h",
                          "drivers/sim/linear_step.h", "rt/base"}, {"Eigen", "CLI", "fmt"}),
}
# Libraries that only one place may see, whatever the table says.
LIBRARIES = {"Eigen", "libusb-1.0", "hidapi", "gpiod.h", "capnp", "kj", "spdlog", "fmt", "toml++", "CLI", "nlohmann",
             "systemd", "openvdb", "ITK", "assimp", "benchmark", "hdf5.h", "fcl", "BulletCollision", "btBulletCollisionCommon.h"}
INCLUDE = re.compile(r'^\s*#\s*include\s*([<"])([^>"]+)[>"]')


def room_of(path):
    fits = [room for room in ROOMS if path == room or path.startswith(room + "/")]
    return max(fits, key=len) if fits else None


def resolve(root, here, name):
    """The project file an include names, relative to the root; None for a library's."""
    for base in (root, root / "libclient/include"):
        if (base / name).is_file():
            return (base / name).resolve().relative_to(root.resolve()).as_posix()
    return None


def allowed(target, rooms):
    return any(target == room or target.startswith(room + "/") for room in rooms)


def check(root):
    broken = []
    for path in sorted(root.rglob("*")):
        if path.suffix not in {".h", ".hpp", ".cc", ".c"}:
            continue
        name = path.relative_to(root).as_posix()
        room = room_of(name)
        if room is None:
            continue
        rooms, libraries = ROOMS[room]
        for number, line in enumerate(path.read_text(encoding="utf-8").splitlines(), 1):
            match = INCLUDE.match(line)
            if not match:
                continue
            include = match.group(2)
            target = resolve(root, path, include)
            if target is not None:
                if not allowed(target, rooms):
                    broken.append(f"{name}:{number}: {room} may not include {target}")
            elif include.endswith(".capnp.h"):
                if "capnp" not in libraries:
                    broken.append(f"{name}:{number}: {room} may not include the schema {include}")
            else:
                # ITK and GDCM have no folder in their names: itkImage.h, gdcmTrace.h.
                library = "ITK" if re.match("(itk|gdcm)[A-Z]", include) else include.split("/")[0]
                if library in LIBRARIES and library not in libraries:
                    broken.append(f"{name}:{number}: {room} may not include the library {library}")
    return broken


def main():
    broken = check(pathlib.Path(sys.argv[1]))
    print("\n".join(broken) if broken else "every include follows the arrows")
    return 1 if broken else 0


if __name__ == "__main__":
    sys.exit(main())
