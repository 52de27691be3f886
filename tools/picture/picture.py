#!/usr/bin/python3
"""Draws what hapticctl monitor --csv recorded: the path on the mesh, the forces by their source, the servo's timing.

    picture.py SAMPLES.csv --mesh MESH.stl --scale METRES --at X,Y,Z --output PICTURE.png
"""
import argparse
import pathlib
import sys

import numpy as np

sys.path.insert(0, str(pathlib.Path(__file__).resolve().parent))
import mesh  # noqa: E402
import render  # noqa: E402

INK, FAINT, PAPER = "#26303a", "#8a949e", "#ffffff"
SOURCES = {"surface": "#d1495b", "local_model": "#edae49", "client": "#00798c", "effect": "#7b5ea7", "gravity": "#66a182",
           "texture": "#a0522d", "transient": "#d08770", "guard": "#5f6b76"}
PANEL = (1000, 1040)  # Pixels of the view.


def load_samples(path):
    """Columns of the CSV by name. Exits with the file's name when it is empty."""
    with open(path, encoding="ascii") as file:
        names = file.readline().strip().split(",")
        rows = np.loadtxt(file, delimiter=",", ndmin=2)
    if rows.size == 0 or "proxy_x" not in names:
        sys.exit(f"picture: {path}: holds no samples of hapticctl monitor --csv")
    return {name: rows[:, i] for i, name in enumerate(names)}


def vectors(samples, *names):
    return np.stack([samples[name] for name in names], 1)


def style():
    import matplotlib

    matplotlib.use("Agg")
    matplotlib.rcParams.update({
        "font.family": "DejaVu Sans", "font.size": 10.5, "text.color": INK, "axes.labelcolor": INK, "axes.edgecolor": FAINT,
        "xtick.color": INK, "ytick.color": INK, "axes.spines.top": False, "axes.spines.right": False, "axes.titleweight": "bold",
        "axes.titlelocation": "left", "axes.titlesize": 11.5, "axes.linewidth": 0.8, "figure.facecolor": PAPER,
        "axes.grid": True, "grid.color": "#e4e8ec", "grid.linewidth": 0.8, "axes.axisbelow": True})


def view(figure, box, corners, samples):
    """The shaded mesh with the proxy's path, coloured by force, and arrows of the force that the hand feels."""
    from matplotlib.cm import ScalarMappable
    from matplotlib.collections import LineCollection
    from matplotlib.colors import LinearSegmentedColormap, Normalize

    proxy, hip = vectors(samples, "proxy_x", "proxy_y", "proxy_z"), vectors(samples, "px", "py", "pz")
    force = vectors(samples, "fx", "fy", "fz")
    newtons = np.linalg.norm(force, axis=1)
    every = max(len(proxy) // 5000, 1)
    proxy, hip, force, newtons, contact = (a[::every] for a in (proxy, hip, force, newtons, samples["contact"] > 0))

    camera = render.Camera([1.0, 0.42, 1.05], np.vstack([corners.reshape(-1, 3), proxy]), PANEL[0] * 2, PANEL[1] * 2)
    depth, normal = render.rasterise(camera, corners, mesh.smooth_normals(corners))
    image = render.halve(render.shade(depth, normal))

    axes = figure.add_axes(box)
    axes.imshow(image, extent=(0, PANEL[0] * 2, PANEL[1] * 2, 0), interpolation="antialiased")
    axes.set_axis_off()

    def seen(flat):
        column = np.clip(flat[:, 0].astype(int), 0, depth.shape[1] - 1)
        row = np.clip(flat[:, 1].astype(int), 0, depth.shape[0] - 1)
        return flat[:, 2] > depth[row, column] - 0.0025 * camera.scale

    flat = camera.project(proxy)
    visible = seen(flat)
    high = max(np.percentile(newtons[contact], 99) if contact.any() else 0, 0.1)
    colours = LinearSegmentedColormap.from_list("force", ["#2d6a8e", "#3fa796", "#f2b134", "#e4572e", "#a4133c"])
    norm = Normalize(0, high)
    segments = np.stack([flat[:-1, :2], flat[1:, :2]], 1)
    rgba = colours(norm(newtons[:-1]))
    rgba[:, 3] = np.where(visible[:-1], 1.0, 0.13)
    free = ~contact[:-1]
    rgba[free] = [0.35, 0.42, 0.48, 0.55]
    rgba[free & ~visible[:-1], 3] = 0.12
    axes.add_collection(LineCollection(segments[~free & visible[:-1]], colors=(1, 1, 1, 0.55), linewidths=4.2, capstyle="round"))
    axes.add_collection(LineCollection(segments, colors=rgba, linewidths=np.where(free, 1.1, 2.2), capstyle="round"))

    # Arrows: from the proxy along the force on the hand, 6 mm for a newton at most.
    scale = min(0.006, 0.02 / high)
    way = np.concatenate([[0], np.cumsum(np.linalg.norm(np.diff(proxy, axis=0), axis=1))])
    picks = np.searchsorted(way, np.arange(0, way[-1], 0.009))
    picks = picks[(picks < len(proxy)) & contact[np.minimum(picks, len(proxy) - 1)] & visible[np.minimum(picks, len(proxy) - 1)]]
    if len(picks):
        tip = camera.project(proxy[picks] + force[picks] * scale)
        axes.quiver(flat[picks, 0], flat[picks, 1], tip[:, 0] - flat[picks, 0], tip[:, 1] - flat[picks, 1], angles="xy",
                    scale_units="xy", scale=1, color=colours(norm(newtons[picks])), width=0.0026, headwidth=4.5, headlength=5,
                    edgecolor="white", linewidth=0.4, zorder=4)
    axes.set_xlim(0, PANEL[0] * 2)
    axes.set_ylim(PANEL[1] * 2, 0)
    bar = figure.add_axes([box[0] + 0.03, box[1] + 0.055, box[2] * 0.36, 0.014])
    figure.colorbar(ScalarMappable(norm, colours), cax=bar, orientation="horizontal")
    bar.set_title("force on the hand [N]", fontsize=9.5, fontweight="normal", loc="left")
    bar.tick_params(labelsize=9)
    bar.grid(False)


def legend(axes):
    """Beside the title, where it hides nothing."""
    axes.legend(loc="lower right", bbox_to_anchor=(1.0, 1.0), fontsize=8.5, frameon=False, ncol=5, borderaxespad=0.1,
                columnspacing=1.0, handlelength=1.2, handletextpad=0.5)


def forces(axes, samples):
    t = samples["t_s"]
    every = max(len(t) // 3000, 1)
    total = np.linalg.norm(vectors(samples, "fx", "fy", "fz"), axis=1)
    axes.fill_between(t[::every], total[::every], color="#dfe5ea", linewidth=0, label="sent to the hand")
    for name, colour in SOURCES.items():
        if f"{name}_x" not in samples:
            continue  # An older hapticctl did not tell of it.
        part = np.linalg.norm(vectors(samples, f"{name}_x", f"{name}_y", f"{name}_z"), axis=1)
        if part.max() > 0.02:
            axes.plot(t[::every], part[::every], color=colour, linewidth=1.0, label=name.replace("_", " "))
    axes.set(title="Every newton has an owner", xlabel="time [s]", ylabel="force [N]", xlim=(t[0], t[-1]), ylim=(0, None))
    legend(axes)


def depths(axes, samples):
    t, every = samples["t_s"], max(len(samples["t_s"]) // 3000, 1)
    axes.plot(t[::every], samples["pz"][::every] * 1e3, color="#00798c", linewidth=1.0, label="hand (HIP)")
    axes.plot(t[::every], samples["proxy_z"][::every] * 1e3, color=INK, linewidth=1.2, label="proxy")
    axes.set(title="The proxy stays on the surface", xlabel="time [s]", ylabel="height [mm]", xlim=(t[0], t[-1]))
    legend(axes)


def timing(axes, samples, realtime):
    from matplotlib.ticker import FuncFormatter

    edges = np.geomspace(0.2, max(2000.0, samples["wake_ns"].max() * 1.2e-3, samples["cycle_ns"].max() * 1.2e-3), 90)
    for name, colour, label in (("cycle_ns", "#d1495b", "whole cycle"), ("wake_ns", "#00798c", "wake-up latency")):
        us = np.maximum(samples[name] * 1e-3, edges[0])
        axes.hist(us, edges, color=colour, alpha=0.78, linewidth=0,
                  label=f"{label}: p99 {np.percentile(us, 99):.0f} µs")
    axes.set_xscale("log")
    axes.set_yscale("log")
    period_us = np.median(np.diff(samples["t_ns"])) * 1e-3
    axes.axvline(period_us, color=INK, linewidth=1.2)
    axes.annotate("deadline", (period_us, 0.97), (-4, 0), textcoords="offset points", fontsize=8.5,
                  xycoords=("data", "axes fraction"), ha="right", va="top")
    axes.xaxis.set_major_formatter(FuncFormatter(lambda v, _: f"{v:g}"))
    axes.set(title="Timing of each tick" + ("" if realtime else " (without real-time rights)"), xlabel="time [µs]", ylabel="ticks")
    legend(axes)


def summary(samples):
    """The run in numbers."""
    t, contact = samples["t_s"], samples["contact"] > 0
    newtons = np.linalg.norm(vectors(samples, "fx", "fy", "fz"), axis=1)
    way = lambda points: np.linalg.norm(np.diff(points, axis=0), axis=1)
    proxy = way(vectors(samples, "proxy_x", "proxy_y", "proxy_z"))[contact[1:] & contact[:-1]].sum()
    percentile = lambda name, q: np.percentile(samples[name], q) * 1e-3
    ticks = samples["tick"][-1] - samples["tick"][0]
    rows = [("rate", f"{ticks / (t[-1] - t[0]):.1f} Hz over {t[-1] - t[0]:.1f} s, {len(t)} samples, "
                     f"{int(samples['missed'][-1] - samples['missed'][0])} periods missed"),
            ("wake-up", f"p50 {percentile('wake_ns', 50):.1f} us, p99 {percentile('wake_ns', 99):.1f} us, "
                        f"max {percentile('wake_ns', 100):.0f} us"),
            ("cycle", f"p50 {percentile('cycle_ns', 50):.1f} us, p99 {percentile('cycle_ns', 99):.1f} us, "
                      f"max {percentile('cycle_ns', 100):.0f} us"),
            ("contact", f"{contact.mean() * (t[-1] - t[0]):.1f} s ({contact.mean() * 100:.0f} %), "
                        f"{int((np.diff(contact.astype(int)) > 0).sum() + contact[0])} touches"),
            ("force", f"mean {newtons[contact].mean() if contact.any() else 0:.2f} N in contact, max {newtons.max():.2f} N"),
            ("path", f"{proxy:.2f} m on the surface, {way(vectors(samples, 'px', 'py', 'pz')).sum():.2f} m of the hand")]
    for name, text in rows:
        print(f"{name:<16}  {text}")


def main():
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    parser.add_argument("samples")
    parser.add_argument("--mesh", required=True)
    parser.add_argument("--scale", type=float, required=True, help="metres per file unit")
    parser.add_argument("--at", default="0,0,0", help="where the middle of the mesh's box stands [m]")
    parser.add_argument("--output", required=True)
    parser.add_argument("--title", default="")
    parser.add_argument("--summary", action="store_true", help="also print the run in numbers")
    arguments = parser.parse_args()
    samples = load_samples(arguments.samples)
    try:
        corners = mesh.load_stl(arguments.mesh)
    except (OSError, mesh.MeshError) as error:
        sys.exit(f"picture: {error}")
    flat = corners.reshape(-1, 3)
    corners = (corners - (flat.min(0) + flat.max(0)) / 2) * arguments.scale + [float(v) for v in arguments.at.split(",")]

    if arguments.summary:
        summary(samples)
        sys.stdout.flush()
    style()
    import matplotlib.pyplot as plt
    from PIL import Image

    figure = plt.figure(figsize=(16, 9.6))
    view(figure, [0.0, 0.0, 0.575, 0.94], corners, samples)
    no_rt = 1 << 8  # HAPTIC_SAMPLE_NO_RT
    forces(figure.add_axes([0.63, 0.675, 0.35, 0.22]), samples)
    depths(figure.add_axes([0.63, 0.375, 0.35, 0.20]), samples)
    timing(figure.add_axes([0.63, 0.075, 0.35, 0.20]), samples, not (samples["flags"].astype(int) & no_rt).any())
    figure.text(0.025, 0.955, arguments.title or pathlib.Path(arguments.mesh).name, fontsize=15, fontweight="bold")
    size = (corners.reshape(-1, 3).max(0) - corners.reshape(-1, 3).min(0)) * 1e3
    rate = 1e9 / np.median(np.diff(samples["t_ns"]))
    figure.text(0.025, 0.928, f"{pathlib.Path(arguments.mesh).name}: {len(corners):,} triangles, ".replace(",", "\u2009", 1)
                + f"{size[0]:.0f} × {size[1]:.0f} × {size[2]:.0f} mm, felt {rate:.0f} times a second", fontsize=10.5, color=FAINT)
    figure.savefig(arguments.output, dpi=100)
    if arguments.output.endswith(".png"):  # A palette keeps it small.
        image = Image.open(arguments.output).convert("RGB")
        image.quantize(256, kmeans=1).save(arguments.output, optimize=True)


if __name__ == "__main__":
    main()
