# SPDX-License-Identifier: Apache-2.0 WITH SHL-2.1
"""What a scene is made of: triangles, materials, textures, cameras, lights."""

import hashlib
from dataclasses import dataclass, field

import numpy as np

MAX_MATERIALS = 256
AMBIENT_LIGHT = 0.12  # of a default scene; folded into the materials
DEFAULT_FOV = 45.0


@dataclass(eq=False)
class Texture:
    """A picture for a material: image (H, W, 4) uint8 RGBA, sRGB unless `srgb` is off, straight alpha, row 0 at v = 0.

    The sides may have any length; `raycore.texture` scales them to powers of two. Equal pictures with equal settings are equal.
    """

    image: np.ndarray
    wrap_s: str = "repeat"  # of u: repeat, mirror or clamp
    wrap_t: str = "repeat"  # of v
    srgb: bool = True  # False: the colours are linear
    compact: bool = False  # 16 bits a texel (RGBA5551) instead of 32
    name: str = ""

    def _key(self):
        if not hasattr(self, "_digest"):
            image = np.ascontiguousarray(self.image)
            self._digest = (image.shape, hashlib.sha256(image.tobytes()).hexdigest())
        return (*self._digest, self.wrap_s, self.wrap_t, self.srgb, self.compact)

    def __eq__(self, other):
        return isinstance(other, Texture) and self._key() == other._key()

    def __hash__(self):
        return hash(self._key())


@dataclass
class Material:
    """A Phong material with optics; linear RGB. docs/whitted.md says how it is used.

    The texture multiplies ambient, diffuse and transmit, and reflect if it tints the reflection; its alpha multiplies alpha.
    """

    name: str
    ambient: tuple  # ambient light of the scene times reflectance
    diffuse: tuple
    specular: tuple = (0.0, 0.0, 0.0)
    shininess: float = 32.0  # 0 to 1024
    emission: tuple = (0.0, 0.0, 0.0)
    reflect: tuple = (0.0, 0.0, 0.0)  # share that is mirrored, at normal incidence
    transmit: tuple = (0.0, 0.0, 0.0)  # share that goes through, refracted; only with alpha_mode "opaque"
    ior: float = 1.0  # refractive index of what is behind the surface, against what is before it
    fresnel: bool = False  # reflect grows towards grazing angles (Schlick), transmit shrinks by as much
    alpha: float = 1.0
    alpha_mode: str = "opaque"  # or "mask": there or not, by the cutoff; or "blend"
    alpha_cutoff: float = 0.5
    texture: Texture | None = None
    tint_reflection: bool = False  # the texture multiplies reflect, as on metals

    @property
    def opaque(self):
        """Whether nothing passes it: such a hit ends a shadow ray."""
        return self.alpha_mode == "opaque" and not any(self.transmit)


def make_material(
    name,
    diffuse,
    specular=(0.0, 0.0, 0.0),
    shininess=32.0,
    emission=(0.0, 0.0, 0.0),
    ambient_light=AMBIENT_LIGHT,
    **optics,
):
    """A `Material` that reflects the ambient light of a default scene. optics: its further fields, by name."""

    def colour(values):
        return tuple(map(float, values))

    more = {k: colour(v) if k in ("reflect", "transmit") else v for k, v in optics.items()}
    more.setdefault("ambient", tuple(float(ambient_light * d) for d in diffuse))
    return Material(
        name,
        diffuse=colour(diffuse),
        specular=colour(specular),
        shininess=float(shininess),
        emission=colour(emission),
        **more,
    )


@dataclass
class Light:
    """A point light, or a directional one with the unit direction towards it as `position`; linear RGB."""

    position: tuple
    colour: tuple = (1.0, 1.0, 1.0)
    directional: bool = False
    attenuation: tuple = (1.0, 0.0, 0.0)  # 1 / (c + l * distance + q * distance^2)


@dataclass
class Camera:
    """A pinhole camera: world units, vertical field of view in degrees."""

    eye: tuple
    target: tuple
    up: tuple = (0.0, 1.0, 0.0)
    fov: float = DEFAULT_FOV


@dataclass
class Placed:
    """A rigid object, which stands in coordinates of its own: world = rotation @ local + translation.

    rotation (3, 3) mirrors nothing; translation (3,) in world units. triangles and normals (n, 3, 3): its shape, in world units
    too, in the order of its triangles in the scene.
    """

    rotation: np.ndarray
    translation: np.ndarray
    triangles: np.ndarray
    normals: np.ndarray

    def moved(self, rotation, scale, translation):
        """The object in another place: turned, scaled and moved."""
        return Placed(
            rotation @ self.rotation,
            scale * (rotation @ self.translation) + translation,
            scale * self.triangles,
            self.normals,
        )


@dataclass
class Scene:
    """A scene as loaded, in world units.

    triangles (N, 3, 3) and normals (N, 3, 3) float64, face_material (N,) int32 index into `materials`. Normals are unit
    vectors on the side of the triangle's own normal (right hand rule). camera is None and lights is empty if the file
    has none. uv (N, 3, 2) float64 texture coordinates of the corners, v downwards in the image, or None if nothing is
    textured. objects (N,) int32: which dynamic object a triangle belongs to, 0 none, ascending; None: nothing is dynamic.
    placed: of the last len(placed) objects, which are rigid, where they stand; their triangles are among `triangles` as all others.
    warnings: one line for each kind of thing in the file that could not be mapped.
    """

    name: str
    triangles: np.ndarray
    normals: np.ndarray
    face_material: np.ndarray
    materials: list
    camera: Camera | None = None
    lights: list = field(default_factory=list)
    up: tuple = (0.0, 1.0, 0.0)
    background: tuple = (0.10, 0.13, 0.18)
    uv: np.ndarray | None = None
    warnings: list = field(default_factory=list)
    depth: int | None = None  # bounces that the scene asks for
    duration: float = 0.0  # seconds until its last key, 0: nothing moves
    objects: np.ndarray | None = None  # see above
    placed: list = field(default_factory=list)  # of `Placed`

    @property
    def bounds(self):
        """(2, 3) box of all vertices."""
        return np.stack((self.triangles.min(axis=(0, 1)), self.triangles.max(axis=(0, 1))))
