# SPDX-License-Identifier: Apache-2.0 WITH SHL-2.1
"""raycore.texture and raycore.model.texture against closed forms, plain lookups in images, and each other."""

import math

import numpy as np
import pytest

from raycore import texture as tx
from raycore.model import fp24
from raycore.model import texture as model

RAYS = 400


@pytest.fixture
def rng(seed):
    return np.random.default_rng(seed)


def random_image(rng, height, width):
    return rng.integers(0, 256, (height, width, 4), dtype=np.uint8)


def one_texture(image, **use):
    """(texels, descriptor, levels) of one texture that does not begin the region."""
    first = tx.Texture(np.full((4, 4, 4), 77, np.uint8))
    texture = tx.Texture(image, **use)
    region, desc, _ = tx.build_textures([first, texture])
    return region, desc[1], tx.mip_levels(texture)


def at(u, v):
    """Record of a triangle whose every point has these coordinates."""
    return np.array([u, v, 0, 0, 0, 0, 0.0])


# ---- arithmetic ------------------------------------------------------------------------------------------------------


def test_log2_is_close_and_rises():
    """Within half a segment (1 / 128 at 1: 0.72 steps of 1/64) and half a step, on all exponents."""
    x = np.concatenate([np.linspace(1, 2, 5000, endpoint=False) * 2.0**e for e in (-62, -1, 0, 1, 63)])
    x = fp24.round_to_fp24(x)
    got = np.array([model.log2_fixed(v) for v in x])
    assert np.abs(got - 64 * np.log2(x)).max() < 64 * math.log2(1 + 1 / 128) + 0.5
    assert np.all(np.diff(got[np.argsort(x)]) >= 0)
    assert model.log2_fixed(0.0) == model.log2_fixed(-0.0) == -4096
    assert model.log2_fixed(math.inf) == 4096 + model.LOG[0]


def test_channels_are_nearest():
    c = np.arange(256)
    assert np.array_equal(model.LINEAR, (2 * c * 4096 + 255) // 510)
    assert (model.SRGB[0], model.SRGB[255], model.LINEAR[255]) == (0, 4096, 4096)
    assert np.abs(model.SRGB / 4096 - model.srgb_to_linear(c / 255)).max() <= 0.5 / 4096
    assert model.linear_to_srgb(model.srgb_to_linear(c / 255)) * 255 == pytest.approx(c, abs=1e-6)


@pytest.mark.parametrize("wrap", [model.REPEAT, model.MIRROR, model.CLAMP])
@pytest.mark.parametrize("log2_size", [0, 1, 2, 5])
def test_wrap_is_the_extended_image(wrap, log2_size):
    size = 1 << log2_size
    image = list(range(size))
    extended = {0: image * 20, 1: (image + image[::-1]) * 10, 2: [0] * (10 * size) + image + [size - 1] * (9 * size)}[
        wrap
    ]
    got = [model.wrap_texel(i, log2_size, wrap) for i in range(-10 * size, 10 * size)]
    assert got == extended


def test_coordinates():
    """Any size of number: exact floors by integers, modulo or limits; NaN."""
    for bits in np.random.default_rng(3).integers(0, 1 << 24, 3000):
        u = float(fp24.from_bits(bits))
        for log2_size in (0, 5, 12):
            for wrap in (model.REPEAT, model.MIRROR, model.CLAMP):
                got = model.fixed_coord(u, log2_size, wrap)
                if math.isnan(u):
                    assert got == -128
                    continue
                if math.isinf(u):
                    want = 0 if wrap < 2 else (1 << 23) - 1 if u > 0 else -(1 << 23)
                else:
                    num, den = u.as_integer_ratio()
                    want = (num << (log2_size + 8)) // den
                    want = min(max(want, -(1 << 23)), (1 << 23) - 1) if wrap == model.CLAMP else want
                assert (got + 128 - want) % (1 << 24 if wrap < 2 else 1 << 40) == 0


# ---- levels and blocks -------------------------------------------------------------------------------------------------


@pytest.mark.parametrize("rgba5551", [False, True])
@pytest.mark.parametrize("size", [(1, 1), (1, 64), (2, 2), (8, 4), (16, 64), (128, 1), (32, 32)])
def test_every_texel_is_found(rng, size, rgba5551):
    """texel_at finds each texel of each level of what build_textures wrote; offsets add up to the region."""
    image = random_image(rng, *size)
    region, desc, levels = one_texture(image, compact=rgba5551)
    assert desc[3] == len(levels) == max(size).bit_length()
    assert np.array_equal(levels[0], image)
    blocks = model.level_offset(desc[1], desc[2], desc[6], len(levels)) + desc[0]
    assert region.size == 64 * blocks
    for k, level in enumerate(levels):
        height, width = level.shape[:2]
        assert (height, width) == tuple(max(n >> k, 1) for n in size)
        for y in range(height):
            for x in range(width):
                got = model.texel_at(region, desc, k, x, y)
                if rgba5551:
                    want = [round(int(c) * 31 / 255) for c in level[y, x, :3]]
                    assert [c >> 3 for c in got[:3]] == want and [c & 7 for c in got[:3]] == [c >> 2 for c in want]
                    assert got[3] == (255 if level[y, x, 3] >= 128 else 0)
                else:
                    assert got == tuple(level[y, x])
    assert model.texel_at(region, desc, len(levels) + 100, 0, 0) == (0, 0, 0, 0), "outside the region"


def test_mip_of_uniform_and_ramp(rng):
    """A uniform image stays itself; opaque levels are means in linear light, which 1x1 shows best."""
    flat = np.tile(np.array([10, 128, 250, 99], np.uint8), (32, 8, 1))
    assert all(np.all(level == [10, 128, 250, 99]) for level in tx.mip_levels(tx.Texture(flat)))
    image = random_image(rng, 16, 32)
    image[..., 3] = 255
    last = tx.mip_levels(tx.Texture(image))[-1][0, 0]
    mean = model.srgb_to_linear(image[..., :3] / 255).mean(axis=(0, 1))
    assert last[:3] / 255 == pytest.approx(model.linear_to_srgb(mean), abs=0.51 / 255) and last[3] == 255
    last = tx.mip_levels(tx.Texture(image, srgb=False))[-1][0, 0]
    assert last == pytest.approx(image.mean(axis=(0, 1)), abs=0.51)


def test_no_dark_fringes():
    """Green leaves on transparent black: green at every level, alpha the share of leaf."""
    image = np.zeros((8, 8, 4), np.uint8)
    image[:, :3] = [0, 200, 0, 255]
    for level in tx.mip_levels(tx.Texture(image)):
        seen = level[level[..., 3] > 0]
        assert np.all(seen[:, :3] == [0, 200, 0])
    assert level[0, 0, 3] == round(255 * 3 / 8)


@pytest.mark.parametrize("wrap", ["repeat", "mirror", "clamp"])
def test_resampled_sizes(rng, wrap):
    """Sizes that are no powers of two: a note, the next power, a uniform image stays; a smooth one is found again."""
    use = dict(wrap_s=wrap, wrap_t=wrap)
    flat = tx.Texture(np.full((5, 3, 4), 90, np.uint8), name="flat", **use)
    region, desc, notes = tx.build_textures([flat])
    assert notes == ["flat: 3x5 resampled to 4x8"] and tuple(desc[0, 1:4]) == (2, 3, 4)
    assert all(np.all(level == 90) for level in tx.mip_levels(flat))
    y, x = np.mgrid[0:100, 0:200]
    wave = np.cos(2 * np.pi * (x + 0.5) / 200) * np.cos(2 * np.pi * (y + 0.5) / 100)
    image = np.full((100, 200, 4), 255, np.uint8)
    image[..., :3] = np.rint(127 + 100 * wave)[..., None]
    level = tx.mip_levels(tx.Texture(image, srgb=False, **use))[0]
    y, x = np.mgrid[0:128, 0:256]
    want = 127 + 100 * np.cos(2 * np.pi * (x + 0.5) / 256) * np.cos(2 * np.pi * (y + 0.5) / 128)
    assert level.shape == (128, 256, 4) and np.abs(level[..., 0] - want).max() < 2
    assert tx.fitting_size(5000, 1) == (4096, 1)


def test_bad_images_are_refused():
    for shape in ((4, 4), (4, 4, 3), (0, 4, 4)):
        with pytest.raises(ValueError, match="paper"):
            tx.build_textures([tx.Texture(np.zeros(shape, np.uint8), name="paper")])
    region, desc, notes = tx.build_textures([])
    assert region.size == 0 and desc.shape == (0, 10) and notes == []


# ---- samples -----------------------------------------------------------------------------------------------------------


@pytest.mark.parametrize("twin", [model.sample24, model.sample64])
def test_texel_centres(rng, twin):
    """A sample at the centre of a texel is that texel."""
    image = random_image(rng, 8, 16)
    for use in (dict(srgb=False), dict(), dict(wrap_s="clamp", wrap_t="mirror")):
        region, desc, _ = one_texture(image, **use)
        for y in range(8):
            for x in range(16):
                got = twin(region, desc, at((x + 0.5) / 16, (y + 0.5) / 8), 0.3, 0.2, 1.0, -640, False)
                want = model.LINEAR64[image[y, x]]
                if desc[7]:
                    want[:3] = model.SRGB64[image[y, x, :3]]
                assert got == pytest.approx(want, abs=0.51 / 4096)


@pytest.mark.parametrize("twin", [model.sample24, model.sample64])
def test_ramp_is_linear(twin):
    """Between centres of a linear ramp a sample lies on it; levels of it have the same slope."""
    image = np.zeros((16, 16, 4), np.uint8)
    image[..., 0] = 4 + 16 * np.arange(16)
    image[..., 1] = (4 + 16 * np.arange(16))[:, None]
    region, desc, _ = one_texture(image, srgb=False, wrap_s="clamp", wrap_t="clamp")
    for u in np.linspace(0.25, 0.75, 37):
        for lam in (-1.0, 0.0, 0.4, 1.0, 1.7):
            v = 1.0 - u
            r, g, b, a = twin(region, desc, at(u, v), 0.0, 0.0, 1.0, round(64 * lam), True)
            # halves of 8 bits in the levels below, 1/256 of a texel in the position, half of 1/4096 in a channel
            assert (r, g) == pytest.approx(
                ((256 * u - 4) / 255, (256 * v - 4) / 255), abs=0.5 / 255 + 16 / 256 / 255 + 2e-4
            )
            assert b == a == 0.0


@pytest.mark.parametrize("twin", [model.sample24, model.sample64])
def test_levels(twin):
    """The level follows length, record and bias in steps of two; trilinear mixes neighbours; ends are clamped."""
    levels = [np.full((16 >> k, 16 >> k, 4), 40 * k + 40, np.uint8) for k in range(5)]
    desc = np.array([0, 4, 4, 5, 0, 0, 0, 0, 0, 0])
    region = np.concatenate([tx.pack_blocks(level, False) for level in levels]).reshape(-1)
    value = [model.LINEAR64[40 * k + 40] for k in range(5)]

    def sample(length, mip, bias, trilinear):
        return twin(region, desc, np.array([0.3, 0.3, 0, 0, 0, 0, mip]), 0.1, 0.1, length, bias, trilinear)[3]

    for k in range(-2, 8):
        want = pytest.approx(value[min(max(k, 0), 4)], abs=1.4 / 4096 + (value[1] - value[0]) * 1.3 / 64)
        for length, mip, bias in ((2.0**k, 0, 0), (1.0, 64 * k, 0), (0.25, 64, 64 * (k + 1)), (4.0, -64, 64 * (k - 1))):
            for shift in (-25, 0, 25):
                assert sample(length, mip, bias + shift, False) == want
            assert sample(length, mip, bias, True) == want
    assert sample(1.0, 0, 96, True) == pytest.approx((value[1] + value[2]) / 2, abs=4e-3)
    assert sample(0.0, 0, 0, True) == pytest.approx(value[0], abs=2e-4)
    assert sample(math.inf, 0, 0, True) == sample(math.nan, 0, 0, False) == pytest.approx(value[4], abs=2e-4)


@pytest.mark.parametrize("rgba5551", [False, True])
@pytest.mark.parametrize("trilinear", [False, True])
def test_fp24_is_close(rng, rgba5551, trilinear):
    """The unit against double precision on smooth images, over all wraps and sizes, with coordinates up to a few repeats."""
    worst = 0.0
    for _ in range(RAYS):
        height, width = (int(n) for n in 2 ** rng.integers(0, 7, 2))
        y, x = np.mgrid[0:height, 0:width]
        image = np.stack(
            [128 + 100 * np.cos(2 * np.pi * (x / width + y / height + p)) for p in (0, 0.25, 0.5, 0.75)], axis=-1
        )
        wraps = rng.choice(list(tx.WRAPS), 2)
        region, desc, _ = one_texture(image.astype(np.uint8), wrap_s=wraps[0], wrap_t=wraps[1], compact=rgba5551)
        uv = fp24.round_to_fp24(np.append(rng.uniform(-2, 2, 6), rng.integers(-200, 200)))
        beta, gamma, length = fp24.round_to_fp24(rng.uniform(0, [0.5, 0.5, 4.0]))
        bias = int(rng.integers(-100, 300))
        lam = math.log2(length) + (uv[6] + bias) / 64
        if not trilinear and abs(lam - math.floor(lam) - 0.5) < 0.03:
            continue  # near a change of level, the table's error may decide
        got = np.array(model.sample24(region, desc, uv, beta, gamma, length, bias, trilinear))
        want = np.array(model.sample64(region, desc, uv, beta, gamma, length, bias, trilinear))
        assert fp24.to_bits(got) is not None  # raises if a value is not representable
        worst = max(worst, np.abs(got - want).max())
    # 1/256 texel and 2^-14 of a coordinate times the steepest step of an image (all of it between two texels, if few)
    assert 0 < worst < (0.02 if rgba5551 else 0.015)


def test_missing_texels_are_black():
    region, desc, _ = one_texture(np.full((8, 8, 4), 255, np.uint8))
    assert model.sample24(region[:64], desc, at(0.5, 0.5), 0.0, 0.0, 1.0, 0, False) == (0.0, 0.0, 0.0, 0.0)


# ---- records -----------------------------------------------------------------------------------------------------------


def random_triangles(rng, count):
    uv = rng.uniform(-0.7, 0.7, (count, 3, 2)) * 2.0 ** rng.integers(-6, 4, (count, 1, 1)) + rng.uniform(
        -90, 90, (count, 1, 2)
    )
    sizes = 2 ** rng.integers(0, 11, (count, 2))
    return uv, rng.uniform(-1, 1, (count, 3, 3)), sizes, rng.integers(0, 3, (count, 2))


def test_records_keep_the_texture(rng):
    """Shifted coordinates show the same texels; they are small; vertices are met to within a rounding."""
    uv, triangles, sizes, wraps = random_triangles(rng, RAYS)
    rows = tx.uv_rows(fields := tx.uv_records(uv, triangles, sizes, wraps))
    from raycore.image import pack_records

    assert pack_records(tx.TRI_UV, fields).shape == (RAYS, 4)
    for row, corner, wrap in zip(rows, uv, wraps):
        for axis in (0, 1):
            u0, d1, d2 = row[axis], row[2 + axis], row[4 + axis]
            for got, want in zip((u0, fp24.fadd(u0, d1), fp24.fadd(u0, d2)), corner[:, axis]):
                shift = want - got
                if wrap[axis] == tx.CLAMP:
                    assert abs(shift) <= np.abs(corner[:, axis]).max() * 2.0**-15
                    continue
                period = 2 if wrap[axis] == tx.MIRROR else 1
                spread = np.ptp(corner[:, axis])
                assert abs(shift - period * round(shift / period)) <= (spread + period) * 2.0**-16
                assert abs(got) <= spread / 2 + period / 2 + 1e-3


def test_mip_constant(rng):
    """Level 0 where a pixel is as large as a texel; it follows sizes and scale; extremes stay in 12 bits."""
    uv, triangles, sizes, wraps = random_triangles(rng, RAYS)
    mip = tx.mip_constants(uv, triangles, sizes)
    for k in range(RAYS):
        jacobian = np.array([uv[k, 1] - uv[k, 0], uv[k, 2] - uv[k, 0]]) * sizes[k]
        a, b = triangles[k, 1] - triangles[k, 0], triangles[k, 2] - triangles[k, 0]
        area = math.sqrt((a @ a) * (b @ b) - (a @ b) ** 2)
        assert mip[k] == pytest.approx(64 * math.log2(math.sqrt(abs(np.linalg.det(jacobian)) / area)), abs=0.5 + 1e-6)
    assert np.abs(tx.mip_constants(uv, triangles / 2, sizes) - np.clip(mip + 64, -2048, 2047)).max() <= 1
    square = np.array([[[0, 0], [1, 0], [0, 1.0]]])
    plane = np.array([[[0, 0, 0], [1, 0, 0], [0, 1, 0.0]]])
    assert tx.mip_constants(square, plane, np.array([[256, 256]])) == 64 * 8
    assert tx.mip_constants(0 * square, plane, np.array([[256, 256]])) == -2048
    assert tx.mip_constants(square, 0 * plane, np.array([[256, 256]])) == 0
    assert tx.mip_constants(square, 2.0**-60 * plane, np.array([[256, 256]])) == 2047
    # A square of 256 texels and side 1, seen straight from a distance at which it covers 256 pixels, is in level 0.
    height, fov = 480, 45.0
    distance = height / 256 / (2 * math.tan(math.radians(fov) / 2))
    lam = 64 * math.log2(distance) + 64 * 8 + tx.mip_bias(fov, height)
    assert abs(lam) <= 0.5


def test_bad_coordinates_count_as_zero():
    uv = np.array([[[math.nan, 0.25], [math.inf, 0.5], [0.5, -math.inf]]])
    rows = tx.uv_rows(tx.uv_records(uv, np.zeros((1, 3, 3)), [[4, 4]], [[2, 2]]))
    assert rows[0, :6] == pytest.approx([0, 0.25, 0, 0.25, 0.5, -0.25])
