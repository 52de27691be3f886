#!/usr/bin/python3
"""A fragment of a skull is brought home by a simulated hand with six degrees of freedom, guided by what it touches.

    surgery.py [--skull SKULL.ply] [--output PICTURE.png]      with a daemon that simulates sim://default?dof=6

Without --skull a small one is made. Ends with 1 when the fragment does not come home.
"""
import argparse
import os
import pathlib
import subprocess
import sys
import tempfile
import time

import hapticclient as haptic
import numpy as np
from hand import MM, Hand, angle_of
from meshes import Unusable, read_ply, small_skull, vault_of, write_ply

LONGEST_STEP = 0.02  # [s]


def run(*command: object) -> None:
    done = subprocess.run([str(word) for word in command], capture_output=True, text=True, check=False)
    if done.returncode != 0:
        sys.exit(f"surgery: {command[1]} ended with {done.returncode}:\n{done.stdout}{done.stderr}")
    print(done.stdout, end="")


def prepare(options, folder: pathlib.Path):
    """Cuts the skull; both parts then stand such that the fragment's home is the origin and its way out is +z."""
    whole = folder / "skull.ply"
    if options.skull:
        whole = options.skull
        at, pull = vault_of(read_ply(whole), np.array(options.toward), options.above)
    else:
        mesh, at, pull = small_skull()
        write_ply(whole, mesh)
    body, fragment = folder / "body.ply", folder / "fragment.ply"
    words = lambda v: ",".join(f"{x:.4f}" for x in v)  # noqa: E731
    run(options.hapticctl, "cut", whole, f"--shell={words(at)}", f"--pull={words(pull)}", "--radius", options.radius, "--noise",
        options.noise, "--wavelength", 8, "--voxel", options.voxel, "--coarse", options.coarse, "--body", body, "--fragment", fragment)
    side = np.cross(pull, [1.0, 0, 0] if abs(pull[0]) < 0.9 else [0, 1.0, 0])
    side /= np.linalg.norm(side)
    turn = np.stack([side, np.cross(pull, side), pull])  # Rows: the axes of the table in those of the scan.
    parts = {}
    home = None
    for path in (fragment, body):
        vertices, triangles = read_ply(path)
        vertices = vertices @ turn.T
        if home is None:
            home = (vertices.min(0) + vertices.max(0)) / 2
        parts[path.stem] = (vertices - home, triangles)
        write_ply(path, parts[path.stem])
    return parts


def load(options, folder: pathlib.Path) -> None:
    for name, voxel in (("body", options.body_voxel), ("fragment", options.voxel)):
        run(options.hapticctl, "load", folder / f"{name}.ply", "--scale", "mm", "--voxel", voxel, "--name", name,
            "--friction", f"{options.friction},{options.friction}", *(["--at", "0,0,0.5"] if name == "fragment" else []))
    run(options.hapticctl, "tool", "attach", "fragment", "--mass", "0.03")


def bring_home(session: haptic.Session, client: haptic.Client, hand: Hand):
    """Plays the hand; rows of time, place [mm], turn [deg], force, torque, contacts; and every sample of the servo."""
    rows, history = [], []
    tool = f"/devices/{client.status().devices[0].name}/tool"
    t, last, sample = 0.0, time.monotonic(), session.latest()
    while t < hand.seconds:
        p, q = hand.intent(t, sample["force"], sample["torque"])
        session.push_intent(p, q, latest=True)
        time.sleep(0.005)
        now = time.monotonic()
        t, last = t + min(now - last, LONGEST_STEP), now  # A hand whose program is held up waits with it.
        sample = session.latest()
        history.append(session.drain())
        place, turn = client.get("/objects/fragment/pos"), client.get("/objects/fragment/rot")
        contacts = client.get(tool)["contacts"]
        rows.append((t, np.array(place) / MM, angle_of(np.array(turn)), np.linalg.norm(sample["force"]),
                     np.linalg.norm(sample["torque"]), contacts))
    return rows, np.concatenate(history)


def report(rows, history, client: haptic.Client, bounds) -> int:
    """Prints what came of it; 0 if the fragment is home and at rest."""
    place = np.stack([row[1] for row in rows])
    turn = np.array([row[2] for row in rows])
    t = np.array([row[0] for row in rows])
    resting = place[t > t[-1] - 0.5]
    collide = next(h for h in client.statistics().histograms if h.name == "collide")
    force, torque = np.linalg.norm(history["force"], axis=1), np.linalg.norm(history["torque"], axis=1)
    contacts = np.array([row[5] for row in rows])
    creep = float(np.ptp(resting, axis=0).max())
    off, askew = float(np.linalg.norm(place[-1])), float(turn[-1])
    print(f"before            {np.linalg.norm(place[0]):.1f} mm from home, turned by {turn[0]:.1f} degrees")
    print(f"misalignment      {off:.2f} mm ({place[-1][0]:+.2f}, {place[-1][1]:+.2f}, {place[-1][2]:+.2f}), {askew:.2f} degrees")
    print(f"at rest           moved by {creep * 1e3:.1f} um in the last half second")
    print(f"peak              {force.max():.2f} N, {torque.max():.3f} N m")
    print(f"contacts          mean {contacts[contacts > 0].mean() if contacts.any() else 0:.0f}, at most {contacts.max()}")
    print(f"collision         p50 {collide.p50_ns / 1e3:.0f} us, p99 {collide.p99_ns / 1e3:.0f} us, "
          f"max {collide.max_ns / 1e3:.0f} us of {collide.count} queries")
    home = off <= bounds[0] and askew <= bounds[1] and creep < 0.05 and contacts.max() > 2 and collide.count > 500
    print("home" if home else f"NOT HOME: at most {bounds[0]} mm, {bounds[1]} degrees and at rest were asked for")
    return 0 if home else 1


def main() -> int:
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    parser.add_argument("--skull", type=pathlib.Path, help="a closed mesh in mm, as hapticctl import --output writes it")
    parser.add_argument("--toward", type=float, nargs=3, default=(0.35, 0.2, 1.0), help="from its middle to the place of the cut")
    parser.add_argument("--radius", type=float, default=15.5, help="of the ball that cuts [mm]")
    parser.add_argument("--above", type=float, default=9.0, help="its middle over the vault [mm]")
    parser.add_argument("--noise", type=float, default=0.5, help="roughness of the cut, RMS [mm]")
    parser.add_argument("--voxel", type=float, default=0.7, help="of cut and fragment [mm]")
    parser.add_argument("--coarse", type=float, default=2, help="of the mesh away from the cut [mm]")
    parser.add_argument("--body-voxel", type=float, default=0.7, help="of the skull's volume [mm]")
    parser.add_argument("--quick", action="store_true", help="a hand that takes 8 s instead of 10.5")
    parser.add_argument("--friction", type=float, default=0.15)
    parser.add_argument("--bound", type=float, nargs=2, default=(0.5, 1.5), help="home is within so many mm and degrees")
    parser.add_argument("--hapticctl", default=os.environ.get("HAPTICCTL", "hapticctl"))
    parser.add_argument("--output", type=pathlib.Path, help="draw before and after")
    parser.add_argument("--title", default="A fragment of a skull is brought home")
    parser.add_argument("--samples", type=pathlib.Path, help="write the run as CSV")
    options = parser.parse_args()
    hand = Hand(approach_s=1.2, press_s=3.0, ease_s=3.0, rest_s=0.8) if options.quick else Hand()
    with tempfile.TemporaryDirectory(prefix="hapticd-surgery.") as folder, haptic.Client(name="surgery") as client, \
         client.open_session() as session:
        parts = prepare(options, pathlib.Path(folder))
        session.push_intent(*hand.intent(0, np.zeros(3), np.zeros(3)), latest=True)
        load(options, pathlib.Path(folder))
        session.arm()
        while session.latest()["flags"] & (haptic.SampleFlag.ARMED | haptic.SampleFlag.RAMPING) != haptic.SampleFlag.ARMED:
            time.sleep(0.01)
        session.drain()
        rows, history = bring_home(session, client, hand)
        end = np.array(client.get("/objects/fragment/pos")) / MM, np.array(client.get("/objects/fragment/rot"))
        code = report(rows, history, client, options.bound)
        session.disarm()
    if options.samples:
        np.savetxt(options.samples, [np.concatenate([[r[0]], r[1], r[2:]]) for r in rows], delimiter=",", fmt="%.6g",
                   header="t_s,x_mm,y_mm,z_mm,turn_deg,force_n,torque_nm,contacts", comments="")
    if options.output:
        import draw
        draw.draw(options.output, parts, hand, rows, end, options.title)
        print(f"picture           {options.output}")
    return code


if __name__ == "__main__":
    try:
        sys.exit(main())
    except (haptic.HapticError, Unusable, OSError) as error:
        sys.exit(f"surgery: {error}")
