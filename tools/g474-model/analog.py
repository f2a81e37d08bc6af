"""Converters, comparators, the microphones' DMA, and the coils behind the sensors."""

ADC = {1: 0x5000_0000, 2: 0x5000_0100, 3: 0x5000_0400, 4: 0x5000_0500, 5: 0x5000_0600}
ISR, IER, CR, CFGR, CFGR2, SQR1, DR, JSQR, JDR1 = 0, 4, 8, 0xC, 0x10, 0x30, 0x40, 0x4C, 0x80
TIM6 = 0x4000_1000
DAC = {1: 0x5000_0800, 2: 0x5000_0C00, 3: 0x5000_1000, 4: 0x5000_1400}
COMP = 0x4001_0200
OPAMP4 = 0x4001_030C
# Comparator: its plus pin, its minus DAC (number, channel) at INMSEL 4.
COMPARATORS = {1: ("PB1", 3, 1), 4: ("PB0", 3, 2), 5: ("PB13", 4, 1), 7: ("PB14", 4, 1)}
PINS = {
    (1, 1): "PA0", (2, 2): "PA1", (3, 1): "PB1", (3, 12): "PB0", (3, 5): "PB13",
    (4, 4): "PB14", (4, 3): "PB12", (4, 5): "PB15", (5, 1): "PA8", (5, 2): "PA9", (5, 5): "PB11",
}  # fmt: skip
REQUEST_ADC = {1: 5, 2: 36}
INTERRUPT_ADC = {3: 47, 4: 61, 5: 62}
EXTSEL_TIM6_TRGO, JEXTSEL_TIM1_TRGO2 = 13, 8
REFERENCE_V = 3.3
NEVER = 1 << 62

# The coils as the settings have them: sensors of 8 A from end to end around half the
# reference, 4.19 mH, 4 ohm, 48 V to both sides.
SENSE_PINS = ("PB1", "PB0", "PB13", "PB14")
SENSE_V_PER_A, INDUCTANCE_H, RESISTANCE_OHM, SUPPLY_V = 3.3 / 8, 4.19e-3, 4.0, 48.0
GAP_PINS = ("PB12", "PB15")


class Analog:
    """Everything that has a voltage."""

    def __init__(self, bus):
        self.bus = bus
        self.volts = {"PB12": 1.24, "PB15": 1.24, "PA8": 0.5, "PA9": 1.65, "PB11": 1.98}
        self.sounds = {}
        self.current_a = [0.0] * 4
        self.forced = set()
        self.turn = 1
        self.restart()

    def restart(self):
        """Converters as a reset leaves them; what they measure goes on."""
        self.sampling_since = None
        self.taken = 0
        self.flags = dict.fromkeys(ADC, 0)
        self.results = {}

    # --- microphones

    def period(self):
        """Ticks between two samples, or none while nothing is sampled."""
        bus = self.bus
        cfgr, cfgr2, trigger = (
            bus.stored(ADC[1] + CFGR),
            bus.stored(ADC[1] + CFGR2),
            bus.stored(TIM6) & 1 and bus.stored(TIM6 + 4) >> 4 & 7 == 2,
        )
        chosen = cfgr >> 5 & 31 == EXTSEL_TIM6_TRGO and cfgr >> 10 & 3 == 1
        if not (trigger and chosen and bus.stored(ADC[1] + CR) & 4):
            return None
        conversions = (bus.stored(TIM6 + 0x2C) + 1) * (bus.stored(TIM6 + 0x28) + 1)
        together = 1 << (cfgr2 >> 2 & 7) + 1 if cfgr2 & 1 and cfgr2 >> 9 & 1 else 1
        return conversions * together

    def _sample(self):
        """Conversions whose time has come go where the DMA carries them."""
        period = self.period()
        if period is None:
            return
        if self.sampling_since is None:
            self.sampling_since = self.bus.now
            self.bus.note("sampling", "ticks per sample", period)
        due = (self.bus.now - self.sampling_since) // period
        count, first = due - self.taken, self.taken
        if count <= 0:
            return
        self.taken = due
        for adc, request in REQUEST_ADC.items():
            dma = self.bus.channel(request)
            pin = PINS.get((adc, self.bus.stored(ADC[adc] + SQR1) >> 6 & 31))
            if dma is None or "stopped" in self.forced:
                continue
            dma.to_memory(self._codes(pin, first, count), 2)

    def _codes(self, pin, first, count):
        silence = (16380).to_bytes(2, "little")
        sound = self.sounds.get(pin)
        if sound is None:
            return silence * count
        data = sound[2 * first : 2 * (first + count)]
        return data + silence * (count - len(data) // 2)

    # --- the rest

    def code(self, pin):
        """Twelve bits of a pin's voltage."""
        volts = self.volts.get(pin, 0.0)
        return min(4095, max(0, round(volts / REFERENCE_V * 4095)))

    def dac(self, number, channel):
        """Code of a DAC's output."""
        enabled = self.bus.stored(DAC[number]) >> 16 * (channel - 1) & 1
        return self.bus.stored(DAC[number] + (0x08, 0x14)[channel - 1]) & 0xFFF if enabled else 0

    def comparator(self, number):
        """A comparator's output, 0 or 1."""
        pin, dac, channel = COMPARATORS[number]
        control = self.bus.stored(COMP + 4 * (number - 1))
        if not control & 1 or control >> 4 & 7 != 4:
            return 0
        plus = int(self.code(pin) > self.dac(dac, channel))
        return plus ^ control >> 15 & 1

    def pwm_period(self, power):
        """One period of the bridges: currents move, injected conversions are made."""
        dt = power.period() / 163.2e6
        for k, pin in enumerate(SENSE_PINS):
            drive = 2 * power.duty(k) - 1 if power.on else -1.0
            i = self.current_a[k]
            i += (SUPPLY_V * drive - RESISTANCE_OHM * i) / INDUCTANCE_H * dt
            self.current_a[k] = max(i, 0.0)
            self._measured(pin, 1.65 + SENSE_V_PER_A * self.current_a[k])
        for pin in GAP_PINS:
            self._measured(pin, 1.24)
        for adc in INTERRUPT_ADC:
            self._injected(adc)

    def let_go(self, pin):
        """The script holds a current sensor no more."""
        self.forced.discard(pin)
        self.volts[pin] = 1.65 + SENSE_V_PER_A * self.current_a[SENSE_PINS.index(pin)]

    def _measured(self, pin, volts):
        """A sensor's voltage, unless the script holds it, with a little noise: sensors that
        stand still are taken for dead."""
        self.turn = (self.turn * 1103515245 + 12345) & 0x7FFF_FFFF
        if pin not in self.forced:
            self.volts[pin] = volts + 0.006 * (self.turn / 0x7FFF_FFFF - 0.5)

    def _injected(self, adc):
        base = ADC[adc]
        sequence = self.bus.stored(base + JSQR)
        trigger = sequence >> 2 & 31 == JEXTSEL_TIM1_TRGO2 and sequence >> 7 & 3
        if not (trigger and self.bus.stored(base + CR) & 8):
            return
        for rank in range((sequence & 3) + 1):
            channel = sequence >> (9, 15, 21, 27)[rank] & 31
            self.results[base + JDR1 + 4 * rank] = self.code(PINS.get((adc, channel)))
        self.flags[adc] |= 0x60

    def read(self, address):
        if address in self.results:
            return self.results[address]
        for adc, base in ADC.items():
            if address == base + ISR:
                return self.flags[adc] | 1
            if address == base + CR:
                return self.bus.stored(address) & ~(1 << 31)
        if COMP <= address < COMP + 28 and (address - COMP) // 4 + 1 in COMPARATORS:
            level = self.comparator((address - COMP) // 4 + 1)
            return self.bus.stored(address) & ~(1 << 30) | level << 30
        return None

    def write(self, address, value):
        for adc, base in ADC.items():
            if address == base + ISR:
                self.flags[adc] &= ~value
                return True
            if address == base + CR:
                # Bits of the control register are set by writing 1, reset by the chip.
                kept = self.bus.stored(address) & 0xC
                self.bus.register[address] = value & ~0x30 | (0 if value & 0x30 else kept)
                return True
        for number, base in DAC.items():
            if address == base + 0x08 and value != self.bus.stored(address):
                self.bus.note("dac", f"DAC{number} channel 1", value & 0xFFF)
        return False

    def next_event(self):
        return NEVER

    def happen(self):
        self._sample()

    def interrupts(self):
        return {
            number
            for adc, number in INTERRUPT_ADC.items()
            if self.flags[adc] & self.bus.stored(ADC[adc] + IER) & 0x60
        }
