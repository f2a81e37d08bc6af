"""The memory protection unit, as far as the image uses it: regions that are read-only."""

CTRL, NUMBER, BASE, ATTRIBUTES = 0xE000_ED94, 0xE000_ED98, 0xE000_ED9C, 0xE000_EDA0
# MPU_RBAR: the region's number is with its address.
VALID = 1 << 4
READ_ONLY = (0b110, 0b111)


class Mpu:
    """Regions as they are written (ARMv7-M, B3.5); they hold from the moment it is switched on."""

    def __init__(self, bus):
        self.bus = bus
        self.base = {}
        self.attributes = {}
        self.number = 0

    def write(self, address, value):
        """True where the register is one of its own."""
        if address == NUMBER:
            self.number = value & 7
        elif address == BASE:
            if value & VALID:
                self.number = value & 7
            self.base[self.number] = value & ~0x1F
        elif address == ATTRIBUTES:
            self.attributes[self.number] = value
        elif address == CTRL:
            self.bus.core.protect(self.read_only() if value & 1 else [])
        else:
            return False
        return True

    def read_only(self):
        """Start and length of what may not be written, part by part of an eighth of a region."""
        parts = []
        for number, value in self.attributes.items():
            if not value & 1:
                continue
            if value >> 24 & 7 not in READ_ONLY:
                self.bus.judge.find("gives rights that the model does not know", "MPU")
            eighth = 2 << (value >> 1 & 0x1F) >> 3
            on = (k for k in range(8) if not value >> 8 + k & 1)
            parts += [(self.base[number] + k * eighth, eighth) for k in on]
        return parts
