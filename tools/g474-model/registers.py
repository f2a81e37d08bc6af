"""The judge of every access to a register, by data that is not the model's own.

The register file (vendor.py) has what the chip's maker and others have published. An access
is judged by it before the model sees it: is there such a register, may it be read or written,
are bits that have no name left as a reset leaves them, is a field's value one that is listed,
does the peripheral have its clock and is it out of reset. What has no clock loses the access.
Whatever is found is in `run.json`, and fails the test. `EXCEPTIONS` are the places where the
data is at fault, or says less than the reference manual RM0440, each with its reason.
"""

import json
import pathlib
import sys

# Where `cargo xtask chip` puts it, in the folder of the packages.
NAME = "stm32g474re.json"
FORMAT = 1
CHIP = "stm32g474re"
VERSIONS = {"stm32g4": "0.16.0", "stm32-metapac": "21.0.0"}

CORE = 0xE000_0000
DEBUG = 0xE004_0000
# Registers of the core that the image may use (Armv7-M, B3.2 and C1): ours, by hand.
CORE_REGISTERS = (
    (0xE000_E010, 0xE000_E01F, "SysTick"),
    (0xE000_E100, 0xE000_E4EF, "NVIC"),
    (0xE000_ED00, 0xE000_ED8F, "SCB"),
    (0xE000_ED90, 0xE000_EDB8, "MPU"),
    (0xE000_EDF0, 0xE000_EDFF, "debug"),
    (0xE000_EF34, 0xE000_EF3F, "FPU"),
)
# Names of the first source, and whose clock they have by the second one.
FED_BY = {
    "ADC12_COMMON": "ADC1", "ADC345_COMMON": "ADC3", "COMP": "COMP1", "DMAMUX": "DMAMUX1",
    "OPAMP": "SYSCFG", "VREFBUF": "SYSCFG", "UART4": "UART4",
}  # fmt: skip
# (what, register, field) that are no fault of the image.
EXCEPTIONS = {}


class NoRegisters(Exception):
    """The register file cannot be used; the message says what to do."""


def find():
    """The register file beside the packages that this program imports."""
    for folder in map(pathlib.Path, sys.path):
        if (folder / NAME).is_file():
            return folder / NAME
    return pathlib.Path(NAME)


def load(path):
    """The register file, if it is this model's."""
    advice = "make it again: cargo xtask chip"
    try:
        data = json.loads(pathlib.Path(path).read_text())
    except OSError as why:
        raise NoRegisters(f"no register file {path} ({why.strerror}); {advice}") from why
    except ValueError as why:
        raise NoRegisters(f"register file {path} is broken ({why}); {advice}") from why
    if data.get("format") != FORMAT or data.get("chip") != CHIP:
        raise NoRegisters(
            f"register file {path}: format {data.get('format')} of {data.get('chip')}, "
            f"wanted {FORMAT} of {CHIP}; {advice}"
        )
    if data["made_from"] != VERSIONS:
        raise NoRegisters(
            f"register file {path}: made from {data['made_from']}, wanted {VERSIONS}; {advice}"
        )
    return data


class Register:
    """One register as the file has it, with masks that are asked for at every access."""

    def __init__(self, entry):
        self.name = f"{entry['peripheral']}.{entry['name'].upper()}"
        self.bits, self.reset = entry["bits"], entry["reset"]
        self.readable, self.writable = entry["read"], entry["write"]
        self.fields = {
            name: (field["at"], (1 << field["width"]) - 1, field.get("write"), field.get("values"))
            for name, field in entry["fields"].items()
        }
        self.mask = {"known": 0, "read only": 0}
        for at, mask, how, _ in self.fields.values():
            self.mask["known"] |= mask << at
            self.mask[how or "read only"] = self.mask.get(how or "read only", 0) | mask << at
        # A bit of one meaning that is read only may be written in the register's other one.
        for how, mask in self.mask.items():
            if how not in ("known", "read only"):
                self.mask["read only"] &= ~mask
        self.listed = [
            (name, at, mask, set(values))
            for name, (at, mask, _, values) in self.fields.items()
            if values
        ]

    def takes(self, old, value):
        """What a store leaves, as far as the fields say."""
        kept = self.mask["read only"]
        value = value & ~kept | old & kept
        for how, act in (
            ("clear by 1", lambda mask: old & ~value & mask),
            ("clear by 0", lambda mask: old & value & mask),
            ("set by 1", lambda mask: (old | value) & mask),
        ):
            if mask := self.mask.get(how):
                value = value & ~mask | act(mask)
        return value


class Judge:
    """Looks at every access; tells the bus whether it reaches a register."""

    def __init__(self, bus, data):
        self.bus, self.data = bus, data
        self.registers = {int(at): Register(entry) for at, entry in data["registers"].items()}
        self.gates = {}
        for at, entry in data["registers"].items():
            name = FED_BY.get(entry["peripheral"], entry["peripheral"])
            part = data["peripherals"].get(name, {})
            self.gates[int(at)] = (part.get("enable"), part.get("reset"))
        # Registers that a reset bit of the RCC puts back.
        self.resets = {}
        for at, (_, reset) in self.gates.items():
            if reset:
                self.resets.setdefault(reset[0], {}).setdefault(reset[1], []).append(at)
        self.counts = {"read": 0, "written": 0, "lost": 0, "core": 0, "clocks": 0}
        self.touched, self.findings, self.excepted = set(), {}, {}

    def reset_value(self, address):
        """What a reset leaves in a register."""
        register = self.registers.get(address)
        return register.reset if register else 0

    def find(self, what, register, field="", detail=""):
        """A finding; the first of its kind keeps its place."""
        key = (what, register, field)
        into = self.excepted if key in EXCEPTIONS else self.findings
        entry = into.setdefault(
            key,
            {
                "what": what,
                "register": register,
                "field": field,
                "detail": detail,
                "s": self.bus.now / self.bus.TICK_HZ,
                "near": hex(self.bus.core.place()),
                "times": 0,
            },
        )
        entry["times"] += 1

    def _known(self, address, kind):
        """The register at an address, if an access to it arrives."""
        register = self.registers.get(address)
        if register is None:
            if CORE <= address < DEBUG:
                self.counts["core"] += 1
                if not any(first <= address <= last for first, last, _ in CORE_REGISTERS):
                    self.find("no such register of the core", hex(address))
                return None, True
            self.find("no such register", hex(address))
            return None, False
        self.counts[kind] += 1
        self.touched.add(address)
        enable, reset = self.gates[address]
        bus = self.bus
        if enable:
            self.counts["clocks"] += 1
            if not bus.stored(enable[0]) >> enable[1] & 1:
                self.counts["lost"] += 1
                self.find("has no clock", register.name, enable[2])
                return register, False
        if reset and bus.stored(reset[0]) >> reset[1] & 1:
            self.counts["lost"] += 1
            self.find("is held in reset", register.name, reset[2])
            return register, False
        return register, True

    def read(self, address):
        """Whether a load finds a register."""
        register, arrives = self._known(address, "read")
        if register and arrives and not register.readable:
            self.find("is write only", register.name)
        return arrives

    def write(self, address, value, touched):
        """Whether a store finds a register; `touched` are the bits of the bytes written."""
        register, arrives = self._known(address, "written")
        if register is None or not arrives:
            return arrives
        if not register.writable:
            self.find("is read only", register.name, detail=hex(value))
            return False
        changed = (value ^ register.reset) & touched & ~register.mask["known"]
        if changed:
            bits = ",".join(str(bit) for bit in range(32) if changed >> bit & 1)
            self.find("writes reserved bits", register.name, bits, hex(value))
        for name, at, mask, values in register.listed:
            if touched >> at & 1 and (value >> at & mask) not in values:
                self.find("writes no listed value", register.name, name, str(value >> at & mask))
        return True

    def report(self):
        """What goes into `run.json`."""
        return {
            "sources": self.data["made_from"],
            "accesses": self.counts,
            "registers": len(self.touched),
            "findings": list(self.findings.values()),
            "excepted": [entry | {"why": EXCEPTIONS[key]} for key, entry in self.excepted.items()],
        }


if __name__ == "__main__":
    # `registers.py FILE`: whether the model can use it.
    try:
        load(sys.argv[1])
    except NoRegisters as why:
        print(f"registers.py: {why}", file=sys.stderr)
        sys.exit(1)
