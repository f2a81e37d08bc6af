"""What the core executes, event by event, for models of its time (xtask/src/chip/trace.rs).

A file of records, each two little-endian 32-bit numbers: a value, and a word with the kind in its
upper 8 bits and a detail in its lower 24. It begins with a mark and ends with a count: one that was
cut short has no end.
"""

import struct

from unicorn import UC_HOOK_BLOCK, UC_HOOK_MEM_READ
from unicorn.arm_const import UC_ARM_REG_PC, UC_ARM_REG_XPSR

BEGIN = (0x3434_4B54, 0xFF00_0001)  # a mark, and the form's number
# Kind: its value, its detail.
BLOCK = 0  # address, bytes
LOAD = 1  # address in the flash, where the instruction is
ENTER = 2  # moment in ticks, the exception's number
LEAVE = 3  # moment
GO_ON = 4  # address at which the program goes on: what lies behind it was not executed
SLEEP = 5  # moment
WAKE = 6  # moment
MASKED = 7  # whether interrupts are masked as the file begins
END = 8  # records before it
STORE = 9  # address of a register, where the instruction is

# Bits of XPSR that say where in an IT block the core is (ARMv7-M, B1.4.2).
IT_STATE = 0x0600_FC00


class Trace:
    """Records of a stretch of the program."""

    def __init__(self, uc, bus, flash):
        """From now on, of what lies in the flash (address and bytes) every load too."""
        self.bus = bus
        self._records = bytearray(struct.pack("<II", *BEGIN))
        uc.hook_add(UC_HOOK_BLOCK, self._block)
        begin, length = flash
        uc.hook_add(UC_HOOK_MEM_READ, self._load, begin=begin, end=begin + length - 1)
        # What is translated already knows nothing of the hooks.
        uc.ctl_flush_tb()

    def add(self, kind, value, detail=0):
        """One record."""
        self._records += struct.pack("<II", value & 0xFFFF_FFFF, kind << 24 | detail & 0xFF_FFFF)

    def moment(self, kind, detail=0):
        """One record of now."""
        self.add(kind, self.bus.now, detail)

    def whole(self):
        """The file's bytes."""
        end = struct.pack("<II", len(self._records) // 8 - 1, END << 24)
        return bytes(self._records) + end

    def _block(self, _uc, address, size, _data):
        self.add(BLOCK, address, size)

    def _load(self, uc, _access, address, _size, _value, _data):
        self.add(LOAD, address, uc.reg_read(UC_ARM_REG_PC))
        # The emulator restores the state of an IT block for a hook and leaves it behind: the
        # next block would be taken for a part of it.
        state = uc.reg_read(UC_ARM_REG_XPSR)
        if state & IT_STATE:
            uc.reg_write(UC_ARM_REG_XPSR, state & ~IT_STATE)
