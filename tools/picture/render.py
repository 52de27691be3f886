"""A small renderer: depth buffer, smooth normals, soft light. Draws 100 000 triangles in a few seconds with numpy."""
import numpy as np

CHUNK = 1_500_000  # Candidate pixels at a time: bounds the memory.


class Camera:
    """Looks along -`eye` at the middle of the points, in parallel projection; pixels grow to the right and downward."""

    def __init__(self, eye, points, width, height, margin=0.06):
        eye = np.asarray(eye, float) / np.linalg.norm(eye)
        right = np.cross([0.0, 0.0, 1.0], eye)
        right /= np.linalg.norm(right)
        self.axes = np.stack([right, np.cross(eye, right), eye])
        flat = points.reshape(-1, 3) @ self.axes.T
        lower, upper = flat.min(0), flat.max(0)
        self.scale = min(width * (1 - 2 * margin) / (upper[0] - lower[0]), height * (1 - 2 * margin) / (upper[1] - lower[1]))
        self.middle = (lower + upper) / 2
        self.width, self.height = width, height

    def project(self, points):
        """x and y in pixels, depth in pixels (greater is nearer)."""
        out = (points @ self.axes.T - self.middle) * self.scale
        out[..., 0] = self.width / 2 + out[..., 0]
        out[..., 1] = self.height / 2 - out[..., 1]
        return out


def rasterise(camera, corners, normals):
    """Depth and normal (in camera axes) of what is seen in each pixel; depth is -inf where nothing is."""
    t = camera.project(corners)
    n = normals @ camera.axes.T
    depth = np.full(camera.width * camera.height, -np.inf)
    normal = np.zeros((camera.width * camera.height, 3))
    x0 = np.clip(np.ceil(t[..., 0].min(1) - 0.5), 0, camera.width).astype(np.int64)
    x1 = np.clip(np.floor(t[..., 0].max(1) - 0.5) + 1, 0, camera.width).astype(np.int64)
    y0 = np.clip(np.ceil(t[..., 1].min(1) - 0.5), 0, camera.height).astype(np.int64)
    y1 = np.clip(np.floor(t[..., 1].max(1) - 0.5) + 1, 0, camera.height).astype(np.int64)
    size = np.maximum(x1 - x0, 0) * np.maximum(y1 - y0, 0)
    det = (t[:, 1, 0] - t[:, 0, 0]) * (t[:, 2, 1] - t[:, 0, 1]) - (t[:, 2, 0] - t[:, 0, 0]) * (t[:, 1, 1] - t[:, 0, 1])
    drawn = np.flatnonzero((size > 0) & (np.abs(det) > 1e-12))
    # Cut into chunks of whole triangles.
    ends = np.cumsum(size[drawn])
    start = 0
    while start < len(drawn):
        stop = max(np.searchsorted(ends, (ends[start - 1] if start else 0) + CHUNK), start + 1)
        _chunk(camera, t, n, det, (x0, x1, y0), size, drawn[start:stop], depth, normal)
        start = stop
    shape = (camera.height, camera.width)
    return depth.reshape(shape), normal.reshape(*shape, 3)


def _chunk(camera, t, n, det, box, size, triangles, depth, normal):
    x0, x1, y0 = box
    owner = np.repeat(triangles, size[triangles])
    within = np.arange(len(owner)) - np.repeat(np.cumsum(size[triangles]) - size[triangles], size[triangles])
    span = (x1 - x0)[owner]
    px, py = x0[owner] + within % span, y0[owner] + within // span
    a, b, c = t[owner, 0], t[owner, 1], t[owner, 2]
    dx, dy = px + 0.5 - a[:, 0], py + 0.5 - a[:, 1]
    v = (dx * (c[:, 1] - a[:, 1]) - dy * (c[:, 0] - a[:, 0])) / det[owner]
    w = (dy * (b[:, 0] - a[:, 0]) - dx * (b[:, 1] - a[:, 1])) / det[owner]
    u = 1 - v - w
    inside = (u >= -1e-9) & (v >= -1e-9) & (w >= -1e-9)
    pixel = (py * camera.width + px)[inside]
    u, v, w, owner = u[inside], v[inside], w[inside], owner[inside]
    z = u * t[owner, 0, 2] + v * t[owner, 1, 2] + w * t[owner, 2, 2]
    front = z > depth[pixel]
    order = np.flatnonzero(front)
    order = order[np.argsort(z[order], kind="stable")]  # The nearest is written last and stays.
    pixel, u, v, w, owner = pixel[order], u[order, None], v[order, None], w[order, None], owner[order]
    depth[pixel] = z[order]
    normal[pixel] = u * n[owner, 0] + v * n[owner, 1] + w * n[owner, 2]


def blur(image, radius):
    """Three box blurs: nearly a Gaussian."""
    radius = max(int(radius), 1)
    for axis in (0, 1) * 3:
        pad = [(0, 0)] * image.ndim
        pad[axis] = (radius + 1, radius)
        total = np.cumsum(np.pad(image, pad, mode="edge"), axis=axis)
        image = (np.take(total, np.arange(2 * radius + 1, total.shape[axis]), axis)
                 - np.take(total, np.arange(total.shape[axis] - 2 * radius - 1), axis)) / (2 * radius + 1)
    return image


def shade(depth, normal, colour=(0.71, 0.75, 0.80), background=(1.0, 1.0, 1.0)):
    """The picture as RGB: key, sky and rim light, hollows darkened, a soft shadow underneath."""
    mask = np.isfinite(depth)
    size = min(depth.shape)
    n = normal / np.maximum(np.linalg.norm(normal, axis=-1, keepdims=True), 1e-30)
    n = np.where(n[..., 2:] < 0, -n, n)  # Inner faces of open meshes are lit too.
    unit = lambda v: np.asarray(v, float) / np.linalg.norm(v)
    key = np.clip(n @ unit([-0.55, 0.75, 0.6]), 0, 1)
    fill = np.clip(n @ unit([0.8, 0.1, 0.5]), 0, 1)
    half = np.clip(n @ unit(unit([-0.55, 0.75, 0.6]) + [0, 0, 1]), 0, 1)
    light = 0.30 + 0.62 * key + 0.16 * fill

    # Hollows lie deeper than their surroundings (Luft et al. 2006, unsharp masking of the depth buffer).
    filled = np.where(mask, depth, 0.0)
    weight = mask.astype(float)
    for radius, strength in ((size * 0.05, 0.9), (size * 0.012, 1.6)):
        around = blur(filled, radius) / np.maximum(blur(weight, radius), 1e-6)
        light *= 1 - np.clip(strength * (around - filled) / size * 4, -0.10, 0.55)
    rgb = light[..., None] * np.asarray(colour) + (0.22 * half ** 40)[..., None]
    rgb *= (1 - 0.55 * np.clip(1 - n[..., 2] * 3.0, 0, 1))[..., None]  # Silhouettes draw themselves.

    shift = int(size * 0.03)
    below = np.roll(weight, shift, axis=0)
    below[:shift] = 0
    shadow = 0.28 * blur(below, size * 0.03)
    ground = np.asarray(background) * (1 - shadow[..., None] * np.array([1.0, 0.95, 0.85]))
    return np.clip(np.where(mask[..., None], rgb, ground), 0, 1)


def halve(image):
    """Every 2 x 2 pixels to one."""
    h, w = image.shape[0] // 2 * 2, image.shape[1] // 2 * 2
    image = image[:h, :w]
    return (image[0::2, 0::2] + image[1::2, 0::2] + image[0::2, 1::2] + image[1::2, 1::2]) / 4
