"""The random number generator: words that count up, so that a run can be made again."""

RNG = 0x5006_0800
CR, SR, DR = 0x00, 0x04, 0x08
ON, READY = 1 << 2, 1 << 0
HSI48_ON = 1 << 0
FIRST = 0x5E55_0001
NEVER = 1 << 62


class Random:
    """Ready at once while it and its clock are on; the tests know its words."""

    def __init__(self, bus, clock_register):
        self.bus, self.clock_register = bus, clock_register
        self.word = FIRST

    def _runs(self):
        clock = self.bus.stored(self.clock_register) & HSI48_ON
        return clock and self.bus.stored(RNG + CR) & ON

    def read(self, address):
        if address == RNG + SR:
            return READY if self._runs() else 0
        if address == RNG + DR:
            word = self.word if self._runs() else 0
            self.word += 1
            return word
        return None

    def write(self, address, value):
        return address == RNG + SR

    def put_back(self, addresses):
        pass

    def next_event(self):
        return NEVER

    def happen(self):
        pass

    def interrupts(self):
        return set()
