"""TIM2, the clock and the tacho's capture; TIM1, the bridges and their break inputs."""

from analog import COMPARATORS
from memo import until_written

TIM1, TIM2 = 0x4001_2C00, 0x4000_0000
CR1, CR2, DIER, SR, EGR, CNT, ARR, RCR, CCR1, BDTR, AF1, AF2 = (
    0x00, 0x04, 0x0C, 0x10, 0x14, 0x24, 0x2C, 0x30, 0x34, 0x44, 0x60, 0x64,
)  # fmt: skip
CCMR1, CCER, PSC = 0x18, 0x20, 0x28
# The pins of the upper and the lower switch of every coil.
GATES = tuple(
    tuple(zip(pins, (f"TIM1_CH{k + 1}", f"TIM1_CH{k + 1}N")))
    for k, pins in enumerate((("PC0", "PA11"), ("PC1", "PA12"), ("PC2", "PB9"), ("PC3", "PC5")))
)
NEVER = 1 << 62
READ_TICKS = 12
MOE = 1 << 15
DEBUG_APB2 = 0xE004_2010
# Timer clocks that a break has to last, by the filter's number (RM0440, TIM1_BDTR, BKF; the
# filter's clock is the timer's).
FILTER_TICKS = (0, 2, 4, 8, 12, 16, 24, 32, 48, 64, 80, 96, 128, 160, 192, 256)


class Clock:
    """TIM2 counts ticks, overflows, matches one compare register, captures the tacho."""

    def __init__(self, bus):
        self.bus = bus
        self.started = None
        self.flags = 0

    def count(self):
        """Ticks since it was started, all of them."""
        return 0 if self.started is None else self.bus.now - self.started

    def read(self, address):
        if address == TIM2 + CNT:
            self.bus.passing(READ_TICKS)
            return self.count() & 0xFFFF_FFFF
        if address == TIM2 + SR:
            return self.flags
        return None

    def write(self, address, value):
        if address == TIM2 + SR:
            self.flags &= value
            return True
        if address == TIM2 + EGR:
            self.flags |= value & 1
            return True
        if address == TIM2 + CR1 and value & 1 and self.started is None:
            self.started = self.bus.now
            self.bus.tree.started("TIM2", 1)
            if self.bus.stored(TIM2 + ARR) != 0xFFFF_FFFF or self.bus.stored(TIM2 + PSC):
                self.bus.judge.find("clock", "TIM2", "is started short of 32 bits of ticks")
        return False

    def _match(self):
        """The next moment at which the counter equals the compare register."""
        wanted = self.bus.stored(TIM2 + CCR1)
        return self.bus.now + ((wanted - self.count() - 1 & 0xFFFF_FFFF) + 1)

    def put_back(self, addresses):
        """A reset of the RCC."""
        if TIM2 in addresses:
            self.started, self.flags = None, 0

    def next_event(self):
        if self.started is None:
            return NEVER
        overflow = self.bus.now + (1 << 32) - (self.count() & 0xFFFF_FFFF)
        waiting = self.bus.stored(TIM2 + DIER) & 2 and not self.flags & 2
        return min(overflow, self._match()) if waiting else overflow

    def happen(self):
        if self.started is None:
            return
        count = self.count() & 0xFFFF_FFFF
        if count == 0 and self.count():
            self.flags |= 1
        if count == self.bus.stored(TIM2 + CCR1):
            self.flags |= 2

    def capture(self):
        """An edge at the tacho's pin."""
        bus = self.bus
        on = bus.stored(TIM2 + CCER) >> 8 & 1
        chosen = bus.stored(TIM2 + CCMR1 + 4) & 3 == 1 and bus.pins.leads_to("PB10", "TIM2_CH3")
        dma = bus.channel(bus.request("TIM2", "CH3"))
        if on and chosen and dma and bus.stored(TIM2 + DIER) >> 11 & 1:
            captured = (self.count() & 0xFFFF_FFFF).to_bytes(4, "little")
            dma.to_memory(captured, 4, TIM2 + CCR1 + 8)

    def interrupts(self):
        wanted = self.flags & self.bus.stored(TIM2 + DIER) & 3
        return {self.bus.data["interrupts"]["TIM2"]} if wanted else set()


class BreakTimer:
    """TIM1: centre-aligned PWM for the coils; break from the pin and the comparators."""

    def __init__(self, bus):
        self.bus = bus
        self.flags = 0
        self.on = False
        self.next = NEVER
        self.every = 1
        # Since when each break input has been active without a break.
        self.since = [None, None]

    @until_written
    def period(self):
        """Ticks of one PWM period: up and down again, or up only."""
        top, divider = self.bus.stored(TIM1 + ARR) & 0xFFFF, self.bus.stored(TIM1 + PSC) + 1
        return divider * (2 * top if self.centred() else top + 1)

    def centred(self):
        """Counts up and down."""
        return bool(self.bus.stored(TIM1 + CR1) >> 5 & 3)

    @until_written
    def step(self):
        """Ticks between two updates: one at each end of the count, and of these one in so many."""
        repeats = (self.bus.stored(TIM1 + RCR) & 0xFFFF) + 1
        return max(self.period() * repeats // (2 if self.centred() else 1), 1)

    @until_written
    def triggers(self):
        """Whether an update starts the converters."""
        return self.bus.stored(TIM1 + CR2) >> 20 & 15 == 2

    def active(self):
        """Break inputs that are active now: bit 0 the first, bit 1 the second."""
        bus = self.bus
        bdtr = bus.stored(TIM1 + BDTR)
        found = 0
        for k, (offset, enable, polarity) in enumerate(((AF1, 12, 13), (AF2, 24, 25))):
            if not bdtr >> enable & 1:
                continue
            sources, high = bus.stored(TIM1 + offset), bdtr >> polarity & 1
            if k == 0 and sources & 1:
                inverted = sources >> 9 & 1
                level = self.stop_reaches() and bus.levels.get("PA6", 0)
                found |= (level ^ inverted) == high
            for number in COMPARATORS:
                if sources >> number & 1:
                    found |= (bus.analog.comparator(number) == high) << k
        return found

    @until_written
    def stop_reaches(self):
        """Whether the emergency stop's pin leads to the timer."""
        return self.bus.pins.leads_to("PA6", "TIM1_BKIN")

    def can_switch(self):
        """Master enable set, and at least one switch's output enabled."""
        enabled = self.bus.stored(TIM1 + CCER) & 0x5555
        return bool(self.bus.stored(TIM1 + BDTR) & MOE and enabled)

    def filtered(self):
        """Break inputs that have been active for as long as their filter asks."""
        found, bdtr = 0, self.bus.stored(TIM1 + BDTR)
        active = self.active()
        for k, shift in enumerate((16, 20)):
            if not active >> k & 1:
                self.since[k] = None
                continue
            if self.since[k] is None:
                self.since[k] = self.bus.now
            lasts = self.bus.now - self.since[k]
            found |= (lasts >= FILTER_TICKS[bdtr >> shift & 15]) << k
        return found

    def debugger_halts(self):
        """A debugger stops the core: a timer that stops with it opens its switches."""
        if self.bus.stored(DEBUG_APB2) >> 11 & 1:
            self.bus.register[TIM1 + BDTR] = self.bus.stored(TIM1 + BDTR) & ~MOE
            self._switch(False, "debugger")

    def look(self):
        """Inputs have changed: the outputs may go off."""
        active = self.filtered()
        self.flags |= (active & 1) << 7 | (active >> 1 & 1) << 8
        if active:
            self.bus.register[TIM1 + BDTR] = self.bus.stored(TIM1 + BDTR) & ~MOE
            self._switch(False, "break")

    def system_break(self):
        """An error of the chip itself breaks the timer, if breaks are enabled."""
        if self.bus.stored(TIM1 + BDTR) >> 12 & 1:
            self.flags |= 1 << 13
            self.bus.register[TIM1 + BDTR] = self.bus.stored(TIM1 + BDTR) & ~MOE
            self._switch(False, "break")

    def reset(self):
        """The chip's reset opens every switch."""
        self._switch(False, "reset")

    def _switch(self, on, why):
        if on != self.on:
            self.bus.note("outputs", why, int(on))
        self.on = on

    def read(self, address):
        if address == TIM1 + SR:
            return self.flags
        if address == TIM1 + BDTR:
            return self.bus.stored(address)
        return None

    def write(self, address, value):
        bus = self.bus
        if address == TIM1 + SR:
            self.flags &= value
            return True
        if address == TIM1 + BDTR:
            bus.register[address] = value
            self.look()
            self._switch(self.can_switch(), "software")
            return True
        if address == TIM1 + CCER:
            bus.register[address] = value
            self._switch(self.can_switch(), "software")
            return True
        if address == TIM1 + CR1 and value & 1 and self.next == NEVER:
            self.next = bus.now
            bus.tree.started("TIM1", 2)
        return False

    def duty(self, channel):
        """Part of a period for which an upper switch is closed; 0..3."""
        switches = self.switches(channel)
        if switches is None:
            return 0.0
        share = self.bus.stored(TIM1 + CCR1 + 4 * channel) / max(self.bus.stored(TIM1 + ARR), 1)
        return 1 - share if switches == "inverted" else share

    @until_written
    def switches(self, channel):
        """How a channel drives its two pins, or none."""
        bus = self.bus
        mode = bus.stored(TIM1 + CCMR1 + 4 * (channel // 2)) >> 8 * (channel % 2)
        polarity = bus.stored(TIM1 + CCER) >> 4 * channel
        reaches = all(bus.pins.leads_to(*gate) for gate in GATES[channel])
        if not (
            polarity & 5 == 5 and reaches and mode & 3 == 0 and mode & 0x1_0070 in (0x60, 0x70)
        ):
            return None
        return "inverted" if (mode & 0x70 == 0x70) ^ polarity >> 1 & 1 else "straight"

    def put_back(self, addresses):
        """A reset of the RCC."""
        if TIM1 in addresses:
            self.flags, self.next = 0, NEVER
            self._switch(False, "reset")

    def next_event(self):
        bdtr = self.bus.stored(TIM1 + BDTR)
        breaks = (
            since + FILTER_TICKS[bdtr >> shift & 15]
            for since, shift in zip(self.since, (16, 20))
            if since is not None
        )
        waiting = (moment for moment in breaks if moment > self.bus.now)
        return min(self.next, *waiting, NEVER)

    def happen(self):
        bus = self.bus
        if any(since is not None for since in self.since):
            self.look()
        if bus.now < self.next:
            return
        self.next = bus.now + self.every * self.step()
        bus.analog.pwm_period(self)
        self.look()

    def interrupts(self):
        return set()
