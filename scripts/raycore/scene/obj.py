# SPDX-License-Identifier: Apache-2.0 WITH SHL-2.1
"""OBJ files, and the materials of MTL files read whole: trimesh, which orders the faces, is given only their names.

docs/scenes.md says how materials are mapped.
"""

import io
import re
from dataclasses import dataclass, field

import numpy as np

from raycore.scene.data import AMBIENT_LIGHT, Material
from raycore.scene.materials import mean_colour, read_picture, texture_of, times
from raycore.scene.mesh import Loaded, Part, corner_uv, default_material, meshes, place, plain_part, read_trimesh

# Options of texture statements, with the most numbers or words that follow them.
OPTIONS = {
    **dict.fromkeys(("blendu", "blendv", "boost", "texres", "clamp", "bm", "imfchan", "type", "cc"), 1),
    **{"mm": 2, "o": 3, "s": 3, "t": 3},
}
VECTORS = ("o", "s", "t")  # may have fewer numbers
MIRRORS, GLASS = (3, 5, 8), (4, 6, 7, 9)  # values of illum
FRESNEL = (5, 7)
DEFAULT_SHININESS = 32.0
UNUSED = {
    **{"map_bump": "bump", "bump": "bump", "norm": "normal", "map_kn": "normal", "disp": "displacement"},
    **{"map_disp": "displacement", "refl": "reflection", "map_refl": "reflection", "map_ns": "shininess"},
    **{"decal": "decal", "map_pr": "roughness", "map_pm": "metallic"},
}


@dataclass
class Statement:
    """A texture statement: name of the file, scale and offset of coordinates (v upwards), wrap mode."""

    file: str
    scale: tuple = (1.0, 1.0)
    offset: tuple = (0.0, 0.0)
    wrap: str = "repeat"


@dataclass
class Entry:
    """A material of an MTL file as it is written: {keyword: words}, and where it stands."""

    name: str
    folder: object
    words: dict = field(default_factory=dict)

    def numbers(self, key, count=None):
        """Numbers of a statement, None if there is none or it has none; one number stands for `count`."""
        try:
            values = [float(w) for w in self.words[key]]
        except (KeyError, ValueError):
            return None
        if not values or not all(map(np.isfinite, values)):
            return None
        return values * count if count and len(values) == 1 else values

    def colour(self, key):
        """A colour, None if there is none."""
        values = self.numbers(key, 3)
        return np.clip(values[:3], 0.0, None) if values and len(values) >= 3 else None

    def number(self, key):
        """The last number of a statement (options may stand before it), None if there is none."""
        values = self.numbers(key) or Entry("", None, {key: self.words.get(key, [])[-1:]}).numbers(key)
        return values[-1] if values else None


def parse_mtl(text, folder):
    """Materials of an MTL file: {name: `Entry`}."""
    found, entry = {}, None
    for line in text.replace("\\\n", " ").splitlines():
        words = re.sub(r"(^|\s)#.*", "", line).split()
        if not words:
            continue
        key = words[0].lower()
        if key == "newmtl":
            entry = Entry(" ".join(words[1:]), folder)
            found[entry.name] = entry
        elif entry is not None:
            entry.words[key] = words[1:]
    return found


def parse_statement(words):
    """A texture statement from its words, `Statement` or None. File names may have blanks."""
    words, options = list(words), {}
    while words and words[0].startswith("-") and words[0][1:].lower() in OPTIONS:
        name = words.pop(0)[1:].lower()
        values = []
        for _ in range(OPTIONS[name]):
            if len(words) < 2 or (name in VECTORS and not re.fullmatch(r"[-+.\deE]+", words[0])):
                break
            values.append(words.pop(0))
        options[name] = values
    if not words:
        return None
    two = {name: [float(v) for v in options.get(name, ())][:2] for name in ("s", "o")}
    scale, offset = (tuple([*two["s"], 1.0, 1.0][:2]) if two["s"] else (1.0, 1.0)), tuple([*two["o"], 0.0, 0.0][:2])
    wrap = "clamp" if [v.lower() for v in options.get("clamp", ())] == ["on"] else "repeat"
    return Statement(" ".join(words), scale, offset, wrap)


def find_file(folder, name):
    """A file named in another: there, or with the same name in any case, or next to it without its folders; else None."""
    name = name.strip().strip('"').replace("\\", "/")
    for candidate in (name, name.rsplit("/", 1)[-1]):
        path = folder / candidate
        if path.is_file():
            return path
        if path.parent.is_dir():
            for other in sorted(path.parent.iterdir()):
                if other.name.lower() == path.name.lower() and other.is_file():
                    return other
    return None


class Library:
    """Materials of an OBJ file's MTL files, and their pictures, each read once."""

    def __init__(self, notes):
        self.notes, self.entries, self._pictures = notes, {}, {}

    def add(self, folder, line):
        """The files of a mtllib statement: several names, or one with blanks."""
        for name in [line.strip()] if find_file(folder, line) else line.split():
            path = find_file(folder, name)
            if path is None:
                self.notes.add("material files that do not exist, so that grey takes their place", name)
                continue
            text = path.read_bytes().decode("utf-8", errors="replace")
            self.entries |= parse_mtl(text.replace("\r\n", "\n"), path.parent)

    def picture(self, entry, key):
        """(picture (H, W, 4) or None, its `Statement` or None) of a texture statement."""
        statement = parse_statement(entry.words.get(key, ()))
        if statement is None:
            return None, None
        path = find_file(entry.folder, statement.file)
        if path not in self._pictures:
            try:
                self._pictures[path] = read_picture(path) if path else None
            except (OSError, ValueError):
                self._pictures[path] = None
        if self._pictures[path] is None:
            self.notes.add("pictures that do not exist or cannot be read", statement.file)
        return self._pictures[path], statement

    def convert(self, name):
        """(`Material`, `Statement` of its texture or None)."""
        entry = self.entries[name]
        for key, kind in UNUSED.items():
            if key in entry.words:
                self.notes.add(f"{kind} maps are not used", name)
        image, statement = self.picture(entry, "map_kd")
        image, mode = self._alpha(entry, image)
        texture = None
        if image is not None:
            statement = statement or parse_statement(entry.words["map_d"])
            texture = texture_of(image, (statement.wrap,) * 2, statement.file)
        return self._phong(entry, texture, mode), statement

    def _alpha(self, entry, image):
        """The texture with its map_d in it, and the alpha mode that it asks for."""
        cut, _ = self.picture(entry, "map_d")
        if cut is not None:
            values = cut[..., 3] if cut[..., 3].min() < 255 else cut[..., :3].max(axis=2)
            if image is None:
                image = np.full((*values.shape, 4), 255, np.uint8)
            if values.shape != image.shape[:2]:
                from PIL import Image

                values = np.asarray(Image.fromarray(values).resize(image.shape[1::-1]))
            image = np.concatenate((image[..., :3], values[..., None]), axis=2)
        if image is None or image[..., 3].min() == 255:
            return image, "opaque"
        if cut is None and not image[..., 3].any():  # an alpha channel that nobody filled
            return np.concatenate((image[..., :3], np.full_like(image[..., :1], 255)), axis=2), "opaque"
        binary = np.mean((image[..., 3] < 16) | (image[..., 3] > 239))
        return image, "mask" if binary > 0.9 else "blend"

    def _mean(self, entry, key, colour):
        """A colour times the mean of its map."""
        image, _ = self.picture(entry, key)
        if image is None:
            return colour
        self.notes.add(f"{key} becomes its mean", entry.name)
        return np.asarray(colour) * mean_colour(image)

    def _phong(self, entry, texture, mode):
        name, notes = entry.name, self.notes
        for key in ("ka", "kd", "ks", "ke", "tf"):
            if key in entry.words and entry.colour(key) is None:
                notes.add(f"{key.title()} that is no colour of three numbers is not used", name)
        diffuse, ambient = entry.colour("kd"), entry.colour("ka")
        if diffuse is None:
            diffuse = np.full(3, 1.0 if texture is not None else 0.7)
        elif texture is not None and not diffuse.any():
            notes.add("a texture multiplied by a black Kd is used as if that were white", name)
            diffuse = np.ones(3)
        if ambient is None or (ambient == 1.0).all():  # as exporters write that know no ambient colour
            ambient = diffuse
        specular = entry.colour("ks")
        specular = self._mean(entry, "map_ks", np.zeros(3) if specular is None else specular)
        glow = entry.colour("ke")
        emission = self._mean(entry, "map_ke", np.full(3, float("map_ke" in entry.words)) if glow is None else glow)
        shine = entry.number("ns")
        shine = DEFAULT_SHININESS if shine is None else min(max(shine, 1.0), 1024.0)
        illum = entry.number("illum")
        illum = int(illum) if illum is not None else 2
        alpha = self._opacity(entry)
        optics = self._optics(entry, illum, specular, alpha)
        if "transmit" in optics:
            diffuse, ambient = diffuse * alpha, ambient * alpha
            if mode != "opaque":
                notes.add("the alpha of a texture of glass is not used", name)
        else:
            mode = "blend" if alpha < 1.0 else mode
            optics |= {"alpha": alpha if mode == "blend" else 1.0, "alpha_mode": mode}
        colours = (times(AMBIENT_LIGHT, ambient), times(diffuse), times(specular))
        return Material(name, *colours, shine, times(emission), texture=texture, **optics)

    def _opacity(self, entry):
        alpha = entry.number("d")
        if alpha is None:
            clear = entry.number("tr")
            alpha = 1.0 if clear is None else 1.0 - clear
        return min(max(alpha, 0.0), 1.0)

    def _optics(self, entry, illum, specular, alpha):
        """Fields of `Material` for a mirror or glass."""
        ior, tint = entry.number("ni"), entry.colour("tf")
        fresnel = illum in FRESNEL
        if illum in GLASS and (tint is not None or alpha < 1.0 or (ior or 1.0) != 1.0):
            # Writers disagree on whether Tf is what passes or what does not: its hue counts, d tells how much.
            hue = tint / tint.max() if tint is not None and tint.any() else np.ones(3)
            ior = min(max(ior or 1.0, 1.0 / 64.0), 64.0)
            through = hue * (1.0 - alpha if alpha < 1.0 else 1.0)
            if fresnel:
                reflect = np.full(3, ((ior - 1.0) / (ior + 1.0)) ** 2)
            else:
                reflect = np.clip(specular, 0.0, 1.0) if illum != 9 else np.zeros(3)
                through = np.minimum(through, 1.0 - reflect)
            return {"transmit": times(through), "ior": ior, "reflect": times(reflect), "fresnel": fresnel}
        if illum in GLASS:
            self.notes.add(f"illum {illum} without Ni, Tf or d is taken for a mirror", entry.name)
        if illum in MIRRORS or illum in GLASS:
            reflect = np.clip(specular, 0.0, 1.0)
            return {"reflect": times(reflect), "fresnel": fresnel} if reflect.any() else {}
        return {}


class _Names:
    """What trimesh asks for the files that an OBJ file names: materials with names and nothing else."""

    def __init__(self, text):
        self.text = text

    def get(self, _):
        """The text, whatever the name."""
        return self.text.encode()

    __getitem__ = get


def load(path, notes):
    """An OBJ file as `Loaded`. Raises: anything for broken files."""
    text = path.read_bytes().decode("utf-8", errors="replace").replace("\r\n", "\n")
    library = Library(notes)
    for line in re.findall(r"^[ \t]*mtllib[ \t]+(.*)$", text, re.MULTILINE):
        library.add(path.parent, line)
    used = {name.strip(): True for name in re.findall(r"^[ \t]*usemtl[ \t]+(.*)$", text, re.MULTILINE)}
    known = [name for name in used if name in library.entries]
    for name in used:
        if name not in library.entries:
            notes.add("materials that no file defines: grey takes their place", name)
    text = re.sub(r"^[ \t]*mtllib.*$", "", text, flags=re.MULTILINE)
    if known:
        text = "mtllib names\n" + text
    names = "".join(f"newmtl {name}\nKd 1 1 1\n" for name in known)
    loaded = read_trimesh(io.BytesIO(text.encode()), file_type="obj", resolver=_Names(names))
    done, parts = {}, []
    for mesh, transform in meshes(loaded):
        name = str(getattr(getattr(mesh.visual, "material", None), "name", None) or "")
        if mesh.visual.kind != "texture":
            parts.append(plain_part(mesh, transform))
            continue
        if name in library.entries and name not in done:
            done[name] = library.convert(name)
        material, statement = done.get(name, (default_material(), None))
        triangles, normals, faces = place(mesh, transform)
        part = Part(triangles, normals, [material], np.zeros(len(triangles), np.int32))
        uv = getattr(mesh.visual, "uv", None)
        if uv is not None and len(uv) == len(mesh.vertices):
            # Kept even without a texture: a scene file may add one.
            scale, offset = (statement.scale, statement.offset) if statement else ((1.0, 1.0), (0.0, 0.0))
            part.uv = corner_uv(np.asarray(uv)[:, :2] * scale + offset, faces, upwards=True)
        parts.append(part)
    return Loaded(parts)
