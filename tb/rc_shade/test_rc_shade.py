# SPDX-License-Identifier: Apache-2.0 WITH SHL-2.1
"""rc_shade against raycore.model: every ray that leaves and every finished colour, bit for bit.

The test plays ray generation, the T&I unit (hits, shadow rays that arrive, end or meet something transparent, answers in any
order), the colour buffer, and a memory with latency and back-pressure behind three ports. What a ray meets is chosen at
random when it comes back; from there the model goes on to the next ray or to the colour that must follow. Ray indices are used
again as soon as their pixel is finished.
"""

import random
from collections import deque
from dataclasses import dataclass, field

import cocotb
import numpy as np
import pytest
import shade_tb as sh
from cocotb.clock import Clock
from cocotb.triggers import RisingEdge

from raycore.model import fp24, shade, texture

F = shade.FP24
INFO_BASE, INST_BASE, UV_BASE, TEX_BASE = 0x3000, 0x5000, 0x7000, 0x20000
PRIMARY, SHADOW, REFLECT, TRANSMIT = range(4)
ONES = (1.0, 1.0, 1.0)


@dataclass
class Texture:
    """A texture of random texels, its place and its descriptor."""

    base: int
    log2_w: int
    log2_h: int
    wrap: tuple
    compact: bool
    srgb: bool

    @property
    def levels(self):
        return max(self.log2_w, self.log2_h) + 1

    @property
    def blocks(self):
        return int(texture.level_offset(self.log2_w, self.log2_h, self.compact, self.levels))

    @property
    def word(self):
        return sh.pack((self.srgb, 1), (self.compact, 1), (self.wrap[1], 2), (self.wrap[0], 2), (self.levels, 4), (self.log2_h, 4),
                       (self.log2_w, 4), (self.base, 26))

    @property
    def desc(self):
        return np.array([self.base, self.log2_w, self.log2_h, self.levels, *self.wrap, self.compact, self.srgb, 0, 0],
                        dtype=np.int64)


@dataclass
class Scene:
    """Lights, materials and triangles of a frame, textures, settings."""

    lights: list
    mats: list
    triangles: list
    places: list = field(default_factory=list)          # of placed objects, of the first one at [1]
    uvs: list = field(default_factory=list)             # (six patterns, mip) by triangle
    textures: list = field(default_factory=list)        # by material
    texels: object = None
    shadows: bool = True
    trilinear: bool = False
    max_depth: int = 15
    min_weight: int = 0x380000
    mip_bias: int = 0
    background: list = None
    mat_count: int = None

    @classmethod
    def random(cls, num, lights, mats=20, triangles=60, effects=True, **settings):
        rng = num.rng
        self = cls([sh.Light.random(num) for _ in range(lights)], [sh.Material.random(num, effects) for _ in range(mats)],
                   [sh.Triangle.random(num, rng.randrange(mats)) for _ in range(triangles)], background=num.color(), **settings)
        self.places = [None, *(sh.Place.random(num) for _ in range(9))]
        base = 0
        for mat in self.mats:
            self.textures.append(Texture(base, rng.randrange(7), rng.randrange(7), (rng.randrange(3), rng.randrange(3)),
                                         rng.random() < 0.5, rng.random() < 0.5))
            mat.texture = self.textures[-1].word
            base += self.textures[-1].blocks
        self.texels = np.frombuffer(rng.randbytes(64 * base), dtype=np.uint8)
        for _ in self.triangles:
            self.uvs.append((num.spoil(sh.nearest([rng.uniform(-2, 2) for _ in range(6)])), rng.randrange(-300, 500)))
        return self

    def config(self):
        return sh.pack((INFO_BASE, 26), (INST_BASE, 26), (UV_BASE, 26), (TEX_BASE, 26), (self.mip_bias & 0xFFF, 12),
                       (self.trilinear, 1), (self.max_depth, 4), (self.min_weight, 24), (self.mat_count or len(self.mats), 9),
                       (len(self.lights), 5), (self.shadows, 1), (sh.vec(self.background), 72))

    def records(self):
        return [*((sh.LD_LIGHT, i, r.line) for i, r in enumerate(self.lights)),
                *((sh.LD_MATERIAL, i, r.line) for i, r in enumerate(self.mats)),
                *((sh.LD_OPTICS, i, r.optics_line) for i, r in enumerate(self.mats))]

    def read_info(self, address):
        if address >= INST_BASE:
            inst, part = divmod(address - INST_BASE, 4)
            assert part == 2, f"no place at {address:x}"
            return self.places[inst].line
        return self.triangles[address - INFO_BASE].line

    def read_uv(self, address):
        word = 0
        for half in range(2):
            index = (address - UV_BASE) * 2 + half
            if index < len(self.uvs):
                numbers, mip = self.uvs[index]
                word |= sh.line(numbers, mip & 0xFFF) << 240 * half
        return word

    def read_tex(self, address):
        at = 64 * (address - TEX_BASE)
        assert 0 <= at < len(self.texels), f"texture block {address:x}"
        return int.from_bytes(self.texels[at : at + 64].tobytes(), "little")

    def texture_at(self, tri_idx, mat, beta, gamma, length):
        """(rgb, a) by the model."""
        if not self.mats[mat].textured:
            return ONES, 1.0
        numbers, mip = self.uvs[tri_idx]
        uv = np.array([*sh.floats(numbers), mip], dtype=np.float64)
        r, g, b, a = texture.sample24(self.texels, self.textures[mat].desc, uv, beta, gamma, length, self.mip_bias, self.trilinear)
        return (r, g, b), a


@dataclass
class Pixel:
    """A pixel under way by the model, and what the unit must do next."""

    scene: Scene
    ray_id: int
    want: tuple = None                                  # ("ray", kind, word) or ("done", patterns)
    acc: tuple = (0.0, 0.0, 0.0)
    ray: tuple = None                                   # origin, direction (patterns), w, len, depth
    stack: list = field(default_factory=list)
    light: int = 0
    culled: int = 0
    lost: bool = False                                  # a material that does not exist: anything may follow
    layers: int = 0
    surfaces: int = 0

    def sec(self, kind, light, depth, t_min, t_max, direction, org):
        self.want = ("ray", kind, sh.pack((self.ray_id, 8), (kind, 2), (light, 4), (depth, 4), (self.surf, 33), (t_min, 24),
                                          (t_max, 24), (sh.vec(direction), 72), (sh.vec(org), 72)))

    def surface(self, surf, t, beta, gamma):
        """The path's ray hit a triangle, perhaps of a placed object (surf_t, patterns of t, beta, gamma)."""
        scene = self.scene
        org, direction, self.w, length, self.depth = self.ray
        inst, tri_idx = surf >> 24, surf & 0xFFFFFF
        tri = scene.triangles[tri_idx]
        if inst:
            tri = tri.placed(scene.places[inst])
        self.surf, self.surfaces = surf, self.surfaces + 1
        if tri.mat >= (scene.mat_count or len(scene.mats)):
            self.lost = True
            return
        self.mat = scene.mats[tri.mat]
        self.ctx = sh.Context.of_hit(org, direction, t, beta, gamma, tri, sh.bits([length])[0])
        self.tex, ta = scene.texture_at(tri_idx, tri.mat, *sh.floats([beta, gamma]), self.ctx.length)
        self.alpha = F.coverage(ta, self.mat.record)
        self.wl = F.weight(self.alpha, self.w)
        self.acc = F.add_surface(self.acc, self.wl, self.tex, self.mat.record)
        self.light = 0
        self.next_light()

    def next_light(self):
        scene = self.scene
        while self.light < len(scene.lights):
            self.t_min, self.tr, self.layers = 2.0**-14, ONES, 0
            self.shadow()
            if self.want:
                return
            self.light += 1
        self.bounce()

    def shadow(self):
        """One light, or its shadow ray again."""
        scene = self.scene
        culled, to, t_min, t_max, self.k = F.light_job(self.ctx.values, scene.lights[self.light].record, self.mat.record, self.tex,
                                                       self.t_min)
        if culled:
            self.culled += 1
        elif scene.shadows:
            self.sec(SHADOW, self.light, self.depth, *sh.bits([t_min, t_max]), sh.bits(to), sh.bits(self.ctx.values[0]))
        else:
            self.acc = F.add_light(self.acc, self.wl, ONES, self.k)

    def arrived(self):
        self.acc = F.add_light(self.acc, self.wl, self.tr, self.k)
        self.blocked()

    def blocked(self):
        self.light += 1
        self.next_light()

    def through(self, tri_idx, t, beta, gamma):
        mat, (at, b, c) = self.scene.triangles[tri_idx].mat, sh.floats([t, beta, gamma])
        tex, ta = self.scene.texture_at(tri_idx, mat, b, c, fp24.fadd(self.ctx.length, at))
        stops, self.tr, self.t_min = F.shadow_through(self.tr, at, tex, ta, self.scene.mats[mat].record,
                                                      sh.floats([self.scene.min_weight])[0])
        self.layers += 1
        if stops:
            self.blocked()
        else:
            self.shadow()

    def bounce(self):
        mat, scene = self.mat, self.scene
        if self.depth >= scene.max_depth or not (mat.reflects or mat.transmits or mat.mode != shade.ALPHA_OPAQUE):
            return self.end()
        children = F.bounce(self.ctx.values, self.tex, self.w, self.alpha, self.ctx.inside, mat.record,
                            sh.floats([scene.min_weight])[0])
        rays = [(kind, (sh.bits(org), sh.bits(d), w, self.ctx.length, self.depth + 1), self.surf)
                for kind, (traced, w, d, org) in zip((REFLECT, TRANSMIT), children) if traced]
        self.stack += rays[1:]
        if rays:
            return self.go_on(*rays[0])
        return self.end()

    def go_on(self, kind, ray, surf):
        self.ray, self.surf = ray, surf
        org, direction, _, _, depth = ray
        self.sec(kind, 0, depth, 0x310000, sh.HUGE, direction, org)

    def missed(self):
        self.acc = F.add_miss(self.acc, self.ray[2], sh.floats(self.scene.background))
        self.end()

    def end(self):
        if self.stack:
            self.go_on(*self.stack.pop())
        else:
            self.want = ("done", sh.bits(self.acc))


class Port:
    """A memory client: requests, answers in order after a random time."""

    def __init__(self, dut, rng, prefix, answer, read):
        self.dut, self.rng, self.read, self.queue = dut, rng, read, deque()
        self.names = {n: getattr(dut, f"{prefix}{n}") for n in ("req_valid_o", "req_ready_i", "req_addr_o", "rsp_valid_i", answer)}
        self.answer = self.names[answer]
        self.count, self.ready = 0, False

    def give(self, cycle, p_req):
        self.ready = self.rng.random() < p_req
        self.names["req_ready_i"].value = self.ready
        answers = bool(self.queue) and self.queue[0][0] <= cycle
        self.names["rsp_valid_i"].value = answers
        if answers:
            self.answer.value = self.read(self.queue.popleft()[1])

    def take(self, cycle, latency):
        if self.ready and self.names["req_valid_o"].value:
            self.queue.append((cycle + self.rng.randint(*latency), int(self.names["req_addr_o"].value)))
            self.count += 1


@dataclass
class Bench:
    """All that surrounds rc_shade, one cycle a step."""

    dut: object
    rng: random.Random
    p_hit: float = 1.0
    p_sec: float = 1.0
    p_done: float = 1.0
    p_req: float = 1.0
    latency: tuple = (1, 20)                        # of memory and of the T&I unit, cycles
    p_miss: float = 0.2
    p_blocked: float = 0.3
    p_placed: float = 0.4
    p_layer: float = 0.4
    max_layers: int = 6
    cycle: int = 0
    free: list = field(default_factory=lambda: list(range(256)))
    pixels: dict = field(default_factory=dict)      # by ray index
    to_hit: deque = field(default_factory=deque)    # (id, kind) of rays that come back now
    travel: list = field(default_factory=list)      # (cycle, id, kind)
    leaving: deque = field(default_factory=deque)   # path_ray_t words and (id, kind): rays in ray generation
    done_at: list = field(default_factory=list)
    events: dict = field(default_factory=lambda: dict.fromkeys(
        ("culled", "info_hit", "info_miss", "uv_hit", "uv_miss", "tex_hit", "tex_miss"), 0))
    rays: dict = field(default_factory=lambda: dict.fromkeys((PRIMARY, SHADOW, REFLECT, TRANSMIT), 0))
    depths: set = field(default_factory=set)
    layers: set = field(default_factory=set)
    want_culled: int = 0
    surfaces: int = 0
    placed: int = 0                                 # surfaces of placed objects
    looked_up: int = 0
    errors: list = field(default_factory=list)
    hits_taken: int = 0
    direction: object = None
    _hit: tuple = None
    _sec_held: object = None

    async def start(self):
        dut = self.dut
        Clock(dut.clk_i, 10, unit="ns").start()
        for name in ("rst_ni", "hit_valid_i", "sec_ready_i", "done_ready_i", "path_ray_valid_i", "ld_valid_i"):
            getattr(dut, name).value = 0
        self.ports = [Port(dut, self.rng, "", "rsp_line_i", lambda a: self.scene.read_info(a)),
                      Port(dut, self.rng, "uv_", "rsp_line_i", lambda a: self.scene.read_uv(a)),
                      Port(dut, self.rng, "tex_", "rsp_block_i", lambda a: self.scene.read_tex(a))]
        for port in self.ports:
            port.give(0, 0.0)

    async def frame(self, num, scene):
        """Reset, which empties the caches; registers and records of a frame."""
        dut = self.dut
        assert not self.pixels
        dut.rst_ni.value = 0
        for _ in range(2):
            await RisingEdge(dut.clk_i)
        dut.rst_ni.value = 1
        self.num, self.scene = num, scene
        dut.cfg_i.value = scene.config()
        await sh.load(dut, scene.records())

    def new_pixel(self):
        """A primary ray leaves ray generation."""
        ray_id = self.free.pop(self.rng.randrange(len(self.free)))
        org, direction = self.num.point(), (self.direction or self.num.direction)()
        pixel = self.pixels[ray_id] = Pixel(self.scene, ray_id, ray=(org, direction, ONES, 0.0, 0))
        self.leaving.append((ray_id, PRIMARY))
        return pixel

    def come_back(self, ray_id, kind):
        """What a ray met, as a hit_t, and by the model all that follows from it."""
        rng, num, pixel, scene = self.rng, self.num, self.pixels[ray_id], self.scene
        tri_idx, at = rng.randrange(len(scene.triangles)), sh.random_weights(num)
        if kind == SHADOW:
            behind = [i for i in range(len(scene.triangles)) if not scene.mats[scene.triangles[i].mat % len(scene.mats)].opaque]
            what = rng.choices(("arrive", "block", "layer"), (1 - self.p_blocked - self.p_layer, self.p_blocked, self.p_layer))[0]
            if what == "layer" and (not behind or pixel.layers >= self.max_layers or pixel.lost):
                what = "arrive"
            if what == "layer":
                tri_idx, at = rng.choice(behind), [at[0] & 0x7FFFFF, *at[1:]]   # the T&I unit counts what lies ahead
            mat = scene.triangles[tri_idx].mat
            word = sh.hit_word(ray_id, 1, what != "arrive", what == "block", mat, tri_idx, *at)
            if what == "arrive":
                word = sh.hit_word(ray_id, 1, 0, 0, 0, sh.TRI_NONE, *at)
            if what == "layer" and mat >= (scene.mat_count or len(scene.mats)):
                pixel.lost = True
                return word, None
            self.looked_up += what == "layer" and scene.mats[mat].textured
            return word, {"arrive": pixel.arrived, "block": pixel.blocked, "layer": lambda: pixel.through(tri_idx, *at)}[what]
        if rng.random() < self.p_miss or pixel.lost:
            return sh.hit_word(ray_id, 0, 0, 0, 0, sh.TRI_NONE, *at), pixel.missed
        mat = scene.triangles[tri_idx].mat
        known = mat < (scene.mat_count or len(scene.mats))
        surf = rng.randrange(len(scene.places)) << 24 | tri_idx if rng.random() < self.p_placed else tri_idx
        self.surfaces += 1
        self.placed += surf >> 24 > 0
        self.looked_up += known and scene.mats[mat].textured
        word = sh.hit_word(ray_id, 0, 1, known and scene.mats[mat].opaque, mat, surf, *at)
        return word, lambda: pixel.surface(surf, *at)

    async def step(self):
        dut, rng = self.dut, self.rng
        # what the surroundings give
        dut.path_ray_valid_i.value = bool(self.leaving)
        if self.leaving:
            ray_id, kind = self.leaving.popleft()
            org, direction = self.pixels[ray_id].ray[:2]
            dut.path_ray_i.value = sh.pack((ray_id, 8), (kind == PRIMARY, 1), (sh.vec(direction), 72), (sh.vec(org), 72))
            self.travel.append((self.cycle + rng.randint(*self.latency), ray_id, kind))
        for ray in [r for r in self.travel if r[0] <= self.cycle]:
            self.travel.remove(ray)
            self.to_hit.insert(rng.randint(0, len(self.to_hit)), ray[1:])
        if self._hit is None and self.to_hit and rng.random() < self.p_hit:
            ray_id, kind = self.to_hit.popleft()
            self._hit = self.come_back(ray_id, kind)
            self.rays[kind] += 1
            dut.hit_i.value = self._hit[0]
        dut.hit_valid_i.value = self._hit is not None
        sec_ready, done_ready = rng.random() < self.p_sec, rng.random() < self.p_done
        dut.sec_ready_i.value, dut.done_ready_i.value = sec_ready, done_ready
        for port in self.ports:
            port.give(self.cycle, self.p_req)
        await RisingEdge(dut.clk_i)
        self.cycle += 1
        # what the unit did
        for port in self.ports:
            port.take(self.cycle, self.latency)
        for name in self.events:
            self.events[name] += int(getattr(dut, f"ev_{name}_o").value)
        if dut.err_valid_o.value:
            self.errors.append(int(dut.err_o.value))
        if dut.sec_valid_o.value:
            word = int(dut.sec_o.value)
            assert self._sec_held in (None, word), "the ray changed while it waited"
            self._sec_held = word
            if sec_ready:
                self.take_sec(word)
        if done_ready and dut.done_valid_o.value:
            self.take_done(int(dut.done_o.value))
        if self._hit is not None and dut.hit_ready_o.value:
            (word, follow), self._hit = self._hit, None
            pixel = self.pixels[word >> 120]
            if not pixel.lost:
                culled = pixel.culled
                follow()
                self.want_culled += pixel.culled - culled
                assert pixel.want or pixel.lost
            self.layers.add(pixel.layers)
            self.hits_taken += 1

    def take_sec(self, word):
        self._sec_held = None
        ray_id, kind = word >> 235, word >> 233 & 3
        pixel = self.pixels[ray_id]
        self.depths.add(word >> 225 & 15)
        if not pixel.lost:
            assert pixel.want is not None and pixel.want[0] == "ray", f"a ray of index {ray_id}, but due is {pixel.want}"
            want, pixel.want = pixel.want[2], None
            assert word == want, "\n".join(["kind/light/depth, skip, t_min, t_max, dir, org"] + [
                f"{w >> 225 & 0x3FF:03x} {w >> 192 & (1 << 33) - 1:09x} {w >> 168 & 0xFFFFFF:06x} {w >> 144 & 0xFFFFFF:06x} "
                + " ".join(f"{w >> s & 0xFFFFFF:06x}" for s in (72, 96, 120, 0, 24, 48)) for w in (word, want)])
        if kind == SHADOW:
            self.travel.append((self.cycle + self.rng.randint(*self.latency), ray_id, kind))
        else:
            self.leaving.append((ray_id, kind))

    def take_done(self, word):
        ray_id, got = word >> 72, sh.unvec(word)
        pixel = self.pixels.pop(ray_id)
        if not pixel.lost:
            assert pixel.want is not None and pixel.want[0] == "done", f"index {ray_id} is finished, but due is {pixel.want}"
            want = pixel.want[1]
            assert sh.same(got, want), f"{[f'{g:06x}' for g in got]}, not {[f'{w:06x}' for w in want]}"
        self.free.append(ray_id)
        self.done_at.append(self.cycle)

    async def run(self, count, ahead=256):
        """This many pixels, at most `ahead` of them under way, then wait until all are finished."""
        goal, quiet, last = len(self.done_at) + count, 0, None
        while len(self.done_at) < goal:
            if self.free and not self.leaving and len(self.pixels) < min(ahead, goal - len(self.done_at)):
                self.new_pixel()
            await self.step()
            state = (self.hits_taken, len(self.done_at), sum(self.rays.values()))
            quiet, last = (0, state) if state != last else (quiet + 1, last)
            patience = 3000 + 50 * self.latency[1] + 5 * 256 * len(self.scene.lights)
            assert quiet < patience, f"hangs with {len(self.pixels)} pixels under way"
        assert not self.pixels and not self.travel and not any(p.queue for p in self.ports)

    def check_events(self):
        assert self.events["culled"] == self.want_culled
        looked = self.events["info_hit"] + self.events["info_miss"]   # also for a place, if it is not that of the last surface
        assert self.surfaces <= looked <= self.surfaces + self.placed and (looked > self.surfaces or self.placed < 9)
        assert self.events["info_miss"] == self.ports[0].count
        assert self.events["uv_hit"] + self.events["uv_miss"] == self.looked_up
        assert self.events["uv_miss"] == self.ports[1].count
        assert self.events["tex_miss"] == self.ports[2].count
        assert not self.errors


def bench_of(dut, **settings):
    return Bench(dut, random.Random(cocotb.RANDOM_SEED), **settings)


@cocotb.test(timeout_time=10, timeout_unit="ms")
@cocotb.parametrize(lights=[0, 1, 3, 16], wild=[0.0, 0.05])
async def random_pixels(dut, lights, wild):
    """Frames with and without shadows and bounces, any materials, new rates and latencies in each."""
    bench = bench_of(dut)
    num, rng = sh.Numbers(bench.rng, wild), bench.rng
    await bench.start()
    for latency in ((1, 1), (1, 60), (200, 400)):
        bench.latency = latency
        bench.p_hit, bench.p_sec, bench.p_done, bench.p_req = [rng.choice([1.0, 0.5, 0.1]) for _ in range(4)]
        await bench.frame(num, Scene.random(num, lights, shadows=rng.random() < 0.8, trilinear=rng.random() < 0.5,
                                            max_depth=rng.choice([0, 1, 5, 15]), mip_bias=rng.randrange(-600, 100)))
        ahead = rng.choice([1, 10, 256]) if latency[1] < 100 else 256
        await bench.run(sh.some(24 if lights > 3 else 60), ahead)
    bench.check_events()
    dut._log.info(f"rays {bench.rays}, depths {sorted(bench.depths)}, layers {sorted(bench.layers)}, {bench.events}")


@cocotb.test(timeout_time=10, timeout_unit="ms")
async def no_shadows(dut):
    """Colours are summed at once, in the order of the lights; no ray is made."""
    bench = bench_of(dut, p_sec=0.0)
    num = sh.Numbers(bench.rng, 0.02)
    await bench.start()
    await bench.frame(num, Scene.random(num, 16, 256, 300, shadows=False, max_depth=0))
    await bench.run(100)
    bench.check_events()
    assert bench.want_culled > 0


@cocotb.test(timeout_time=10, timeout_unit="ms")
@cocotb.parametrize(min_weight=[0x000000, 0x370000])
async def mirror_box(dut, min_weight):
    """Everything mirrors or is glass and nothing is missed: down to depth 15, stacks filled and emptied."""
    bench = bench_of(dut, p_miss=0.02, latency=(1, 8))
    num = sh.Numbers(bench.rng, 0.0)
    await bench.start()
    scene = Scene.random(num, 1, min_weight=min_weight)
    for i, mat in enumerate(scene.mats):
        mat.reflects, mat.fresnel = True, i % 3 == 0
        mat.kr = sh.nearest([bench.rng.uniform(0.4, 1.0) for _ in range(3)])
        mat.mode = mat.mode if i % 4 == 1 else shade.ALPHA_OPAQUE
        mat.transmits = i % 8 == 0          # material 0 at least, whatever the seed
    await bench.frame(num, scene)
    await bench.run(12, 12)
    bench.check_events()
    dut._log.info(f"rays {bench.rays}, depths {sorted(bench.depths)}")
    assert bench.depths >= set(range(4 if min_weight else 16)) and bench.rays[TRANSMIT] > 0


@cocotb.test(timeout_time=10, timeout_unit="ms")
async def six_layers(dut):
    """Shadow rays through up to six transparent triangles, textured and not, by colour, mask and blend."""
    bench = bench_of(dut, p_layer=0.85, p_blocked=0.0, p_miss=0.0)
    num = sh.Numbers(bench.rng, 0.0)
    await bench.start()
    scene = Scene.random(num, 3, 40, 100, max_depth=0, min_weight=0x300000)
    for light in scene.lights:
        light.directional, light.pos = True, sh.nearest(sh.unit(bench.rng))
    for mat in scene.mats:
        if mat.opaque:
            mat.transmits = True
        mat.kt = sh.nearest([bench.rng.uniform(0.5, 1.0) for _ in range(3)])
    await bench.frame(num, scene)
    await bench.run(sh.some(250))
    bench.check_events()
    assert bench.layers >= set(range(7)), bench.layers


@cocotb.test(timeout_time=10, timeout_unit="ms")
async def more_triangles_than_lines(dut):
    """Triangle information is fetched again after others took its place."""
    bench = bench_of(dut, p_miss=0.0)
    num = sh.Numbers(bench.rng, 0.0)
    await bench.start()
    scene = Scene.random(num, 0, 5, 40, effects=False)
    scene.triangles, scene.uvs = [scene.triangles[i * 7 % 40] for i in range(3000)], [scene.uvs[0]] * 3000
    await bench.frame(num, scene)
    await bench.run(sh.some(1500))
    bench.check_events()
    assert bench.events["info_hit"] > 0 and bench.events["info_miss"] > sh.some(1000)


@cocotb.test(timeout_time=10, timeout_unit="ms")
async def flood(dut):
    """All 256 indices come in while no ray may leave: every hit is taken. Then rays leave one by one, and those that come back
    are taken while the next one waits: shadow rays, resumed ones, reflected ones. In the end everything drains."""
    bench = bench_of(dut, p_sec=0.0, p_miss=0.0, p_layer=0.5, p_blocked=0.2)
    num = sh.Numbers(bench.rng, 0.0)
    await bench.start()
    await bench.frame(num, Scene.random(num, 4))
    while bench.free:
        bench.new_pixel()
        await bench.step()
    for _ in range(5000):
        await bench.step()
    assert bench.hits_taken == 256 and bench._hit is None and not bench.to_hit
    assert dut.sec_valid_o.value and len(bench.pixels) > 128
    for _ in range(60):
        rays = len(bench.travel) + len(bench.leaving)
        bench.p_sec = 1.0
        while len(bench.travel) + len(bench.leaving) == rays:
            await bench.step()
        bench.p_sec = 0.0
        for _ in range(100):
            await bench.step()
        assert not bench.to_hit and not bench.travel and bench._hit is None
    bench.p_sec, bench.p_miss = 1.0, 0.5
    limit = bench.cycle + 200000
    while bench.pixels:
        await bench.step()
        assert bench.cycle < limit, f"hangs with {len(bench.pixels)} pixels under way"


@cocotb.test(timeout_time=10, timeout_unit="ms")
@cocotb.parametrize(full=["sec", "done", "memory"])
async def long_stops(dut, full):
    """One exit is shut for a thousand cycles at a time."""
    bench = bench_of(dut)
    num = sh.Numbers(bench.rng, 0.0)
    await bench.start()
    await bench.frame(num, Scene.random(num, 2, 20, 500, max_depth=3))
    name = {"sec": "p_sec", "done": "p_done", "memory": "p_req"}[full]
    for _ in range(3):
        setattr(bench, name, 0.0)
        for _ in range(1000):
            if bench.free and not bench.leaving:
                bench.new_pixel()
            await bench.step()
        setattr(bench, name, 1.0)
        for _ in range(500):
            await bench.step()
    limit = bench.cycle + 60000
    while bench.pixels:
        await bench.step()
        assert bench.cycle < limit


@cocotb.test(timeout_time=10, timeout_unit="ms")
@cocotb.parametrize(case=["culled", "shadow", "miss", "mirror"])
async def rate(dut, case):
    """One hit and one job in six cycles, sustained: with a light that is culled, with one whose ray comes back, with a light and
    a mirror, which share the contexts; a pixel that hits nothing in three."""
    bench = bench_of(dut, p_miss=float(case == "miss"), p_layer=0.0, p_placed=0.0, latency=(4, 8))
    num = sh.Numbers(bench.rng, 0.0)
    await bench.start()
    scene = Scene.random(num, 1, 5, 5, effects=False, max_depth=1)
    light = scene.lights[0]
    light.directional, light.pos = True, [0, 0x3F0000, 0]
    for tri in scene.triangles:
        tri.n = tri.n0 = sh.nearest([0.0, 1.0, 0.0])
        tri.e1 = tri.e2 = [0, 0, 0]
    for mat in scene.mats:
        mat.reflects, mat.kr = case == "mirror", [0x3F0000] * 3
    await bench.frame(num, scene)

    def direction():                                        # from above: lit; from below: culled
        d = sh.unit(bench.rng)
        d[1] = abs(d[1]) if case == "culled" else -abs(d[1])
        return sh.nearest(d)

    bench.direction = direction
    count = 400
    await bench.run(count)
    cycles = (bench.done_at[-20] - bench.done_at[99]) / (count - 119)
    dut._log.info(f"{case}: a pixel in {cycles:.2f} cycles")
    assert cycles <= {"culled": 6.05, "shadow": 6.05, "miss": 3.05, "mirror": 15.1}[case]
    assert case == "mirror" or (bench.events["culled"] == count) == (case == "culled")


@cocotb.test(timeout_time=10, timeout_unit="ms")
@cocotb.parametrize(textured=[False, True])
async def unknown_material(dut, textured):
    """A material index beyond the count is an error with that index, and no texture is looked up for it; the unit goes on until
    the frame is ended."""
    bench = bench_of(dut, p_miss=0.1)
    num = sh.Numbers(bench.rng, 0.0)
    await bench.start()
    scene = Scene.random(num, 2, 21, 50, mat_count=20)
    scene.mats[20].textured = textured
    for tri in scene.triangles[:5]:
        tri.mat = 20
    await bench.frame(num, scene)
    await bench.run(sh.some(200))
    assert bench.errors and set(bench.errors) == {9 << 32 | 20}
    lookups = bench.events["uv_hit"] + bench.events["uv_miss"]
    assert lookups == bench.looked_up


@pytest.mark.parametrize("latencies", ["paper", "deep", "long"])
def test_rc_shade(latencies):
    """The same tests on builds with other latencies of the functional units."""
    sh.run("rc_shade", latencies, sh.SHADE, "test_rc_shade")
