"""The channels of DMA1, each with the request that the multiplexer gives it, and their interrupts."""

from unicorn import UcError

DMA1, DMAMUX1 = 0x4002_0000, 0x4002_0800
ISR, IFCR = DMA1, DMA1 + 4
# Flags of a channel, and what of its control register lets them interrupt.
WHOLE, HALF = 2, 4
NEVER = 1 << 62


class Dma:
    """One channel, as far as it has got."""

    def __init__(self, bus, number):
        self.bus, self.number = bus, number
        self.base = DMA1 + 8 + 20 * number
        self.done = 0
        self.started = 0

    def enabled_for(self, request):
        """Whether it is on and serves this request."""
        bus = self.bus
        return bus.stored(self.base) & 1 and bus.stored(DMAMUX1 + 4 * self.number) & 0x7F == request

    def length(self):
        """Transfers in one round."""
        return self.bus.stored(self.base + 4) & 0xFFFF

    def circular(self):
        """Starts again at its end."""
        return bool(self.bus.stored(self.base) >> 5 & 1)

    def to_flag(self):
        """Transfers until the next flag that interrupts, or none."""
        if not self.bus.stored(self.base) & (WHOLE | HALF) or not self.length():
            return None
        done, length = self.done % self.length(), self.length()
        return (length // 2 if done < length // 2 else length) - done

    def left(self):
        """What CNDTR says."""
        length = self.length()
        return length - self.done % length if self.circular() and length else length - self.done

    def carries(self, width, peripheral, to_memory):
        """Whether it moves elements of a width to or from this register, one after the other."""
        control = self.bus.stored(self.base)
        sizes = control >> 8 & 3, control >> 10 & 3
        wanted = (width.bit_length() - 1,) * 2
        forth = control >> 4 & 1 != to_memory and control >> 6 & 3 == 2
        return forth and sizes == wanted and self.bus.stored(self.base + 8) == peripheral

    def to_memory(self, data, width, peripheral):
        """Transfers elements from a peripheral."""
        if not self.carries(width, peripheral, to_memory=True):
            return
        length, memory = self.length(), self.bus.stored(self.base + 12)
        for at in range(0, len(data), width):
            if not length or not self.circular() and self.done >= length:
                return
            place = memory + self.done % length * width
            try:
                self.bus.core.uc.mem_write(place, data[at : at + width])
            except UcError:
                self.fail()
                return
            self.done += 1
            in_round = self.done % length
            if in_round in (0, length // 2):
                self.bus.dma_flags.set(self.number, HALF if in_round else WHOLE)

    def fail(self):
        """An address where no memory is: a transfer error, which switches the channel off."""
        self.bus.register[self.base] = self.bus.stored(self.base) & ~1
        self.bus.settled.clear()


class Flags:
    """Which channels have carried half of a round, or all of it, and whom that interrupts."""

    def __init__(self, bus):
        self.bus, self.flags = bus, 0

    def set(self, number, flag):
        """A channel has got so far."""
        self.flags |= (flag | 1) << 4 * number

    def read(self, address):
        return self.flags if address == ISR else None

    def write(self, address, value):
        """Writing 1 takes a flag back; of the whole channel all."""
        if address == IFCR:
            whole = sum(0xF << 4 * k for k in range(8) if value >> 4 * k & 1)
            self.flags &= ~(value | whole)
        return address == IFCR

    def put_back(self, addresses):
        if ISR in addresses:
            self.flags = 0

    def next_event(self):
        return NEVER

    def happen(self):
        pass

    def interrupts(self):
        wanted = set()
        for dma in self.bus.dma:
            if self.flags >> 4 * dma.number & self.bus.stored(dma.base) & (WHOLE | HALF):
                wanted.add(self.bus.data["interrupts"][f"DMA1_CHANNEL{dma.number + 1}"])
        return wanted
