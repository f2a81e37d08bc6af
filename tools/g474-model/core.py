"""The Cortex-M4 of the model: memory, exceptions, and time that events make.

Instructions are executed by unicorn and take no time. Time goes on where the image sleeps
(`wfi`, `wfe`), event by event, and by a few ticks whenever it reads the clock. One interrupt is
served at a time, in the order of their numbers: priorities and preemption are not modelled.
"""

import ctypes
import mmap
import struct

import trace
from unicorn import (
    UC_ARCH_ARM,
    UC_ERR_INSN_INVALID,
    UC_HOOK_CODE,
    UC_HOOK_INTR,
    UC_HOOK_MEM_INVALID,
    UC_HOOK_MEM_READ,
    UC_HOOK_MEM_WRITE,
    UC_MODE_MCLASS,
    UC_MODE_THUMB,
    UC_PROT_ALL,
    Uc,
    UcError,
)
from unicorn.arm_const import (
    UC_ARM_REG_LR,
    UC_ARM_REG_PC,
    UC_ARM_REG_PRIMASK,
    UC_ARM_REG_R0,
    UC_ARM_REG_R12,
    UC_ARM_REG_SP,
    UC_CPU_ARM_CORTEX_M4,
)

FLASH, FLASH_BYTES = 0x0800_0000, 0x8_0000
RAM, RAM_BYTES = 0x2000_0000, 0x1_8000
# The memory coupled to the core: where it fetches from it, and behind RAM where data lie in it, at the
# top the stack.
COUPLED, STACK, COUPLED_BYTES = 0x1000_0000, 0x2001_8000, 0x8000
SYSTEM_FLASH = 0x1FFF_0000
PERIPHERALS, PERIPHERALS_BYTES = 0x4000_0000, 0x1010_0000
PRIVATE, PRIVATE_BYTES = 0xE000_0000, 0x10_0000

# Where a handler returns to; nothing of the image lies there.
RETURN = SYSTEM_FLASH + 0x100
# What the core pushes on entry with floating point in use.
FRAME_BYTES = 0x68
# Instructions that may let interrupts in again: `cpsie i`, and `msr primask` of a register.
CPSIE = b"\x62\xb6"
MSR_PRIMASK = b"\x10\x88"
# `wfi`, and `wfe`, whose event is taken for an interrupt.
SLEEPS = (b"\x30\xbf", b"\x20\xbf")

PAINT = 0xA5
# e_machine of an ELF file.
ARM = 40


class Stuck(Exception):
    """The image did what the core cannot do. (One that hangs, hangs this program as well.)"""


class NoImage(Exception):
    """What was given is no image for this chip; the message says why."""


def load_segments(path):
    """Physical address and bytes of every loaded part of an ELF file for this chip."""
    try:
        elf = path.read_bytes()
    except OSError as why:
        raise NoImage(f"{path}: {why.strerror}") from why
    if elf[:4] != b"\x7fELF":
        raise NoImage(f"{path}: no ELF file")
    if len(elf) < 52 or struct.unpack_from("<BxH", elf, 4)[0] != 1 or elf[18] != ARM:
        raise NoImage(f"{path}: an ELF file, but not of 32 bits for ARM")
    offset, size, count = (
        struct.unpack_from("<I", elf, 28)[0],
        *struct.unpack_from("<HH", elf, 42),
    )
    if offset + size * count > len(elf):
        raise NoImage(f"{path}: ends within its header")
    parts = []
    for k in range(count):
        kind, start, _, address, length = struct.unpack_from("<5I", elf, offset + k * size)
        if kind == 1 and length:
            parts.append((address, elf[start : start + length]))
            inside = FLASH <= address and address + length <= FLASH + FLASH_BYTES
            if not inside:
                raise NoImage(
                    f"{path}: has {length} bytes at {address:#x}, and the flash of the STM32G474RE "
                    f"is {FLASH:#x} to {FLASH + FLASH_BYTES - 1:#x}; an image for another chip?"
                )
    if not any(address == FLASH for address, _ in parts):
        raise NoImage(f"{path}: has no vectors at {FLASH:#x}; an image for another chip?")
    return parts


def may_unmask(code):
    """Whether an instruction may let interrupts in again."""
    return code[:2] == CPSIE or (code[2:] == MSR_PRIMASK and code[1] == 0xF3 and code[0] >> 4 == 8)


class Core:
    """Executes an image until an end of time."""

    def __init__(self, path, bus):
        self.bus = bus
        bus.core = self
        self.uc = uc = Uc(UC_ARCH_ARM, UC_MODE_THUMB | UC_MODE_MCLASS)
        uc.ctl_set_cpu_model(UC_CPU_ARM_CORTEX_M4)
        uc.mem_map(FLASH, FLASH_BYTES)
        uc.mem_write(FLASH, b"\xff" * FLASH_BYTES)
        uc.mem_map(RAM, RAM_BYTES)
        # Private: a process that is forked from this one has a memory of its own.
        self.coupled = mmap.mmap(-1, COUPLED_BYTES, flags=mmap.MAP_PRIVATE | mmap.MAP_ANONYMOUS)
        memory = (ctypes.c_ubyte * COUPLED_BYTES).from_buffer(self.coupled)
        for at in (COUPLED, STACK):
            uc.mem_map_ptr(at, COUPLED_BYTES, UC_PROT_ALL, ctypes.addressof(memory))
        # Not up to the memory: a stack that leaves it must not find anything there.
        uc.mem_map(SYSTEM_FLASH, 0x8000)
        uc.mem_write(RETURN, b"\x00\xbf" * 4)
        for address, data in load_segments(path):
            uc.mem_write(address, data)
            for at in range(0, len(data) - 1, 2):
                if may_unmask(data[at : at + 4]):
                    here = address + at
                    uc.hook_add(UC_HOOK_CODE, self._enables, begin=here, end=here)
        for base, length in (
            (PERIPHERALS, PERIPHERALS_BYTES),
            (PRIVATE, PRIVATE_BYTES),
        ):
            uc.mmio_map(base, length, self._read, base, self._write, base)
        uc.hook_add(UC_HOOK_INTR, self._exception)
        uc.hook_add(UC_HOOK_MEM_INVALID, self._invalid)
        end = FLASH + FLASH_BYTES - 1
        uc.hook_add(UC_HOOK_MEM_WRITE, self._programs, begin=FLASH, end=end)
        self.has_slept = False
        self.trouble = None
        self.served = {}
        self.trace = None
        uc.hook_add(UC_HOOK_MEM_WRITE, self._program_comes, begin=COUPLED, end=COUPLED)
        uc.mem_write(RAM, bytes([PAINT]) * RAM_BYTES)
        uc.mem_write(STACK, bytes([PAINT]) * COUPLED_BYTES)
        self.guards, self.parts, self.asked = [], [], None
        self.stack_end, self.start_stack = STACK, 0
        self.restart()

    def restart(self):
        """What a reset does to the core: memory stays."""
        self.wants = self.in_handler = False
        self.protect([])
        stack, reset = struct.unpack("<II", self.uc.mem_read(FLASH, 8))
        self.stack_top = stack
        self.uc.reg_write(UC_ARM_REG_PRIMASK, 0)
        self.uc.reg_write(UC_ARM_REG_SP, stack)
        self.pc = reset | 1

    def place(self):
        """Address of the program that is executed, to within a few instructions."""
        return self.uc.reg_read(UC_ARM_REG_PC) & ~1

    def on_read(self, address, length, act):
        """Calls `act` with the address of every load from there."""
        self.uc.hook_add(
            UC_HOOK_MEM_READ,
            lambda _uc, _access, at, _size, _value, _data: act(at),
            begin=address,
            end=address + length - 1,
        )

    def start_trace(self):
        """From now on everything that is executed is kept."""
        self.trace = trace.Trace(self.uc, self.bus, (FLASH, FLASH_BYTES))
        self.trace.add(trace.MASKED, self.uc.reg_read(UC_ARM_REG_PRIMASK))

    def vector(self, number):
        """Address of an exception's handler."""
        return struct.unpack("<I", self.uc.mem_read(FLASH + 4 * number, 4))[0]

    def stack_used(self):
        """Bytes of the stack written, from its top to the lowest, since it ends where it does."""
        base = self.stack_end
        painted = bytes(self.uc.mem_read(base, self.stack_top - base))
        untouched = len(painted) - len(painted.lstrip(bytes([PAINT])))
        return len(painted) - untouched

    def protect(self, parts):
        """From the next stretch of the program on these parts of memory, and no others, are read-only."""
        # A store at which the program is stopped is executed again when it goes on.
        if parts != self.parts:
            self.asked = self.parts = parts
            self.uc.emu_stop()

    def _protect(self):
        uc, parts, self.asked = self.uc, self.parts, None
        for hook in self.guards:
            uc.hook_del(hook)
        self.guards = [
            uc.hook_add(UC_HOOK_MEM_WRITE, self._refuses, begin=at, end=at + length - 1)
            for at, length in parts
        ]
        # What is translated already knows nothing of the hooks.
        uc.ctl_flush_tb()
        ends = [at + length for at, length in parts if STACK <= at < STACK + COUPLED_BYTES]
        self.stack_end = max(ends, default=STACK)
        if ends:
            # What the stack needs from here on is told from what it needed before.
            below = uc.reg_read(UC_ARM_REG_SP) - self.stack_end
            uc.mem_write(self.stack_end, bytes([PAINT]) * below)

    def interrupt_check(self):
        """Called when something may have become pending: ends this stretch of the program."""
        if not self.in_handler and self.bus.pending_interrupt() is not None:
            self.wants = True
            if not self.uc.reg_read(UC_ARM_REG_PRIMASK):
                self.uc.emu_stop()

    def run(self, until):
        """Runs to a moment, in ticks; false when the image has reset the chip before."""
        bus = self.bus
        while bus.now < until and bus.reset_by is None:
            if bus.hung:
                # The program goes round in a loop, with interrupts let in; a core that is
                # halted serves none.
                self.uc.reg_write(UC_ARM_REG_PRIMASK, 0)
                bus.advance(min(bus.next_event(), until))
                if not bus.halted:
                    self._serve()
                continue
            self._execute(self.pc, 0xFFFF_FFFE)
            self.pc = self.uc.reg_read(UC_ARM_REG_PC) | 1
            if length := self._unmask():
                self.pc += length
            self._went_on(self.pc)
            if not length and self._slept():
                self.has_slept = True
                self._note(trace.SLEEP)
                # Only an interrupt that is let in, an exception or a reset ends a sleep.
                while bus.pending_interrupt() is None and bus.exception is None:
                    if bus.now >= until or bus.reset_by is not None or bus.hung:
                        break
                    bus.advance(min(bus.next_event(), until))
                self._note(trace.WAKE)
            if bus.exception is not None:
                self._note(trace.ENTER, bus.exception)
                self.call(self.vector(bus.exception))
                self._note(trace.LEAVE)
                bus.exception = None
            self._serve()
        return bus.reset_by is None

    def call(self, handler):
        """Enters a handler as the core would and runs it to its return."""
        uc = self.uc
        context = uc.context_save()
        stack = uc.reg_read(UC_ARM_REG_SP) - FRAME_BYTES & ~7
        if stack < self.stack_end:
            raise Stuck(f"the stack has no room for an exception's frame at {stack:#x}")
        uc.mem_write(stack, bytes(FRAME_BYTES))
        uc.reg_write(UC_ARM_REG_SP, stack)
        uc.reg_write(UC_ARM_REG_LR, RETURN | 1)
        self.in_handler = True
        pc = handler | 1
        while self.bus.reset_by is None:
            self._execute(pc, RETURN)
            pc = uc.reg_read(UC_ARM_REG_PC) | 1
            if pc & ~1 == RETURN:
                break
            pc += self._unmask()
            self._went_on(pc)
        self.in_handler = False
        if self.bus.reset_by is None:
            uc.context_restore(context)

    def _serve(self):
        """Serves what is pending, unless interrupts are masked."""
        while not self.uc.reg_read(UC_ARM_REG_PRIMASK):
            number = self.bus.pending_interrupt()
            if number is None or self.bus.reset_by is not None:
                break
            self.served[number] = self.served.get(number, 0) + 1
            self.bus.take(number)
            self._note(trace.ENTER, 16 + number)
            self.call(self.vector(16 + number))
            self._note(trace.LEAVE)
        self.wants = False

    def _execute(self, pc, until):
        self.trouble = None
        if self.asked is not None:
            self._protect()
        try:
            self.uc.emu_start(pc, until)
        except UcError as why:
            # The emulator ends at a `wfe` as at an instruction that it does not know.
            if why.errno != UC_ERR_INSN_INVALID or not self._slept():
                here = self.uc.reg_read(UC_ARM_REG_PC)
                raise Stuck(f"{why} at {here:#x} ({self.trouble})") from why
        if self.trouble:
            raise Stuck(self.trouble)

    def _slept(self):
        here = self.uc.reg_read(UC_ARM_REG_PC) & ~1
        return bytes(self.uc.mem_read(here - 2, 2)) in SLEEPS

    def _unmask(self):
        """Executes the instruction at which the program was held back; its length, or 0."""
        code = bytes(self.uc.mem_read(self.uc.reg_read(UC_ARM_REG_PC) & ~1, 4))
        if not may_unmask(code):
            return 0
        if code[:2] == CPSIE:
            self.uc.reg_write(UC_ARM_REG_PRIMASK, 0)
            return 2
        register = UC_ARM_REG_R12 if code[0] & 15 == 12 else UC_ARM_REG_R0 + (code[0] & 15)
        self.uc.reg_write(UC_ARM_REG_PRIMASK, self.uc.reg_read(register) & 1)
        return 4

    def _enables(self, uc, _address, _size, _data):
        if self.wants or self.bus.pending_interrupt() is not None:
            uc.emu_stop()

    def _note(self, kind, detail=0):
        if self.trace:
            self.trace.moment(kind, detail)

    def _went_on(self, pc):
        if self.trace:
            self.trace.add(trace.GO_ON, pc & ~1)

    def _read(self, _uc, offset, size, base):
        return self.bus.read(base + offset, size)

    def _write(self, _uc, offset, size, value, base):
        if self.trace:
            here = self.uc.reg_read(UC_ARM_REG_PC)
            self.trace.add(trace.STORE, base + offset, here)
        self.bus.write(base + offset, size, value)

    def _programs(self, uc, _access, address, _size, _value, _data):
        if not self.bus.flash.may_program():
            self.trouble = f"store to locked flash at {address:#x}"
            uc.emu_stop()
        self.bus.flash.programmed(address)

    def _program_comes(self, *_):
        self.start_stack = self.start_stack or self.stack_used()

    def _refuses(self, uc, _access, address, _size, _value, _data):
        here = uc.reg_read(UC_ARM_REG_PC)
        self.trouble = f"store to read-only memory at {address:#x} from {here:#x}"
        uc.emu_stop()

    def _exception(self, uc, number, _data):
        self.trouble = f"exception {number} at {uc.reg_read(UC_ARM_REG_PC):#x}"
        uc.emu_stop()

    def _invalid(self, uc, _access, address, _size, _value, _data):
        self.trouble = f"access to {address:#x} from {uc.reg_read(UC_ARM_REG_PC):#x}"
        return False
