"""The clock tree as the registers have it, and what the chip allows of it.

Frequencies are derived at every write that can change one, and held against the limits of the
reference manual RM0440 (flash's wait states, 3.3.3; voltage ranges, 6.1.5) and of the data
sheet (PLL, converters); these numbers are ours, no register file has them. The model counts
in ticks of `TICK_HZ`: a clock that is another one when a timer is started is a finding.
"""

RCC, FLASH_ACR, PWR_CR1, PWR_CR5 = 0x4002_1000, 0x4002_2000, 0x4000_7000, 0x4000_7080
CR, CFGR, PLLCFGR, CCIPR = RCC, RCC + 0x08, RCC + 0x0C, RCC + 0x88
ADC_COMMON = {1: 0x5000_0308, 2: 0x5000_0308, 3: 0x5000_0708, 4: 0x5000_0708, 5: 0x5000_0708}
DAC = {1: 0x5000_0800, 2: 0x5000_0C00, 3: 0x5000_1000, 4: 0x5000_1400}
WATCHED = {CR, CFGR, PLLCFGR, CCIPR, FLASH_ACR, PWR_CR1, PWR_CR5, *ADC_COMMON.values()}
# The crystal of the board, and the chip's own oscillators.
CRYSTAL_HZ, HSI_HZ, HSI48_HZ = 24_000_000, 16_000_000, 48_000_000
ADC_DIVIDERS = (1, 2, 4, 6, 8, 10, 12, 16, 32, 64, 128, 256)
# Most Hz of the core with 0, 1, 2… wait states, by the voltage range.
MOST_HZ = {
    "boost": (34e6, 68e6, 102e6, 136e6, 170e6),
    "normal": (30e6, 60e6, 90e6, 120e6, 150e6),
    "low": (12e6, 24e6, 26e6),
}
PLL_INPUT_HZ, PLL_VCO_HZ, PLL_OUTPUT_HZ = (2.66e6, 16e6), (96e6, 344e6), (8e6, 170e6)
# More than one converter of a pair at once; the limit of a single one is 60 MHz.
ADC_HZ = 60e6
# Above it the core's clock must rise in two steps (RM0440, 6.1.5: by half, 1 us, the rest).
STEP_HZ = 80e6


class ClockTree:
    """Frequencies, and what is wrong with them."""

    def __init__(self, bus):
        self.bus = bus
        self.core_hz = HSI_HZ
        self.half = False

    def _bits(self, address, at, width):
        return self.bus.stored(address) >> at & (1 << width) - 1

    def pll(self):
        """Input of the PLL's oscillator, the oscillator, and its output R, Hz; 0: off."""
        source = {2: self.oscillator("HSI"), 3: self.oscillator("HSE")}.get(
            self._bits(PLLCFGR, 0, 2), 0
        )
        given = source / (self._bits(PLLCFGR, 4, 4) + 1)
        vco = given * self._bits(PLLCFGR, 8, 7) if self._bits(CR, 24, 1) else 0
        out = vco / (2 * self._bits(PLLCFGR, 25, 2) + 2) if self._bits(PLLCFGR, 24, 1) else 0
        return given, vco, out

    def oscillator(self, name):
        """Hz of an oscillator; 0: off."""
        at, hz = {"HSI": (8, HSI_HZ), "HSE": (16, CRYSTAL_HZ)}[name]
        return hz * self._bits(CR, at, 1)

    def system(self):
        """SYSCLK, Hz."""
        chosen = self._bits(CFGR, 0, 2)
        if chosen == 3:
            return self.pll()[2]
        return self.oscillator({1: "HSI", 2: "HSE"}.get(chosen, "HSI"))

    def core(self):
        """HCLK, Hz."""
        code = self._bits(CFGR, 4, 4)
        return self.system() / (1, 2, 4, 8, 16, 64, 128, 256, 512)[max(code - 7, 0)]

    def bus_clock(self, number):
        """PCLK1 or PCLK2, Hz."""
        code = self._bits(CFGR, 8 if number == 1 else 11, 3)
        return self.core() / (1, 2, 4, 8, 16)[max(code - 3, 0)]

    def timer(self, number):
        """The clock of the timers at a bus, Hz."""
        divided = self._bits(CFGR, 8 if number == 1 else 11, 3) > 3
        return self.bus_clock(number) * (2 if divided else 1)

    def converter(self, adc):
        """The clock of a converter, Hz; 0: none."""
        common = ADC_COMMON[adc]
        mode = self._bits(common, 16, 2)
        if mode:
            return self.core() / (1, 2, 4)[mode - 1]
        chosen = self._bits(CCIPR, 28 if adc < 3 else 30, 2)
        hz = self.system() if chosen == 2 else 0
        divider = self._bits(common, 18, 4)
        return hz / ADC_DIVIDERS[divider] if divider < len(ADC_DIVIDERS) else 0

    def serial(self):
        """The clock of USART2, Hz; 0: none that runs."""
        chosen = self._bits(CCIPR, 2, 2)
        return (self.bus_clock(1), self.system(), self.oscillator("HSI"), 0)[chosen]

    def range(self):
        """The voltage range of the core."""
        if self._bits(PWR_CR1, 9, 2) == 2:
            return "low"
        return "normal" if self._bits(PWR_CR5, 8, 1) else "boost"

    def written(self, address, old):
        """A register was written that a clock hangs on."""
        find = self.bus.judge.find
        if address == PLLCFGR and self._bits(CR, 24, 1) and old != self.bus.stored(PLLCFGR):
            find("clock", "RCC.PLLCFGR", "written while the PLL runs")
        given, vco, out = self.pll()
        if vco:
            for name, hz, (least, most) in (
                ("PLL's input", given, PLL_INPUT_HZ),
                ("PLL's oscillator", vco, PLL_VCO_HZ),
                ("PLL's output", out, PLL_OUTPUT_HZ),
            ):
                if not least <= hz <= most:
                    find("clock", name, f"{least:g} to {most:g} Hz", f"{hz:g} Hz")
        hz, span = self.core(), self.range()
        states = self._bits(FLASH_ACR, 0, 4)
        limits = MOST_HZ[span]
        most = limits[min(states, len(limits) - 1)]
        if hz > most:
            find(
                "clock",
                "core",
                f"more than {most:g} Hz with {states} wait states, range {span}",
                f"{hz:g} Hz",
            )
        if hz == 0:
            find("clock", "core", "has no clock that runs")
        if (
            hz > STEP_HZ >= self.core_hz
            and address == CFGR
            and self._bits(CFGR, 4, 4) == 0
            and not self.half
        ):
            find(
                "clock", "core", "rises above 80 MHz in one step", f"{self.core_hz:g} to {hz:g} Hz"
            )
        # Half of a fast clock has been reached: the next step may be whole.
        self.half = self._bits(CFGR, 4, 4) == 8 and self.system() > STEP_HZ
        self.core_hz = hz
        if self.bus.clock.started is not None:
            self.started("TIM2", 1)

    def started(self, timer, number):
        """A timer is started: its clock, and the core's, must be the model's tick."""
        for name, hz in ((timer, self.timer(number)), ("core", self.core())):
            if hz != self.bus.TICK_HZ:
                self.bus.judge.find("clock", name, f"not {self.bus.TICK_HZ} Hz", f"{hz:g} Hz")

    def converter_in(self, adc):
        """A converter is switched on."""
        hz = self.converter(adc)
        if not 0 < hz <= ADC_HZ:
            self.bus.judge.find(
                "clock", f"ADC{adc}", f"not between 0 and {ADC_HZ:g} Hz", f"{hz:g} Hz"
            )

    def settled(self):
        """At the end of a run: a DAC must know how fast its bus is (RM0440, DAC_MCR, HFSEL)."""
        hz = self.core()
        wanted = 2 if hz > 160e6 else 1 if hz > 80e6 else 0
        for dac, base in DAC.items():
            told = self._bits(base + 0x3C, 14, 2)
            if self.bus.stored(base) & 0x1_0001 and told != wanted:
                self.bus.judge.find("clock", f"DAC{dac}.MCR", "hfsel", f"{told} at {hz:g} Hz")
