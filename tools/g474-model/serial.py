"""USART2 with its two DMA channels: what the host hears and says."""

from unicorn import UcError

from memo import until_written

USART2 = 0x4000_4400
CR1, CR2, CR3, BRR, ISR, ICR, RDR, TDR = 0x00, 0x04, 0x08, 0x0C, 0x1C, 0x20, 0x24, 0x28
BAUD = 921_600
TRANSMIT_EMPTY, TRANSMIT_COMPLETE, ACKNOWLEDGED = 1 << 7, 1 << 6, 3 << 21
NEVER = 1 << 62


class Serial:
    """Ten bits a byte, as fast as the divider says."""

    def __init__(self, bus):
        self.bus = bus
        self.said = bytearray()

    @until_written
    def byte_ticks(self):
        """Ticks of one byte of ten bits."""
        hz = self.bus.tree.serial()
        return (
            round(10 * self.bus.TICK_HZ * max(self.bus.stored(USART2 + BRR), 1) / hz)
            if hz
            else NEVER
        )

    @until_written
    def understood(self, pin, signal):
        """Whether bytes pass a pin: the pin leads there, eight bits, no parity, one stop bit, and
        a rate that is not more than 2 % off the host's."""
        bus = self.bus
        frame = bus.stored(USART2 + CR1) & 0x1000_9400 | bus.stored(USART2 + CR2) & 0xF_F000
        at_rate = abs(10 * bus.TICK_HZ / self.byte_ticks() / BAUD - 1) < 0.02
        return bus.pins.leads_to(pin, signal) and frame == 0 and at_rate

    def host_says(self, data):
        """Bytes arrive at the receiver."""
        dma = self.bus.channel(self.bus.request("USART2", "RX"))
        on = self.bus.stored(USART2 + CR1) & 5 == 5 and self.bus.stored(USART2 + CR3) >> 6 & 1
        if dma and on and self.understood("PA3", "USART2_RX"):
            dma.to_memory(data, 1, USART2 + RDR)

    def _send(self):
        """Bytes whose time has come leave the memory."""
        dma = self.bus.channel(self.bus.request("USART2", "TX"))
        on = self.bus.stored(USART2 + CR1) & 9 == 9 and self.bus.stored(USART2 + CR3) >> 7 & 1
        if not (dma and on and dma.carries(1, USART2 + TDR, to_memory=False)):
            return
        passes = self.understood("PA2", "USART2_TX")
        due = (self.bus.now - dma.started) // self.byte_ticks()
        memory = self.bus.stored(dma.base + 12)
        while dma.done < min(due, dma.length()):
            try:
                byte = self.bus.core.uc.mem_read(memory + dma.done, 1)
            except UcError:
                dma.fail()
                return
            self.said += byte if passes else b""
            dma.done += 1

    def read(self, address):
        if address == USART2 + ISR:
            return TRANSMIT_EMPTY | TRANSMIT_COMPLETE | ACKNOWLEDGED
        return None

    def write(self, address, value):
        if address == USART2 + TDR:
            self.said.append(value & 0xFF)
            return True
        return address == USART2 + ICR

    def put_back(self, addresses):
        pass

    def next_event(self):
        return NEVER

    def happen(self):
        self._send()

    def interrupts(self):
        return set()
