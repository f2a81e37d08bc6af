"""The registers of the STM32G474 that the image touches, and the pins behind them.

Every access is judged by the register file first (registers.py), which also has what a reset
leaves and what a store changes; a register that no part here knows keeps what is written to it.
How parts behave is the reference manual's, RM0440. What is told at start-up (a ready bit, the
end of a calibration) is told at once; what the image does with converters, timers, DMA and the
break input follows the registers it wrote: a wrong channel, trigger, polarity or pin gives
wrong samples here too.
"""

from analog import Analog
from clocks import WATCHED, ClockTree
from dma import DMA1, Dma, Flags
from entropy import Random
from memo import until_written
from mpu import Mpu
from pins import Pins
from registers import Judge
from safety import NMI, FlashMemory, Supply
from serial import Serial
from timers import BreakTimer, Clock

RCC, FLASH, PWR = 0x4002_1000, 0x4002_2000, 0x4000_7000
GPIO = {port: 0x4800_0000 + 0x400 * k for k, port in enumerate("ABCDEFG")}
IWDG = 0x4000_3000
NVIC_ENABLE, NVIC_DISABLE = 0xE000_E100, 0xE000_E180
NVIC_PEND, NVIC_UNPEND = 0xE000_E200, 0xE000_E280
AIRCR = 0xE000_ED0C

TICK_HZ = 163_200_000
LSI_HZ = 32_000
# From the order to a pin of the slowest kind (25 ns at 50 pF) to its input register.
PIN_TICKS = 8
# FLASH_OPTR of a chip that nobody has set up (RM0440): brown-out at 1.7 V, no parity.
AS_DELIVERED = 0xFFEF_F8AA
# Written while the image runs, and nothing that is kept until a register is written hangs on
# them (memo.py): flags, compare values, the master enable, DACs' codes, pins' levels.
TIM1, TIM2 = 0x4001_2C00, 0x4000_0000
RUNNING = (
    {TIM1 + at for at in (0x10, 0x34, 0x38, 0x3C, 0x40, 0x44)}
    | {TIM2 + at for at in (0x0C, 0x10, 0x34)}
    | {base + at for base in GPIO.values() for at in (0x18, 0x28)}
    | {0x5000_0000 + at for at in (0, 0x100, 0x400, 0x500, 0x600, 0x808, 0x1008, 0x1408)}
    | {IWDG, 0x4000_4420, AIRCR}
)
# Bits of RCC_CSR.
RESET_FLAG = {"power-on": 27, "brown-out": 27, "software": 28, "watchdog": 29, "pin": 26}


class Bus:
    """All registers, by address."""

    TICK_HZ = TICK_HZ

    def __init__(self, script, registers):
        self.now = 0
        self.judge, self.data = Judge(self, registers), registers
        self.pins = Pins(self, registers)
        self.longest_unfed = 0
        self.core = self.changes = None
        self.trace = []
        self.register = {}
        self.levels = {}
        self.options = AS_DELIVERED
        self.script = sorted(script, key=lambda step: step[0])
        self.flash = FlashMemory(self)
        self.analog = Analog(self)
        self.serial = Serial(self)
        self.power = BreakTimer(self)
        self.random = Random(self, RCC + 0x98)
        self._start("power-on")

    def _start(self, cause):
        """Registers as a reset leaves them."""
        self.clock, self.supply, self.tree = Clock(self), Supply(self), ClockTree(self)
        every = self.power.every
        self.power = BreakTimer(self)
        self.power.every = every
        self.analog.restart()
        self.parts = [self.clock, self.power, self.analog, self.serial, self.flash, self.supply]
        self.dma_flags = Flags(self)
        self.parts += [self.random, self.dma_flags]
        self.mpu = Mpu(self)
        # What a reset leaves is the register file's, but for the option bytes and why there was
        # a reset: flags of those before it stay until they are taken back.
        flags = self.register.get(RCC + 0x94, 0) & 0xFE00_0000 | 1 << RESET_FLAG[cause]
        self.register = {FLASH + 0x20: self.options, RCC + 0x94: flags}
        self.settled = {}
        self.enabled, self.pended = set(), set()
        self.dma = [Dma(self, k) for k in range(8)]
        self.fed = self.watchdog_ticks = self.reset_by = self.exception = None
        self.hung = self.halted = self.watchdog_open = False
        self.before = {}

    def restart(self):
        """After a reset: memory, voltages and what the link has said stay."""
        cause = self.reset_by
        self.power.reset()
        self._start(cause)

    # --- registers

    def stored(self, address):
        """The word kept at an address."""
        found = self.register.get(address)
        return self.judge.reset_value(address) if found is None else found

    @property
    def bus(self):
        """Itself: what is asked of it is kept like what is asked of a part."""
        return self

    @until_written
    def channel(self, request):
        """The DMA channel that serves a request."""
        return next((dma for dma in self.dma if dma.enabled_for(request)), None)

    def request(self, peripheral, signal):
        """The number of a peripheral's DMA request."""
        return self.data["peripherals"][peripheral]["requests"][signal]

    def read(self, address, size):
        """A load of the image."""
        word = address & ~3
        value = self._word(word) if self.judge.read(word) else 0
        return value >> 8 * (address & 3) & (1 << 8 * size) - 1

    def _word(self, address):
        value = self.stored(address)
        for part in self.parts:
            if (found := part.read(address)) is not None:
                return found
        if address == RCC:  # every oscillator that is on is ready, and the PLL that has one
            ready = (value & 0x100) << 2 | (value & 0x1_0000) << 1
            return value | ready | (self.tree.pll()[1] > 0) << 25
        if address == RCC + 8:  # the clock that is chosen is in use
            return value & ~0xC | (value & 3) << 2
        if address in (RCC + 0x90, RCC + 0x94, RCC + 0x98):
            return value | (value & 1) << 1
        if DMA1 + 8 <= address < DMA1 + 8 + 160 and (address - DMA1 - 8) % 20 == 4:
            return self.dma[(address - DMA1 - 8) // 20].left()
        for port, base in GPIO.items():
            if address == base + 0x10:
                return self._levels(port)
        return value

    def write(self, address, size, value):
        """A store of the image."""
        word, shift = address & ~3, 8 * (address & 3)
        mask = (1 << 8 * size) - 1 << shift
        if self.changes is not None:
            value = self.changes.write(word, mask, value << shift) >> shift
        value = self.stored(word) & ~mask | value << shift & mask
        if self.judge.write(word, value, mask):
            old = self.stored(word)
            self._store(word, value)
            if word not in RUNNING:
                self.settled.clear()
            for bit, addresses in self.judge.resets.get(word, {}).items():
                if value & ~old & 1 << bit:
                    self._put_back(addresses)
            if word in WATCHED:
                self.tree.written(word, old)
        self.core.interrupt_check()

    def _put_back(self, addresses):
        """A reset of the RCC: registers and parts as after the chip's own."""
        for address in addresses:
            self.register.pop(address, None)
        self.settled.clear()
        for part in self.parts:
            part.put_back(addresses)
        for dma in self.dma:
            if dma.base in addresses:
                dma.done = 0

    def _store(self, address, value):
        if self.mpu.write(address, value) or any(p.write(address, value) for p in self.parts):
            return
        block, bit = address & ~0x1F, 32 * (address >> 2 & 7)
        numbers = {bit + k for k in range(32) if value >> k & 1}
        if block == NVIC_ENABLE:
            self.enabled |= numbers
        elif block == NVIC_DISABLE:
            self.enabled -= numbers
        elif block == NVIC_PEND:
            self.pended |= numbers
        elif block == NVIC_UNPEND:
            self.pended -= numbers
        elif address == RCC + 0x20:  # writing 1 takes a flag back
            self.register[RCC + 0x1C] = self.stored(RCC + 0x1C) & ~value
        elif address == AIRCR:
            if value & 4:
                self.reset("software")
        elif address == IWDG:
            self._watchdog(value)
        elif address in (IWDG + 4, IWDG + 8) and not self.watchdog_open:
            self.judge.find("is locked", "IWDG")
        elif address == RCC + 0x94:
            flags = 0 if value >> 23 & 1 else self.stored(address) & 0xFE00_0000
            self.register[address] = value & 1 | flags
        elif self._is_port(address, value):
            pass
        else:
            if DMA1 + 8 <= address < DMA1 + 168 and (address - DMA1 - 8) % 20 == 0:
                if value & 1 and not self.stored(address) & 1:
                    channel = self.dma[(address - DMA1 - 8) // 20]
                    channel.done, channel.started = 0, self.now
            register = self.judge.registers.get(address)
            old = self.stored(address)
            self.register[address] = register.takes(old, value) if register else value

    def _is_port(self, address, value):
        for port, base in GPIO.items():
            if address in (base + 0x18, base + 0x28):
                self.before[port] = (self._driven(port), self.now)
                old = self.stored(base + 0x14)
                if address == base + 0x28:
                    new = old & ~value
                else:
                    new = old & ~(value >> 16) | value & 0xFFFF
                self.register[base + 0x14] = new
                for pin in range(16):
                    if (old ^ new) >> pin & 1:
                        self.note("pin", f"P{port}{pin}", new >> pin & 1)
                return True
        return False

    def _driven(self, port):
        """Levels of a port's outputs as its input register has them by now."""
        before, since = self.before.get(port, (0, -PIN_TICKS))
        return before if self.now < since + PIN_TICKS else self.stored(GPIO[port] + 0x14)

    def _levels(self, port):
        base, value = GPIO[port], 0
        modes, outputs = self.stored(base), self._driven(port)
        for pin in range(16):
            is_output = modes >> 2 * pin & 3 == 1
            level = outputs >> pin & 1 if is_output else self.levels.get(f"P{port}{pin}", 0)
            value |= level << pin
        return value

    # --- watchdog and reset

    def _watchdog(self, key):
        self.watchdog_open = key == 0x5555
        if key == 0xCCCC:
            divider = 4 << (self.stored(IWDG + 4) & 7)
            count = (self.stored(IWDG + 8) & 0xFFF or 0xFFF) + 1
            self.watchdog_ticks = count * divider * TICK_HZ // LSI_HZ
        if key in (0xAAAA, 0xCCCC):
            if self.fed is not None:
                self.longest_unfed = max(self.longest_unfed, self.now - self.fed)
            self.fed = self.now

    def reset(self, cause):
        """The chip is reset: this stretch of the run ends."""
        self.reset_by = cause
        self.note("reset", cause, 1)
        self.core.uc.emu_stop()

    def note(self, kind, name, value):
        """Something that is seen from outside."""
        self.trace.append({"s": self.now / TICK_HZ, "kind": kind, "name": name, "value": value})

    def clock_fails(self):
        """The crystal stops: with the clock security system the core goes on from the inner
        oscillator and is told (RM0440); without it the core stands still."""
        if not self.stored(RCC) >> 19 & 1:
            self.halted = self.hung = True
            return
        self.register[RCC + 0x1C] = self.stored(RCC + 0x1C) | 1 << 8
        self.power.system_break()
        self.exception = NMI

    # --- time

    def passing(self, ticks):
        """The image is busy for so long."""
        self.advance(self.now + ticks)
        self.core.interrupt_check()

    def next_event(self):
        """The next moment at which anything happens by itself."""
        moments = [part.next_event() for part in self.parts]
        if self.script:
            moments.append(self.script[0][0])
        if self.watchdog_ticks is not None:
            moments.append(self.fed + self.watchdog_ticks)
        return max(min(moments), self.now)

    def advance(self, moment):
        """Lets everything happen up to a moment, in its order."""
        while (event := self.next_event()) <= moment:
            self.now = event
            while self.script and self.script[0][0] <= event:
                self._step(*self.script.pop(0))
            for part in self.parts:
                part.happen()
            if self.watchdog_ticks is not None and event >= self.fed + self.watchdog_ticks:
                self.reset("watchdog")
                return
            if event == moment:
                break
        self.now = max(self.now, moment)
        for part in self.parts:
            part.happen()

    def _step(self, _moment, name, value):
        """One line of the script: a pin's level, its voltage, a pulse, bytes of the host."""
        self.note("script", name, value)
        if name == "host":
            self.serial.host_says(bytes.fromhex(value))
        elif name == "tacho":
            self.clock.capture()
        elif name == "exception":
            self.exception = value
        elif name == "reset":
            self.reset(value)
        elif name == "hang":
            self.hung = True
        elif name == "halt":
            self.halted = self.hung = True
            self.power.debugger_halts()
        elif name == "crystal-fails":
            self.clock_fails()
        elif name == "options":
            self.options = self.register[FLASH + 0x20] = value
        elif name == "spoilt":
            self.flash.spoil(value)
        elif name == "flash-holds":
            address, data = value
            self.core.uc.mem_write(address, bytes.fromhex(data))
        elif name == "flash-fails":
            self.flash.fail(value)
        elif name == "supply-low":
            self.supply.set(bool(value))
        elif name == "stopped":
            self.analog.forced.add(name)
        elif value is None:
            self.analog.let_go(name)
        elif isinstance(value, float):
            self.analog.volts[name] = value
            self.analog.forced.add(name)
        else:
            self.levels[name] = value
        self.power.look()

    # --- interrupts

    def pending_interrupt(self):
        """The lowest number that is enabled and wants to be served."""
        for part in self.parts:
            # Pending stays, even if the cause goes away before it is served.
            self.pended |= part.interrupts() & self.enabled
        return min(self.pended & self.enabled, default=None)

    def take(self, number):
        """The core enters the handler."""
        self.pended.discard(number)
