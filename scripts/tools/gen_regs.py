# SPDX-License-Identifier: Apache-2.0 WITH SHL-2.1
"""Everything that follows from the register description rtl/top/rc_regs.rdl.

    python scripts/tools/gen_regs.py            writes the files
    python scripts/tools/gen_regs.py --check    fails if a file differs from what would be written

Generated: rtl/top/regs/ (register block with an AXI4-Lite port), scripts/raycore/regs.py (offsets and fields
for the host), sim/rc_regs.h (the same for the C++ harness) and docs/registers.md.
"""

import argparse
import sys
import tempfile
from pathlib import Path

from peakrdl_regblock import RegblockExporter
from peakrdl_regblock.cpuif.axi4lite import AXI4Lite_Cpuif_flattened
from peakrdl_regblock.udps import ALL_UDPS
from systemrdl import RDLCompiler
from systemrdl.node import AddrmapNode, FieldNode, RegNode

ROOT = Path(__file__).resolve().parents[2]
RDL = ROOT / "rtl/top/rc_regs.rdl"
SPDX = "SPDX-License-Identifier: Apache-2.0 WITH SHL-2.1"
ORIGIN = "Generated from rtl/top/rc_regs.rdl by scripts/tools/gen_regs.py: do not edit."
FIRST_COUNTER, END_COUNTERS = 0x100, 0x200  # set-up registers lie before and behind counters


def elaborate(rdl: Path) -> AddrmapNode:
    """The elaborated address map of a SystemRDL file."""
    compiler = RDLCompiler()
    for udp in ALL_UDPS:
        compiler.register_udp(udp)
    compiler.compile_file(str(rdl))
    return compiler.elaborate().top


def access(field: FieldNode) -> str:
    """What software may do with a field."""
    if field.get_property("onwrite") is not None:
        return "W1C"
    return {(True, True): "RW", (True, False): "RO", (False, True): "WO"}[(field.is_sw_readable, field.is_sw_writable)]


def verilog(top: AddrmapNode) -> dict[str, str]:
    """The register block and its package, by file name."""
    with tempfile.TemporaryDirectory() as folder:
        RegblockExporter().export(
            top,
            folder,
            cpuif_cls=AXI4Lite_Cpuif_flattened,
            default_reset_activelow=True,
            address_width=12,
            err_if_bad_addr=True,
            reuse_hwif_typedefs=False,
        )
        return {
            file.name: f"// {SPDX}\n// {ORIGIN}\n" + "\n".join(line.rstrip() for line in file.read_text().splitlines()) + "\n"
            for file in sorted(Path(folder).glob("*.sv"))
        }


def python(regs: list[RegNode]) -> str:
    """regs.py: data, and the two functions that use it."""
    lines = [f"# {SPDX}", f'"""Host registers by name. {ORIGIN}"""', "", "OFFSETS = {"]
    lines += [f'    "{r.inst_name}": 0x{r.address_offset:03X},' for r in regs]
    lines += ["}", "", "# register: {field: (lowest bit, width, access)}", "FIELDS = {"]
    for reg in regs:
        fields = ", ".join(f'"{f.inst_name}": ({f.low}, {f.width}, "{access(f)}")' for f in reg.fields())
        lines.append(f'    "{reg.inst_name}": {{{fields}}},')
    names = [r.inst_name for r in regs if FIRST_COUNTER <= r.address_offset < END_COUNTERS]
    lines += ["}", "", "COUNTERS = ("] + [f'    "{name}",' for name in names] + [")", "", ""]
    lines += [
        "def pack(register: str, **values: int) -> int:",
        '    """Value of a register from its fields; fields not named are 0. ValueError if a value does not fit."""',
        "    word = 0",
        "    for name, value in values.items():",
        "        low, width, _ = FIELDS[register][name]",
        "        if not 0 <= value < 1 << width:",
        '            raise ValueError(f"{register}.{name}: {value} does not fit in {width} bits")',
        "        word |= value << low",
        "    return word",
        "",
        "",
        "def unpack(register: str, word: int) -> dict[str, int]:",
        '    """Fields of a register from its value."""',
        "    return {name: word >> low & ((1 << width) - 1) for name, (low, width, _) in FIELDS[register].items()}",
    ]
    return "\n".join(lines) + "\n"


def header(regs: list[RegNode]) -> str:
    """rc_regs.h: offsets, and names for the harness's register files."""
    lines = [f"// {SPDX}", f"// {ORIGIN}", "#pragma once", "#include <cstdint>", "", "namespace reg {"]
    lines += ["enum Offset : uint32_t {"] + [f"  {r.inst_name} = 0x{r.address_offset:03X}," for r in regs] + ["};"]
    lines += ["struct Name { const char* name; uint32_t offset; };", "inline constexpr Name NAMES[] = {"]
    lines += [f'  {{"{r.inst_name}", {r.inst_name}}},' for r in regs] + ["};"]
    lines += [f"inline constexpr uint32_t FIRST_COUNTER = 0x{FIRST_COUNTER:03X};"]
    lines += [f"inline constexpr uint32_t END_COUNTERS = 0x{END_COUNTERS:03X};", "}  // namespace reg"]
    return "\n".join(lines) + "\n"


def markdown(top: AddrmapNode, regs: list[RegNode]) -> str:
    """docs/registers.md."""
    lines = [f"<!-- {SPDX} -->", f"<!-- {ORIGIN} -->", "", f"# {top.get_property('name')}", "", top.get_property("desc")]
    lines += ["Set-up registers (RW, other than CTRL and IRQ) ignore writes while a frame runs. Bits not listed read 0."]
    lines += ["Accesses outside the map answer SLVERR.", ""]
    lines += ["| offset | register | bits | access | reset | meaning |", "|---|---|---|---|---|---|"]
    for reg in regs:
        texts = [reg.get_property("name"), reg.get_property("desc")]
        about = ". ".join(t.rstrip(".") for t in texts if t) + "."
        fields = reg.fields()
        if len(fields) == 1 and fields[0].get_property("desc"):
            about += " " + fields[0].get_property("desc")
        for n, field in enumerate(fields):
            name = f"{reg.inst_name}" + ("" if field.inst_name == "value" else f".{field.inst_name}")
            bits = f"{field.high}:{field.low}" if field.width > 1 else f"{field.low}"
            reset = field.get_property("reset")
            meaning = about if n == 0 else ""
            if len(fields) > 1 and field.get_property("desc"):
                meaning = (meaning + f" {field.inst_name}: " + field.get_property("desc")).strip()
            offset = f"0x{reg.address_offset:03X}" if n == 0 else ""
            shown = "–" if reset is None else f"{reset:#x}" if reset > 9 else str(reset)
            lines.append(f"| {offset} | `{name}` | {bits} | {access(field)} | {shown} | {meaning} |")
    return "\n".join(lines) + "\n"


def generate() -> dict[Path, str]:
    """Every generated file with its text."""
    top = elaborate(RDL)
    regs = list(top.registers())
    files = {ROOT / "rtl/top/regs" / name: text for name, text in verilog(top).items()}
    files[ROOT / "scripts/raycore/regs.py"] = python(regs)
    files[ROOT / "sim/rc_regs.h"] = header(regs)
    files[ROOT / "docs/registers.md"] = markdown(top, regs)
    return files


def stale() -> list[Path]:
    """Generated files that differ from what the description says."""
    return [path for path, text in generate().items() if not path.exists() or path.read_text() != text]


def main() -> int:
    """Command line."""
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    parser.add_argument("--check", action="store_true", help="write nothing, fail if a file is out of date")
    if parser.parse_args().check:
        for path in (old := stale()):
            print(f"{path.relative_to(ROOT)} is out of date: run scripts/tools/gen_regs.py", file=sys.stderr)
        return bool(old)
    for path, text in generate().items():
        path.parent.mkdir(parents=True, exist_ok=True)
        path.write_text(text)
    return 0


if __name__ == "__main__":
    sys.exit(main())
