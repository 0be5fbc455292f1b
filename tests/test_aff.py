# SPDX-License-Identifier: Apache-2.0 WITH SHL-2.1
"""BART's AFF files: each command against what it says by hand, transforms and keys over time, and broken files."""

import numpy as np
import pytest
from PIL import Image

from raycore.errors import SceneError
from raycore.scene import load_scene
from raycore.scene.aff import turned_at

HEAD = "b 0.5 0.25 1\nv from 0 1 -6 at 0 1 0 up 0 1 0 angle 45 hither 0.1 resolution 800 600\nl 1 2 3 0.5 0.5 0.5\nl 4 5 6\n"
FM = "fm 0.4 0.3 0.2 0.5 0.5 0.5 0.1 0.2 0.3 50 0 0\n"
TRIANGLE = "p 3\n 0 0 0\n 1 0 0\n 0 1 0\n"


@pytest.fixture
def write(tmp_path):
    """Writes files of a folder; returns the path of the first one."""

    def files(**texts):
        for name, text in texts.items():
            (tmp_path / f"{name}.aff").write_text(text)
        return str(tmp_path / f"{next(iter(texts))}.aff")

    return files


def test_view_lights_material(write):
    scene = load_scene(write(scene="% a comment\n" + HEAD + FM + "# another\n" + TRIANGLE))
    assert scene.background == (0.5, 0.25, 1.0) and scene.duration == 0.0
    assert (scene.camera.eye, scene.camera.target, scene.camera.fov) == ((0, 1, -6), (0, 1, 0), 45)
    assert [light.position for light in scene.lights] == [(1, 2, 3), (4, 5, 6)]
    assert [light.colour for light in scene.lights] == [(0.5, 0.5, 0.5), (1, 1, 1)]
    (material,) = scene.materials
    assert material.ambient == (0.4, 0.3, 0.2) and material.specular == material.reflect == (0.1, 0.2, 0.3)
    assert material.shininess == 50 and not any(material.transmit)
    assert np.array_equal(scene.triangles, [[[0, 0, 0], [1, 0, 0], [0, 1, 0]]])


def test_ambient_light_and_glass(write):
    text = "am 2 2 2\nfm 0.1 0.1 0.1 0.5 0.5 0.5 0 0 0 50 0.85 1.55\n" + TRIANGLE
    (material,) = load_scene(write(scene=text)).materials
    assert np.allclose(material.ambient, 0.2) and np.allclose(material.transmit, 0.85) and material.ior == 1.55


def test_polygons_are_fans(write):
    scene = load_scene(write(scene=FM + "p 4 0 0 0  1 0 0  1 1 0  0 1 0\n"))
    assert np.array_equal(scene.triangles, [[[0, 0, 0], [1, 0, 0], [1, 1, 0]], [[0, 0, 0], [1, 1, 0], [0, 1, 0]]])
    assert np.array_equal(scene.normals, np.broadcast_to([0.0, 0.0, 1.0], (2, 3, 3)))


def test_mesh_with_normals_and_picture(write, tmp_path):
    Image.new("RGB", (4, 2), (255, 0, 0)).save(tmp_path / "Red.ppm")
    mesh = (
        "m vertices 4 0 0 0  1 0 0  1 1 0  0 1 0\n normals 2 0 0 1  0.6 0 0.8\n"
        " texturecoords 3 red.PPM 0 0  1 0  1 1\n triangles 2  0 1 2 0 0 1 0 1 2   0 2 3 1 1 1 2 1 0\n"
    )
    scene = load_scene(write(scene=FM + mesh))
    assert np.array_equal(scene.triangles[1], [[0, 0, 0], [1, 1, 0], [0, 1, 0]])
    assert np.allclose(scene.normals[0], [[0, 0, 1], [0, 0, 1], [0.6, 0, 0.8]])
    assert np.array_equal(scene.uv, [[[0, 0], [1, 0], [1, 1]], [[1, 1], [1, 0], [0, 0]]])  # v downwards, as in the file
    assert scene.materials[0].texture.image.shape[:2] == (2, 4)


def test_a_picture_that_is_not_there(write):
    scene = load_scene(write(scene=FM + "tt none.ppm 0 0 0 0 1  1 0 0 1 1  0 1 0 0 0\n"))
    assert scene.materials[0].texture is None and any("none.ppm" in line for line in scene.warnings)


def test_transforms_scale_turn_move(write):
    text = FM + "xs 2 2 2  0 0 1 90  10 0 0 {\n xs 1 1 1 1 0 0 0 0 0 1 { " + TRIANGLE + " } }\n" + TRIANGLE
    scene = load_scene(write(scene=text))
    # (1, 0, 0) is lifted by 1, doubled, turned to +y, moved.
    assert np.allclose(scene.triangles[0], [[10, 0, 2], [10, 2, 2], [8, 0, 2]])
    assert np.array_equal(scene.triangles[1], [[0, 0, 0], [1, 0, 0], [0, 1, 0]])


KEYS = (
    FM + "x lift { x spin { " + TRIANGLE + " } }\na 1.0 3.0 50\n"
    "k lift { transl 3  0 0 0 0 0 0 0   2 0 0 4 0 0 0  4 8 0 4 0 0 0 visible 2 0 1 2.5 0 }\n"
    "k spin { rot 2  1 0 0 1 0 0 0 0  3 0 0 1 180 0 0 0  scale 1 0 1 1 1 0 0 0 }\n"
)


@pytest.mark.parametrize(
    ("time", "corner"),
    [
        (0.0, (1, 0, 2)),  # the animation begins at 1: half way to (0, 0, 4)
        (1.0, (0, 1, 4)),  # at 2: turned by 90 degrees
        (1.25, (np.cos(np.radians(112.5)) + 1, np.sin(np.radians(112.5)), 4)),
    ],
)
def test_keys_over_time(write, time, corner):
    scene = load_scene(write(scene=KEYS + TRIANGLE), time)
    assert scene.duration == 2.0 and len(scene.triangles) == 2
    assert np.allclose(scene.triangles[0, 1], corner)


def test_what_cannot_be_seen_is_left_out(write):
    assert len(load_scene(write(scene=KEYS + TRIANGLE), 1.75).triangles) == 1


def test_camera_by_keys(write):
    keys = "a 0 2 20\nk camera { transl 2 0 0 0 0 0 0 0 2 4 0 0 0 0 0  rot 2 0 0 1 0 0 0 0 0 2 0 1 0 180 0 0 0 }\n"
    camera = load_scene(write(scene=HEAD + FM + TRIANGLE + keys), 1.0).camera
    assert np.allclose(camera.eye, (2, 0, 0)) and np.allclose(np.subtract(camera.target, camera.eye), (-1, 0, 0))


def test_animated_triangle(write):
    rows = "tpa 2  0  0 0 0 0 0 1  1 0 0 0 0 1  0 1 0 0 0 1   2  0 0 2 0 0 1  3 0 2 0 0 1  0 1 2 0 0 1\n"
    path = write(scene=FM + rows + "a 0 4 10\n")
    assert np.allclose(load_scene(path, 0.5).triangles, [[[0, 0, 0.5], [1.5, 0, 0.5], [0, 1, 0.5]]])
    assert np.allclose(load_scene(path, 3.0).triangles, [[[0, 0, 2], [3, 0, 2], [0, 1, 2]]])  # behind the last key


def test_round_bodies(write):
    sphere = load_scene(write(scene=FM + "s 1 2 3 0.5\n")).triangles
    assert np.allclose(np.linalg.norm(sphere - (1, 2, 3), axis=-1), 0.5)
    cone = load_scene(write(scene=FM + "c 1 0 0 2  5 0 0 1\n"))
    radius = np.linalg.norm(cone.triangles[..., 1:], axis=-1)
    assert np.allclose(radius, 2.0 - (cone.triangles[..., 0] - 1.0) / 4.0)
    along = (cone.normals[..., 1:] * cone.triangles[..., 1:]).sum(-1) / radius
    assert np.allclose(np.abs(along), 4.0 / np.sqrt(17.0)) and np.allclose(np.abs(cone.normals[..., 0]), 1.0 / np.sqrt(17.0))


def test_files_include_files(write):
    path = write(scene=FM + "xs 1 1 1 0 1 0 0 0 0 5 { i 0 part.aff }\ni 0 part.aff\n", part=TRIANGLE)
    scene = load_scene(path)
    assert np.array_equal(scene.triangles[0] - scene.triangles[1], [[0, 0, 5]] * 3)


def test_rotations_between_axes():
    """Half way between turns about x and y by the same angle: an axis between them."""
    turn = turned_at(np.array([0.0, 1.0]), np.array([[1.0, 0, 0, 90.0], [0, 1.0, 0, 90.0]]), 0.5)
    assert np.allclose(turn @ turn.T, np.eye(3)) and np.isclose(np.linalg.det(turn), 1.0)
    axis = np.array([turn[2, 1] - turn[1, 2], turn[0, 2] - turn[2, 0], turn[1, 0] - turn[0, 1]])
    assert np.allclose(axis / np.linalg.norm(axis), [np.sqrt(0.5), np.sqrt(0.5), 0.0])


@pytest.mark.parametrize(
    ("text", "what"),
    [
        (FM + "q 1 2 3\n" + TRIANGLE, "line 2: 'q' is not known"),
        (FM + "p 3 0 0 0 1 0 0\n", "9 numbers should be here"),
        (FM + "p 2 0 0 0 1 0 0\n", "a polygon of 2 corners"),
        (FM + "p -1\n", "no number of things"),
        (FM + "xs 1 1 1 0 1 0 0 0 0 0 {\n" + TRIANGLE, "where '}' should be"),
        (FM + "m vertices 1 0 0 0 triangles 1 0 0 7\n", "asks for number 7 of 1 vertices"),
        (FM + "i 0 none.aff\n", "no such file"),
        (FM + "i 0 scene.aff\n", "includes itself"),
        (FM + TRIANGLE + "k x { spin 1 0 0 0 0 }\n", "'spin' is no kind of key"),
        (FM + TRIANGLE + "k x { rot 0 }\n", "rot without keys"),
        (FM + "p 3 0 0 0 1 0 0 0 nan 0\n", "9 numbers should be here"),
        (FM, "no triangles"),
    ],
)
def test_broken_files_say_what_is_wrong(write, text, what):
    with pytest.raises(SceneError) as error:
        load_scene(write(scene=text))
    assert what in str(error.value) and "\n" not in str(error.value)
