# SPDX-License-Identifier: Apache-2.0 WITH SHL-2.1
"""Scenes of BART, the benchmark for animated ray tracing (Lext, Assarsson, Möller 2001): `.aff`, an extended NFF.

Read: camera `v`, lights `l`, materials `fm` and `f`, polygons `p` `pp`, triangles `t` `tp` `tt` `ttp`, meshes `m`, animated
triangles `tpa`, spheres `s`, cones `c` (both as triangles), included files `i`, static transforms `xs`, animated ones `x`
with their keys `k`, and the length of the animation `a`. Keys and corners of animated triangles are interpolated
linearly, rotations on the short way.
"""

from itertools import pairwise
from pathlib import Path

import numpy as np

from raycore.errors import SceneError
from raycore.scene.animation import rotation
from raycore.scene.data import Camera, Light
from raycore.scene.materials import bart_material, read_picture, texture_of
from raycore.scene.mesh import Loaded, Part, default_material
from raycore.scene.normals import face_normals

SEGMENTS = 32  # of a cone, and around a sphere
DEEPEST = 32  # files that include each other
PICTURES = ("", "../TextureFiles", "TextureFiles")  # where textures are looked for, from a file's own folder


class _Text:
    """The words of a file without its comments, one after the other."""

    def __init__(self, path):
        self.path, self.words, self.lines, self.at = path, [], [], 0
        for number, line in enumerate(path.read_text(encoding="latin-1").splitlines(), 1):
            words = line.split("%", 1)[0].split("#", 1)[0].replace("{", " { ").replace("}", " } ").split()
            self.words += words
            self.lines += [number] * len(words)

    def wrong(self, what):
        line = self.lines[min(self.at, len(self.lines)) - 1] if self.lines else 0
        return SceneError(f"{self.path}, line {line}: {what}")

    def more(self):
        return self.at < len(self.words)

    def word(self, expected=None):
        """The next word. Raises: SceneError if there is none, or not the expected one."""
        if not self.more():
            raise self.wrong(f"ends where {expected or 'something'} should follow")
        self.at += 1
        if expected is not None and self.words[self.at - 1] != expected:
            raise self.wrong(f"'{self.words[self.at - 1]}' where '{expected}' should be")
        return self.words[self.at - 1]

    def numbers(self, *shape):
        """The next numbers, as an array."""
        count = int(np.prod(shape))
        words = self.words[self.at : self.at + count]
        self.at += len(words)
        try:
            out = np.array(words, dtype=np.float64)
        except ValueError:
            raise self.wrong(f"{count} numbers should be here") from None
        if len(words) < count or not np.isfinite(out).all():
            raise self.wrong(f"{count} numbers should be here")
        return out.reshape(shape)

    def count(self, most=1 << 24):
        """How many of something follow."""
        (n,) = self.numbers(1)
        if not (0 <= n <= most and n == int(n)):
            raise self.wrong(f"{n:g} is no number of things")
        return int(n)

    def has_number(self):
        """Whether a number comes next."""
        try:
            return self.more() and np.isfinite(float(self.words[self.at]))
        except ValueError:
            return False

    def skip_braces(self):
        """Go behind the block that begins here."""
        self.word("{")
        depth = 1
        while depth:
            depth += {"{": 1, "}": -1}.get(self.word("}" if not self.more() else None), 0)


class _Reader:
    """Walks the files of a scene at one time, and collects its parts."""

    def __init__(self, notes):
        self.notes, self.parts, self.lights, self.keys = notes, [], [], {}
        self.view, self.background, self.ambient, self.span = None, None, np.ones(3), (0.0, 0.0)
        self.raw, self.material, self.textured = None, default_material(), {}
        self.texts, self.pictures, self.inside, self.time = {}, {}, [], 0.0

    # ---- files: twice, keys first, since they may follow what they move -----------------------------------------------

    def text(self, path):
        if path not in self.texts:
            if not path.is_file():
                raise SceneError(f"{path}: no such file; {self.inside[-1] if self.inside else 'the scene'} includes it")
            self.texts[path] = _Text(path)
        self.texts[path].at = 0
        return self.texts[path]

    def include(self, path, visit, *arguments):
        if path in self.inside or len(self.inside) > DEEPEST:
            raise SceneError(f"{path}: includes itself")
        text = self.text(path)
        self.inside.append(path)
        visit(text, *arguments)
        self.inside.pop()

    def find_keys(self, text):
        """Collect `k` and `a` of a file and of those that it includes."""
        while text.more():
            word = text.word()
            if word == "k":
                name = text.word()
                self.keys[name] = self.read_keys(text)
            elif word == "a" and text.has_number():
                self.span = tuple(map(float, text.numbers(3)[:2]))
            elif word == "i" and text.has_number():
                text.numbers(1)
                at, path = text.at, text.path.parent / text.word()
                self.include(path, self.find_keys)
                text.at = at + 1

    @staticmethod
    def read_keys(text):
        """{kind: (times (n,), values (n, m))} of a block of keys; tension, continuity and bias are left out."""
        sizes, out = {"transl": (3, 3), "scale": (3, 3), "rot": (4, 3), "visible": (1, 0)}, {}
        text.word("{")
        while (kind := text.word()) != "}":
            if kind not in sizes:
                raise text.wrong(f"'{kind}' is no kind of key")
            size, rest = sizes[kind]
            table = text.numbers(text.count(), 1 + size + rest)
            if not len(table):
                raise text.wrong(f"{kind} without keys")
            out[kind] = (table[:, 0], table[:, 1 : 1 + size])
        return out

    # ---- what a file says ------------------------------------------------------------------------------------------------

    def read(self, text, matrix, until=None):
        """Everything up to the end, or to the brace that closes a transform."""
        while text.more():
            word = text.word()
            if word == until:
                return
            command = getattr(self, f"do_{word}", None)
            if command is None or not word.isalpha():
                raise text.wrong(f"'{word}' is not known")
            command(text, matrix)
        if until is not None:
            raise text.wrong(f"ends where '{until}' should be")

    def do_b(self, text, _):
        self.background = tuple(map(float, text.numbers(3)))

    def do_am(self, text, _):
        self.ambient = text.numbers(3)

    def do_a(self, text, _):
        text.numbers(3)

    def do_k(self, text, _):
        text.word()
        text.skip_braces()

    def do_v(self, text, _):
        view = {}
        for name, size in (("from", 3), ("at", 3), ("up", 3), ("angle", 1), ("hither", 1), ("resolution", 2)):
            text.word(name)
            view[name] = text.numbers(size)
        self.view = view

    def do_l(self, text, _):
        place = tuple(map(float, text.numbers(3)))
        self.lights.append(Light(place, tuple(map(float, text.numbers(3))) if text.has_number() else (1.0, 1.0, 1.0)))

    def do_fm(self, text, _):
        self.raw = text.numbers(12)
        self.set_material()

    def do_f(self, text, _):
        r, g, b, kd, ks, shine, transmit, ior = text.numbers(8)
        colour = np.array([r, g, b])
        self.raw = np.concatenate((0.1 * colour, kd * colour, np.full(3, ks), (shine, transmit, ior)))
        self.set_material()

    def set_material(self):
        self.textured = {}
        raw = np.concatenate((self.raw[:3] * self.ambient, self.raw[3:]))
        self.material = bart_material(f"material {len(self.parts)}", raw)

    def picture(self, text, name):
        """The material of now with a texture."""
        if name in self.textured:
            return self.textured[name]
        if name not in self.pictures:
            found = self.find_picture(text.path.parent, name)
            if found is None:
                self.notes.add("textures that are not there are left out", name)
            self.pictures[name] = None if found is None else texture_of(read_picture(found), name=name)
        material = self.material
        if self.pictures[name] is not None and self.raw is not None:
            raw = np.concatenate((self.raw[:3] * self.ambient, self.raw[3:]))
            material = bart_material(f"{self.material.name}, {name}", raw, self.pictures[name])
        self.textured[name] = material
        return material

    @staticmethod
    def find_picture(folder, name):
        """A picture by name, whatever its case, or None."""
        for place in PICTURES:
            inside = folder / place
            for file in sorted(inside.iterdir()) if inside.is_dir() else ():
                if file.name.lower() == Path(name).name.lower():
                    return file
        return None

    def do_i(self, text, matrix):
        text.numbers(1)  # level of detail
        at, path = text.at, text.path.parent / text.word()
        self.include(path, self.read, matrix)
        text.at = at + 1

    def do_xs(self, text, matrix):
        scale, turn, move = text.numbers(3), text.numbers(4), text.numbers(3)
        text.word("{")
        self.read(text, matrix @ placed(move, turn, scale), "}")

    def do_x(self, text, matrix):
        name = text.word()
        text.word("{")
        if name not in self.keys:
            self.notes.add("transforms without keys stay where they are", name)
        own, seen = transform_at(self.keys.get(name, {}), self.time)
        kept = len(self.parts)
        self.read(text, matrix @ own, "}")
        if not seen:
            del self.parts[kept:]

    # ---- surfaces --------------------------------------------------------------------------------------------------------

    def add(self, triangles, matrix, normals=None, uv=None, material=None):
        """Triangles (n, 3, 3) with normals and coordinates of their corners, where a matrix puts them."""
        triangles = np.asarray(triangles, dtype=np.float64)
        if not len(triangles):
            return
        linear = matrix[:3, :3]
        if normals is not None:
            normals = normals @ np.linalg.pinv(linear)
            size = np.linalg.norm(normals, axis=-1, keepdims=True)
            normals = np.where(size > 0.0, normals / np.where(size > 0.0, size, 1.0), 0.0)
        triangles = triangles @ linear.T + matrix[:3, 3]
        if normals is None:
            normals = np.repeat(face_normals(triangles)[:, None], 3, axis=1)
        zeros = np.zeros(len(triangles), np.int32)
        self.parts.append(Part(triangles, normals, [material or self.material], zeros, uv))

    def polygon(self, text, matrix, size):
        n = text.count()
        if n < 3:
            raise text.wrong(f"a polygon of {n} corners")
        corners = text.numbers(n, size)
        fan = np.array([(0, i, i + 1) for i in range(1, n - 1)])
        self.add(corners[fan][..., :3], matrix, corners[fan][..., 3:6] if size == 6 else None)

    def do_p(self, text, matrix):
        self.polygon(text, matrix, 3)

    def do_pp(self, text, matrix):
        self.polygon(text, matrix, 6)

    def do_t(self, text, matrix):
        self.add(text.numbers(1, 3, 3), matrix)

    def do_tp(self, text, matrix):
        corners = text.numbers(1, 3, 6)
        self.add(corners[..., :3], matrix, corners[..., 3:])

    def do_tt(self, text, matrix):
        material = self.picture(text, text.word())
        corners = text.numbers(1, 3, 5)
        self.add(corners[..., :3], matrix, None, corners[..., 3:], material)

    def do_ttp(self, text, matrix):
        material = self.picture(text, text.word())
        corners = text.numbers(1, 3, 8)
        self.add(corners[..., :3], matrix, corners[..., 3:6], corners[..., 6:], material)

    def do_tpa(self, text, matrix):
        """A triangle with corners and normals at several times."""
        table = text.numbers(text.count(), 19)
        if not len(table):
            raise text.wrong("an animated triangle without keys")
        corners = between(table[:, 0], table[:, 1:], self.time).reshape(1, 3, 6)
        self.add(corners[..., :3], matrix, corners[..., 3:])

    def do_m(self, text, matrix):
        """A mesh: rows of vertices, normals, coordinates, in triangles by number."""
        arrays, material = {}, self.material
        while (word := text.word()) in ("vertices", "normals", "texturecoords"):
            n = text.count()
            if word == "texturecoords":
                material = self.picture(text, text.word())
            arrays[word] = text.numbers(n, 2 if word == "texturecoords" else 3)
        if word != "triangles" or "vertices" not in arrays:
            raise text.wrong(f"'{word}' in a mesh")
        n = text.count()
        columns = text.numbers(n, len(arrays), 3).astype(np.int64)
        corner = {}
        for i, name in enumerate(name for name in ("vertices", "normals", "texturecoords") if name in arrays):
            index = columns[:, i]
            if index.size and not 0 <= index.min() <= index.max() < len(arrays[name]):
                raise text.wrong(f"a triangle asks for number {int(index.max())} of {len(arrays[name])} {name}")
            corner[name] = arrays[name][index]
        self.add(corner["vertices"], matrix, corner.get("normals"), corner.get("texturecoords"), material)

    def do_s(self, text, matrix):
        *centre, radius = text.numbers(4)
        rings = np.linspace(0.0, np.pi, SEGMENTS // 2 + 1)
        profile = np.stack((np.sin(rings), np.cos(rings)), axis=1)
        triangles = revolved(profile)
        self.add(np.array(centre) + abs(radius) * triangles, matrix, np.where(radius < 0.0, -1.0, 1.0) * triangles)

    def do_c(self, text, matrix):
        """A cone from a base to an apex, each with its radius; a cylinder if they are equal. Its ends are open."""
        (bx, by, bz, low), (ax, ay, az, high) = text.numbers(2, 4)
        base, apex = np.array([bx, by, bz]), np.array([ax, ay, az])
        height = float(np.linalg.norm(apex - base))
        if height == 0.0:
            return
        triangles = revolved(np.array([(high, height), (low, 0.0)]))
        normals = triangles * (1.0, 0.0, 1.0)
        normals /= np.maximum(np.linalg.norm(normals, axis=-1, keepdims=True), 1e-30)
        normals = normals * height + np.array([0.0, low - high, 0.0])
        turn = upwards_to((apex - base) / height)
        self.add(base + triangles @ turn.T, matrix, normals @ turn.T)


def revolved(profile):
    """Triangles (n, 3, 3) of a profile (m, 2) of radius and height, from top to bottom, turned about y."""
    angle = np.linspace(0.0, 2.0 * np.pi, SEGMENTS + 1)
    grid = np.stack((profile[:, :1] * np.cos(angle), np.repeat(profile[:, 1:], SEGMENTS + 1, 1), profile[:, :1] * np.sin(angle)), 2)
    a, b, c, d = grid[:-1, :-1], grid[:-1, 1:], grid[1:, 1:], grid[1:, :-1]
    out = np.concatenate([np.stack(corners, 2).reshape(-1, 3, 3) for corners in ((a, b, c), (a, c, d))])
    return out[face_normals(out).any(axis=1)]  # at the axis two corners meet


def upwards_to(direction):
    """Rotation (3, 3) that takes y to a unit vector."""
    axis = np.cross((0.0, 1.0, 0.0), direction)
    if np.linalg.norm(axis) < 1e-12:
        return np.eye(3) if direction[1] > 0.0 else np.diag((1.0, -1.0, -1.0))
    return rotation(axis, np.degrees(np.arccos(np.clip(direction[1], -1.0, 1.0))))


def between(times, values, time):
    """Values (n, ...) of keys at a time: linear, before the first and after the last as they are."""
    flat = values.reshape(len(times), -1)
    return np.array([np.interp(time, times, column) for column in flat.T]).reshape(values.shape[1:])


def turned_at(times, turns, time):
    """Rotation matrix (3, 3) of keys of axis and degrees: about one axis as far as they say, else on the short way."""

    def matrix(turn):
        return rotation(turn[:3], turn[3]) if np.any(turn[:3]) else np.eye(3)

    for (t0, a), (t1, b) in pairwise(zip(times, turns, strict=True)):
        if t0 <= time < t1:
            share = (time - t0) / (t1 - t0)
            if np.allclose(a[:3], b[:3]):
                return matrix((*a[:3], a[3] + share * (b[3] - a[3])))
            start = matrix(a)
            return short_way(matrix(b) @ start.T, share) @ start
    return matrix(turns[0] if time < times[0] else turns[-1])


def short_way(turn, share):
    """A share of a rotation matrix's own turn."""
    angle = float(np.arccos(np.clip((np.trace(turn) - 1.0) / 2.0, -1.0, 1.0)))
    values, vectors = np.linalg.eig(turn)
    axis = np.real(vectors[:, np.argmin(np.abs(values - 1.0))])
    if np.trace(rotation(axis, np.degrees(angle)).T @ turn) < np.trace(rotation(axis, -np.degrees(angle)).T @ turn):
        axis = -axis
    return rotation(axis, share * np.degrees(angle))


def placed(move, turn, scale):
    """Matrix (4, 4): scale, then turn by axis and degrees, then move."""
    out = np.eye(4)
    out[:3, :3] = (rotation(turn[:3], turn[3]) if np.any(turn[:3]) else np.eye(3)) * scale
    out[:3, 3] = move
    return out


def transform_at(keys, time):
    """Matrix (4, 4) of a block of keys at a time, and whether what it moves is to be seen."""
    out, scale = np.eye(4), np.ones(3)
    if "scale" in keys:
        scale = between(*keys["scale"], time)
    out[:3, :3] = (turned_at(*keys["rot"], time) if "rot" in keys else np.eye(3)) * scale
    if "transl" in keys:
        out[:3, 3] = between(*keys["transl"], time)
    if "visible" in keys:
        times, values = keys["visible"]
        return out, bool(values[max(int(np.searchsorted(times, time, "right")) - 1, 0), 0])
    return out, True


def load(path, notes, time=0.0):
    """An AFF file as `Loaded`; time: in seconds after its first frame. Raises: SceneError."""
    reader = _Reader(notes)
    reader.include(path, reader.find_keys)
    start, end = reader.span
    reader.time = min(start + time, end) if end > start else start
    reader.include(path, reader.read, np.eye(4))
    camera = None
    if reader.view is not None:
        view = reader.view
        eye, target, up = view["from"], view["at"], view["up"]
        if "camera" in reader.keys and end > start:  # it looks along -z before it is turned
            matrix, _ = transform_at(reader.keys["camera"], reader.time)
            eye, target, up = matrix[:3, 3], matrix[:3, 3] - matrix[:3, 2], matrix[:3, 1]
        camera = Camera(*(tuple(map(float, v)) for v in (eye, target, up)), float(view["angle"][0]))
    return Loaded(reader.parts, camera, reader.lights, reader.background, max(end - start, 0.0))
