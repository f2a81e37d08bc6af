"""Converters, comparators, the microphones' DMA, and the coils behind the sensors."""

import math

from memo import until_written

ADC = {1: 0x5000_0000, 2: 0x5000_0100, 3: 0x5000_0400, 4: 0x5000_0500, 5: 0x5000_0600}
ISR, IER, CR, CFGR, CFGR2, SMPR1, SQR1, DR, JSQR, JDR1 = (
    0x00, 0x04, 0x08, 0x0C, 0x10, 0x14, 0x30, 0x40, 0x4C, 0x80,
)  # fmt: skip
# Bits of a converter's CR.
ENABLED, STARTED, INJECTED, REGULATOR, ASLEEP, CALIBRATE = (
    1,
    1 << 2,
    1 << 3,
    1 << 28,
    1 << 29,
    1 << 31,
)
# Cycles of sampling by SMP, and those of twelve bits (RM0440, 21.4.16).
SAMPLING_CYCLES, CONVERSION_CYCLES = (2.5, 6.5, 12.5, 24.5, 47.5, 92.5, 247.5, 640.5), 12.5
# What a converter that was not calibrated is off by, codes: there to be seen, not a figure
# of the data sheet.
UNCALIBRATED = 20
TIM6 = 0x4000_1000
DAC = {1: 0x5000_0800, 2: 0x5000_0C00, 3: 0x5000_1000, 4: 0x5000_1400}
DAC_MCR = 0x3C
COMP, OPAMP4 = 0x4001_0200, 0x4001_030C
# A comparator's minus input by INMSEL, as DAC and channel (RM0440, 24.3.2): ours.
MINUS = {
    1: {4: (3, 1), 5: (1, 1)}, 4: {4: (3, 2), 5: (1, 1)},
    5: {4: (4, 1), 5: (1, 2)}, 7: {4: (4, 1), 5: (2, 1)},
}  # fmt: skip
COMPARATORS = tuple(MINUS)
# The channel of ADC5 that OPAMP4's output is inside the chip (RM0440, 21.4.11): ours.
OPAMP4_CHANNEL = (5, 5)
MICROPHONES, COILS = (1, 2), (3, 4, 5)
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
        self.since, self.count = {}, dict.fromkeys(MICROPHONES, 0)
        self.calibrated = set()
        self.flags = dict.fromkeys(ADC, 0)
        self.results = {}

    @property
    def taken(self):
        """Samples of the first microphone."""
        return self.count[1]

    # --- converters

    def bits(self, adc, offset, at, width):
        """A field of a converter."""
        return self.bus.stored(ADC[adc] + offset) >> at & (1 << width) - 1

    @until_written
    def runs(self, adc):
        """Whether it is on, awake and clocked."""
        control = self.bus.stored(ADC[adc] + CR)
        awake = control & (ENABLED | REGULATOR | ASLEEP) == ENABLED | REGULATOR
        return awake and self.bus.tree.converter(adc) > 0

    def sampling_s(self, adc, channel):
        """How long a channel's source charges the converter, s."""
        code = self.bits(adc, SMPR1 + 4 * (channel // 10), 3 * (channel % 10), 3)
        return SAMPLING_CYCLES[code] / self.bus.tree.converter(adc)

    def conversion_s(self, adc, channel):
        """From the trigger to the code of one channel, s."""
        return self.sampling_s(adc, channel) + CONVERSION_CYCLES / self.bus.tree.converter(adc)

    @until_written
    def source(self, adc, channel):
        """The pin a channel has now, or none: through the pin's mode, or an amplifier."""
        if (adc, channel) == OPAMP4_CHANNEL:
            control = self.bus.stored(OPAMP4)
            follows = control & 1 and control >> 5 & 3 == 3 and control >> 8 & 1
            pins = self.bus.pins.analog.get(f"OPAMP4_VINP{control >> 2 & 3}", [])
            return next((p for p in pins if follows and self.bus.pins.is_analog(p)), None)
        return self.bus.pins.channel(adc, channel)

    def chosen(self, adc, kind, number):
        """The name of a trigger by its number."""
        return self.bus.data["peripherals"][f"ADC{adc}"]["triggers"].get(f"ADC_{kind}_TRG{number}")

    # --- microphones

    def triggers(self):
        """Ticks between two triggers of TIM6, or none."""
        bus = self.bus
        if not (bus.stored(TIM6) & 1 and bus.stored(TIM6 + 4) >> 4 & 7 == 2):
            return None
        return (bus.stored(TIM6 + 0x2C) + 1) * (bus.stored(TIM6 + 0x28) + 1)

    @until_written
    def period(self, adc=1):
        """Ticks between two samples, or none while nothing is sampled."""
        ticks = self.triggers()
        wanted = self.chosen(adc, "EXT", self.bits(adc, CFGR, 5, 5)) == "TIM6_TRGO"
        if not (ticks and wanted and self.bits(adc, CFGR, 10, 2) == 1 and self.runs(adc)):
            return None
        if not self.bus.stored(ADC[adc] + CR) & STARTED:
            return None
        # A trigger that comes while a conversion goes on is lost.
        takes = self.conversion_s(adc, self.bits(adc, SQR1, 6, 5)) * self.bus.TICK_HZ
        return ticks * max(1, math.ceil(takes / ticks)) * self.summed(adc)

    @until_written
    def summed(self, adc):
        """Conversions in one sample, each by a trigger of its own."""
        if self.bits(adc, CFGR2, 0, 1) and self.bits(adc, CFGR2, 9, 1):
            return 2 << self.bits(adc, CFGR2, 2, 3)
        return 1

    def _sample(self, adc):
        """Conversions whose time has come go where the DMA carries them."""
        period = self.period(adc)
        if period is None:
            return
        if adc not in self.since:
            self.since[adc] = self.bus.now
            if adc == 1:
                self.bus.note("sampling", "ticks per sample", period)
        due = (self.bus.now - self.since[adc]) // period
        first = self.count[adc]
        if due <= first:
            return
        self.count[adc] = due
        dma = self._carrier(adc)
        if dma is None or "stopped" in self.forced:
            return
        pin = self.source(adc, self.bits(adc, SQR1, 6, 5))
        dma.to_memory(self._codes(adc, pin, first, due - first), 2, ADC[adc] + DR)

    def _carrier(self, adc):
        """The DMA channel of a converter."""
        if not self.bits(adc, CFGR, 0, 2) & 1:
            return None
        return self.bus.channel(self.bus.request(f"ADC{adc}", f"ADC{adc}"))

    def _codes(self, adc, pin, first, count):
        """Codes of a run of samples: the sound of the pin, in sums of eight."""
        data = self.sounds.get(pin, b"")[2 * first : 2 * (first + count)]
        data += (16380).to_bytes(2, "little") * (count - len(data) // 2)
        summed, shift = self.summed(adc), self.bits(adc, CFGR2, 5, 4)
        offset = 0 if adc in self.calibrated else UNCALIBRATED * 8
        if pin is not None and (summed, shift, offset) == (8, 0, 0):
            return data
        codes = (int.from_bytes(data[k : k + 2], "little") for k in range(0, len(data), 2))
        codes = ((code + offset if pin else 0) * summed // 8 >> shift for code in codes)
        return b"".join((code & 0xFFFF).to_bytes(2, "little") for code in codes)

    # --- the rest

    def code(self, pin):
        """Twelve bits of a pin's voltage."""
        volts = self.volts.get(pin, 0.0)
        return min(4095, max(0, round(volts / REFERENCE_V * 4095)))

    def dac(self, number, channel):
        """Code of a DAC's output."""
        enabled = self.bus.stored(DAC[number]) >> 16 * (channel - 1) & 1
        return self.bus.stored(DAC[number] + (0x08, 0x14)[channel - 1]) & 0xFFF if enabled else 0

    def dac_mode(self, number, channel):
        """To its pin (0, 2), inside the chip (3), or both (1)."""
        return self.bus.stored(DAC[number] + DAC_MCR) >> 16 * (channel - 1) & 3

    def valve(self):
        """Code at the valve's pin."""
        reaches = self.bus.pins.is_analog("PA4") and self.dac_mode(1, 1) != 3
        return self.dac(1, 1) if reaches else 0

    @until_written
    def plus(self, number):
        """The pin at a comparator's plus input, or none."""
        chosen = self.bus.stored(COMP + 4 * (number - 1)) >> 8 & 1
        pins = self.bus.pins.analog.get(f"COMP{number}_INP{chosen}", [])
        return next((pin for pin in pins if self.bus.pins.is_analog(pin)), None)

    @until_written
    def minus(self, number):
        """The DAC and channel at a comparator's minus input, or none."""
        chosen = self.bus.stored(COMP + 4 * (number - 1)) >> 4 & 7
        dac = MINUS[number].get(chosen)
        return dac if dac and self.dac_mode(*dac) & 1 else None

    def comparator(self, number):
        """A comparator's output, 0 or 1."""
        control = self.bus.stored(COMP + 4 * (number - 1))
        if not control & 1:
            return 0
        minus = self.minus(number)
        level = self.code(self.plus(number)) > (self.dac(*minus) if minus else 0)
        return int(level) ^ control >> 15 & 1

    def pwm_period(self, power):
        """One period of the bridges: currents move, injected conversions are made."""
        dt = power.step() / self.bus.TICK_HZ
        for k, pin in enumerate(SENSE_PINS):
            drive = 2 * power.duty(k) - 1 if power.on else -1.0
            i = self.current_a[k]
            i += (SUPPLY_V * drive - RESISTANCE_OHM * i) / INDUCTANCE_H * dt
            self.current_a[k] = max(i, 0.0)
            self._measured(pin, 1.65 + SENSE_V_PER_A * self.current_a[k])
        for pin in GAP_PINS:
            self._measured(pin, 1.24)
        if power.triggers():
            for adc in COILS:
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
        sources = self.sequence(adc)
        offset = 0 if adc in self.calibrated else UNCALIBRATED
        for rank, pin in enumerate(sources):
            self.results[ADC[adc] + JDR1 + 4 * rank] = min(4095, self.code(pin) + offset)
        if sources:
            self.flags[adc] |= 0x60

    @until_written
    def sequence(self, adc):
        """What a converter converts at every trigger of the bridges' timer."""
        sequence = self.bus.stored(ADC[adc] + JSQR)
        wanted = self.chosen(adc, "JEXT", sequence >> 2 & 31) == "TIM1_TRGO2"
        started = self.bus.stored(ADC[adc] + CR) & INJECTED
        if not (wanted and sequence >> 7 & 3 and started and self.runs(adc)):
            return ()
        ranks = (9, 15, 21, 27)[: (sequence & 3) + 1]
        return tuple(self.source(adc, sequence >> at & 31) for at in ranks)

    def read(self, address):
        if address in self.results:
            return self.results[address]
        for adc, base in ADC.items():
            if address == base + ISR:
                return self.flags[adc] | self.runs(adc)
            if address == base + CR:
                return self.bus.stored(address) & ~CALIBRATE
        if COMP <= address < COMP + 28 and (address - COMP) // 4 + 1 in MINUS:
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
                kept = self.bus.stored(address) & (ENABLED | STARTED | INJECTED)
                if value & 0x32:  # disabled, or stopped
                    kept, value = 0, value & ~(ENABLED | STARTED | INJECTED)
                self.bus.register[address] = value & ~0x32 | kept
                if value & ENABLED and not kept & ENABLED:
                    self.bus.tree.converter_in(adc)
                awake = value & REGULATOR and not value & ASLEEP
                single_ended = not value >> 30 & 1
                if (
                    value & CALIBRATE
                    and single_ended
                    and awake
                    and not kept
                    and self.bus.tree.converter(adc)
                ):
                    self.calibrated.add(adc)
                return True
        for number, base in DAC.items():
            if address == base + 0x08 and value != self.bus.stored(address):
                self.bus.note("dac", f"DAC{number} channel 1", value & 0xFFF)
        return False

    def put_back(self, addresses):
        """A reset of the RCC: converters forget what they were told."""
        for adc, base in ADC.items():
            if base + CR in addresses:
                self.calibrated.discard(adc)
                self.flags[adc] = 0

    def next_event(self):
        """When a converter's DMA next interrupts; samples themselves are no events."""
        moments = [NEVER]
        for adc in MICROPHONES:
            period, dma = self.period(adc), self._carrier(adc)
            left = dma.to_flag() if period and dma else None
            if left:
                since = self.since.get(adc, self.bus.now)
                moments.append(since + (self.count[adc] + left) * period)
        return min(moments)

    def happen(self):
        for adc in MICROPHONES:
            self._sample(adc)

    def interrupts(self):
        return {
            self.bus.data["interrupts"][f"ADC{adc}"]
            for adc in COILS
            if self.flags[adc] & self.bus.stored(ADC[adc] + IER) & 0x60
        }
