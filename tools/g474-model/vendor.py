#!/usr/bin/env python3
"""Makes the register file of the STM32G474RE from two published packages.

    vendor.py STM32G4 STM32_METAPAC FILE

STM32G4 is the folder of the crate `stm32g4`, which is made from the maker's own SVD file as
its community mends it: every register with its reset value, access and fields, the values a
field may have, the bits that are cleared or set by writing them. STM32_METAPAC is that of
`stm32-metapac`: the bits of the RCC that clock and reset a peripheral, its clock, its pins with
their functions' numbers, its DMA requests, triggers and interrupts. The second one is what the
image's own driver layer is made of; the first is not. FILE is JSON; nothing of either package
is kept here. Both are MIT or Apache-2.0.
"""

import json
import pathlib
import re
import sys

CHIP = "stm32g474"
EXACT_CHIP = "stm32g474re"
# Of FILE; whoever reads another one is told to make it again.
FORMAT = 1
KINDS = {"1C": "clear by 1", "0C": "clear by 0", "1S": "set by 1", "1T": "toggle by 1"}

ACCESSOR = re.compile(
    r"///(0x[0-9a-f]+)(?:\.\.0x[0-9a-f]+)? - .*?\n"
    r"(?:\s*///.*\n)*\s*#\[inline\(always\)\]\n"
    r"\s*pub const fn (\w+)\(&self(, n: usize)?\) -> &(\w+) \{"
)
READER = re.compile(
    r"pub fn (\w+)\(&self\) -> \w+ \{\s*\w+_R::new\(\s*"
    r"\(?\(?self\.bits(?: >> (\d+))?\)?(?: & (0x[0-9a-f_]+|\d+))?\)?"
)
WRITER = re.compile(r"pub fn (\w+)\(&mut self\) -> \w+<\w+> \{\s*(\w+)_W::new\(self, (\d+)\)")
WRITER_TYPE = re.compile(
    r"pub type (\w+)_W<'a, REG> =\s+crate::(Field|Bit)Writer([01][CST])?<'a, REG(?:, (\d+))?"
    r"(?:, (\w+))?(?:, crate::(\w+))?>;"
)
ENUM = re.compile(r"pub enum (\w+) \{(.*?)\n\}", re.DOTALL)
WORD = re.compile(r"impl crate::RegisterSpec for \w+ \{\s*type Ux = u(\d+);")
RESET = re.compile(r"const RESET_VALUE: u\d+ = (0x[0-9a-f_]+|\d+);")


class Unreadable(Exception):
    """A package is not laid out as this program expects."""


def number(text):
    """A literal of Rust."""
    return int(text.replace("_", ""), 0)


def text_of(path):
    """A file of a package."""
    try:
        return path.read_text()
    except OSError as why:
        raise Unreadable(f"{path}: {why.strerror}; this package has another layout") from why


def file_of(path, module):
    """The file of a register that a block names, which may be another block's."""
    text = text_of(path)
    own = path.with_suffix("")
    if near := re.search(rf"pub use (\w+) as {module};", text):
        return file_of(path, near[1])
    there = rf"pub use crate::{CHIP}::([\w:]+)::"
    far = re.search(rf"{there}(\w+) as {module};", text) or re.search(rf"{there}({module});", text)
    if not far:
        return own / f"{module}.rs"
    root = next(parent for parent in path.parents if parent.name == CHIP)
    return root / far[1].replace("::", "/") / f"{far[2]}.rs"


def fields_of(path):
    """The fields of one register: place, width, values, what writing them does."""
    text = text_of(path)
    root = next(parent for parent in path.parents if parent.name == CHIP)
    beside = {
        path.parent / f"{other}.rs" for other in re.findall(r"pub use super::(\w+)::\w+", text)
    } | {
        root / (other.replace("::", "/") + ".rs")
        for other in re.findall(rf"pub use crate::{CHIP}::([\w:]+)::\w+", text)
    }
    every = text + "".join(text_of(other) for other in sorted(beside))
    enums = {
        name: sorted(number(value) for value in re.findall(r"= (\d+)", body))
        for name, body in ENUM.findall(every)
    }
    types = {kind: rest for kind, *rest in WRITER_TYPE.findall(every)}
    for old, new in re.findall(r"pub use (?:[\w:]+::)?(\w+)_W as (\w+)_W;", text):
        if old in types:
            types[new] = types[old]
    found = {}
    for name, at, mask in READER.findall(text):
        mask = number(mask) if mask else (1 << 32) - 1
        found[name] = {"at": number(at or "0"), "width": mask.bit_length()}
    for name, kind, at in WRITER.findall(text):
        if kind not in types:
            raise Unreadable(f"{path}: no type {kind}_W; this package has another layout")
        sort, does, width, enum, safety = types[kind]
        field = found.setdefault(name, {"at": number(at)})
        field["width"] = number(width or "8") if sort == "Field" else 1
        field["write"] = KINDS.get(does, "plain")
        # A field with every value named has nothing to be judged by.
        if enum in enums and safety != "Safe" and sort == "Field":
            field["values"] = enums[enum]
    return found


def registers_of(folder, module, offset):
    """Every register of a block: offset, name, description."""
    block = folder / f"{module}.rs"
    text = text_of(block)
    for at, name, is_array, kind in ACCESSOR.findall(text):
        if is_array and re.search(rf"pub const fn \w+\(&self\) -> &{kind} \{{", text):
            continue
        inner = file_of(block, kind.lower())
        at = offset + number(at)
        if (folder / module / kind.lower()).is_dir():
            for deeper, lower, register in registers_of(folder / module, kind.lower(), at):
                yield deeper, f"{name}_{lower}", register
            continue
        body = text_of(inner)
        reset = RESET.search(body)
        word = WORD.search(body)
        if not word:
            raise Unreadable(f"{inner}: no width of a register; this package has another layout")
        register = {
            "bits": number(word[1]),
            "reset": number(reset[1]) if reset else 0,
            "read": "crate::Readable for" in body,
            "write": "crate::Writable for" in body,
            "fields": fields_of(inner),
        }
        count = re.search(rf"\b{name}: \[{kind}; (\d+)\]", text) if is_array else None
        for k in range(number(count[1]) if count else 1):
            yield at + k * register["bits"] // 8, name.upper() + (str(k) if count else ""), register


def registers(package):
    """Every register of the chip by its address."""
    folder = package / "src" / CHIP
    found = {}
    blocks = re.findall(
        r"pub type (\w+) = crate::Periph<(\w+)::RegisterBlock, (0x[0-9a-f_]+)>;",
        text_of(folder / "mod.rs"),
    )
    for peripheral, module, base in blocks:
        for offset, name, register in registers_of(folder, module, 0):
            at = number(base) + offset
            known = found.setdefault(
                at, register | {"name": name, "peripheral": peripheral, "fields": {}}
            )
            # One address with two meanings (a capture or a compare mode) is both, and no value
            # of a field that both have is wrong.
            for name, field in register["fields"].items():
                if name in known["fields"]:
                    field = {key: value for key, value in field.items() if key != "values"}
                known["fields"][name] = field
            known["read"] |= register["read"]
            known["write"] |= register["write"]
    return found


def bits_of(package, kind, register):
    """The bit of every one-bit field of a register of the RCC."""
    text = text_of(package / "src/registers" / f"{kind}.rs")
    found = re.search(
        rf'FieldSet \{{\s*name: "{register.capitalize()}",.*?\n        \}},', text, re.DOTALL
    )
    if not found:
        raise Unreadable(f"{package}: {kind}.rs has no register {register}")
    fields = re.findall(
        r'name: "(\w+)",\n.*?offset: (\d+)', found[0].split("fields:")[1], re.DOTALL
    )
    return {name: number(at) for name, at in fields}


def peripherals(package):
    """What feeds a peripheral and where it leads: clocks, pins, requests, triggers, interrupts."""
    include = text_of(package / "src/chips" / EXACT_CHIP / "metadata.rs")
    shared = re.search(r'include!\("\.\./(\w+\.rs)"\)', include)
    if not shared:
        raise Unreadable(f"{package}: no data of {EXACT_CHIP}")
    text = text_of(package / "src/chips" / shared[1])
    kind = re.search(r'registers/(rcc_\w+)\.rs"', text)[1]
    offsets = dict(
        re.findall(
            r'name: "(\w+)",\s*description: [^\n]*\n\s*array: None,\s*byte_offset: (0x[0-9a-f]+)',
            text_of(package / "src/registers" / f"{kind}.rs"),
        )
    )
    rcc = number(re.search(r'name: "RCC",\s*address: (0x[0-9a-f]+)', text)[1])
    known = {}

    def bit(part, what):
        named = re.search(
            rf'{what}: Some\(PeripheralRccRegister \{{\s*register: "(\w+)",\s*field: "(\w+)"', part
        )
        if not named:
            return None
        register, field = named.groups()
        if register not in known:
            known[register] = bits_of(package, kind, register)
        at = rcc + number(offsets[register.lower()])
        return [at, known[register][field.lower()], f"{register}.{field}"]

    listed = text.split("static INTERRUPTS")[0]
    found = {}
    for part in re.split(r"\n    Peripheral \{\n", listed)[1:]:
        name, base = re.search(r'name: "(\w+)",\s*address: (0x[0-9a-f]+)', part).groups()
        clock = re.search(r'kernel_clock: Clock\("(\w+)"\)', part)
        found[name] = {
            "base": number(base),
            "enable": bit(part, "enable"),
            "reset": bit(part, "reset"),
            "bus": (re.search(r'bus_clock: "(\w+)"', part) or [None, None])[1],
            "clock": clock[1] if clock else None,
            "pins": [
                [pin, signal, number(af) if af else None]
                for pin, signal, af in re.findall(
                    r'pin: "(\w+)",\s*signal: "(\w+)",\s*af: (?:Some\((\d+)\)|None)', part
                )
            ],
            "requests": {
                signal: number(request)
                for signal, request in re.findall(
                    r'PeripheralDmaChannel \{\s*signal: "(\w+)",.*?request: Some\((\d+)\)',
                    part,
                    re.DOTALL,
                )
            },
            "triggers": dict(
                re.findall(r'PeripheralTrigger \{\s*signal: "(\w+)",\s*source: "(\w+)"', part)
            ),
            "interrupts": re.findall(
                r'PeripheralInterrupt \{\s*signal: "\w+",\s*interrupt: "(\w+)"', part
            ),
        }
    interrupts = re.findall(r'name: "(\w+)",\s*number: (\d+)', text.split("static INTERRUPTS")[1])
    return found, {name: number(at) for name, at in interrupts}


def version(package, name):
    """The version of a package, by its own manifest."""
    text = text_of(package / "Cargo.toml")
    if not re.search(rf'^name = "{name}"$', text, re.MULTILINE):
        raise Unreadable(f"{package}: not the package {name}")
    return re.search(r'^version = "([^"]+)"$', text, re.MULTILINE)[1]


def main():
    """Both packages into one file."""
    if len(sys.argv) != 4:
        print("vendor.py: takes STM32G4 STM32_METAPAC FILE", file=sys.stderr)
        return 2
    first, second, target = map(pathlib.Path, sys.argv[1:])
    try:
        parts, interrupts = peripherals(second)
        made = {
            "format": FORMAT,
            "chip": EXACT_CHIP,
            "made_from": {
                "stm32g4": version(first, "stm32g4"),
                "stm32-metapac": version(second, "stm32-metapac"),
            },
            "registers": registers(first),
            "peripherals": parts,
            "interrupts": interrupts,
        }
    except Unreadable as why:
        print(f"vendor.py: {why}", file=sys.stderr)
        return 1
    target.write_text(json.dumps(made, separators=(",", ":")))
    return 0


if __name__ == "__main__":
    sys.exit(main())
