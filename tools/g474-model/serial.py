"""USART2 with its two DMA channels: what the host hears and says."""

USART2 = 0x4000_4400
CR1, CR3, BRR, ISR, ICR, RDR, TDR = 0x00, 0x08, 0x0C, 0x1C, 0x20, 0x24, 0x28
REQUEST_RECEIVE, REQUEST_SEND = 26, 27
TRANSMIT_EMPTY, TRANSMIT_COMPLETE, ACKNOWLEDGED = 1 << 7, 1 << 6, 3 << 21
NEVER = 1 << 62


class Serial:
    """Ten bits a byte, as fast as the divider says."""

    def __init__(self, bus):
        self.bus = bus
        self.said = bytearray()

    def byte_ticks(self):
        """Ticks of one byte."""
        return 10 * max(self.bus.stored(USART2 + BRR), 1)

    def host_says(self, data):
        """Bytes arrive at the receiver."""
        dma = self.bus.channel(REQUEST_RECEIVE)
        on = self.bus.stored(USART2 + CR1) & 5 == 5 and self.bus.stored(USART2 + CR3) >> 6 & 1
        if dma and on:
            dma.to_memory(data, 1)

    def _send(self):
        """Bytes whose time has come leave the memory."""
        dma = self.bus.channel(REQUEST_SEND)
        if dma is None or not self.bus.stored(USART2 + CR3) >> 7 & 1:
            return
        due = (self.bus.now - dma.started) // self.byte_ticks()
        memory = self.bus.stored(dma.base + 12)
        while dma.done < min(due, dma.length()):
            self.said += self.bus.core.uc.mem_read(memory + dma.done, 1)
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

    def next_event(self):
        return NEVER

    def happen(self):
        self._send()

    def interrupts(self):
        return set()
