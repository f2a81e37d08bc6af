"""What the image has made of the chip, in the units of its design: for tests and for readers.

Derived from the registers as they stand at the end of a run; what a run itself shows (rates,
verdicts, breaks) is not repeated here.
"""

from analog import ADC, COMP, DAC, MICROPHONES, MINUS, OPAMP4, REFERENCE_V
from clocks import FLASH_ACR, RCC
from dma import DMAMUX1
from safety import EXTI_IMR1, PWR_CR2, SYSCFG_CFGR2
from serial import USART2
from timers import BDTR, CCER, CCMR1, CR1, DEBUG_APB2, FILTER_TICKS, TIM1, TIM2

HYSTERESIS_MV = (0, 10, 20, 30, 40, 50, 60, 70)
# PWR_CR2, PLS: the supply monitor's thresholds, V (RM0440, 6.4.2).
SUPPLY_V = (2.2, 2.4, 2.5, 2.6, 2.7, 2.8, 2.9, 0)
PORTS = "ABCFG"


def dead_time_ns(code, tick_hz):
    """Of TIM1_BDTR's DTG (RM0440, 28.6.20)."""
    steps = (
        code if code < 128 else 2 * (64 + (code & 63)) if code < 192
        else 8 * (32 + (code & 31)) if code < 224 else 16 * (32 + (code & 31))
    )  # fmt: skip
    return round(steps / tick_hz * 1e9, 1)


def facts(bus):
    """All of them, by name."""
    tree, analog, stored = bus.tree, bus.analog, bus.stored
    bdtr, acr = stored(TIM1 + BDTR), stored(FLASH_ACR)
    link = [stored(USART2 + at) for at in (0, 4, 8, 0xC)]
    monitor, lines = stored(PWR_CR2), [stored(EXTI_IMR1 + at) for at in (0, 8, 0xC)]
    modes = [stored(TIM1 + at) for at in (CR1, CCMR1, CCMR1 + 4, CCER)]
    filters = [FILTER_TICKS[bdtr >> at & 15] for at in (16, 20)]
    found = {
        "core": f"{tree.core():.0f} Hz, range {tree.range()}, {acr & 15} wait states, "
        f"prefetch {acr >> 8 & 1}, caches {acr >> 9 & 3:02b}",
        "clock security": stored(RCC) >> 19 & 1,
        "oscillators": f"{stored(RCC) & 0x1_0500:#x}, 48 MHz {stored(RCC + 0x98) & 1}",
        "link": f"{tree.serial() / max(link[3], 1):.0f} baud, "
        f"CR1 {link[0]:#x}, CR2 {link[1]:#x}, CR3 {link[2]:#x}",
        "watchdog": f"{(bus.watchdog_ticks or 0) / bus.TICK_HZ:.4f} s, "
        f"debugger stops it: {stored(0xE004_2008) >> 12 & 1}",
        "debugger stops TIM1": stored(DEBUG_APB2) >> 11 & 1,
        "supply monitor": f"{SUPPLY_V[monitor >> 1 & 7]} V, on: {monitor & 1}, "
        f"told {lines[0]:#x}, rising {lines[1]:#x}, falling {lines[2]:#x}",
        "breaks of the chip itself": f"{stored(SYSCFG_CFGR2) & 0xF:04b}",
        "dead time": f"{dead_time_ns(bdtr & 0xFF, bus.TICK_HZ)} ns",
        "bridges": f"period {bus.power.period()} ticks, update every {bus.power.step()}, "
        f"CR1 {modes[0]:#x}, CCMR {modes[1]:#x} {modes[2]:#x}, CCER {modes[3]:#x}",
        "bridges off": f"driven while idle: {bdtr >> 10 & 1}, while running: {bdtr >> 11 & 1}, "
        f"level CR2 {stored(TIM1 + 4):#x}",
        "breaks": f"pin: on {bdtr >> 12 & 1}, high {bdtr >> 13 & 1}, {filters[0]} ticks; "
        f"comparators: on {bdtr >> 24 & 1}, high {bdtr >> 25 & 1}, {filters[1]} ticks; "
        f"automatic return {bdtr >> 14 & 1}; lock {bdtr >> 8 & 3}",
        "break sources": f"{stored(TIM1 + 0x60):#x} {stored(TIM1 + 0x64):#x}",
        "clock": f"TIM2 overflow told: {stored(TIM2 + 0xC) & 1}",
        "tacho": f"CCMR2 {stored(TIM2 + CCMR1 + 4):#x}, CCER {stored(TIM2 + CCER):#x}",
    }
    for adc in ADC:
        injected, ranks = stored(ADC[adc] + 0x4C), (9, 15, 21, 27)
        channels = [injected >> at & 31 for at in ranks[: (injected & 3) + 1]]
        if adc in MICROPHONES:
            channels = [stored(ADC[adc] + 0x30) >> 6 & 31]
        times = ", ".join(
            f"{analog.source(adc, channel)} {analog.sampling_s(adc, channel) * 1e9:.0f} ns"
            for channel in channels
            if analog.runs(adc)
        )
        found[f"ADC{adc}"] = (
            f"{tree.converter(adc):.0f} Hz, {times}, CFGR {stored(ADC[adc] + 0xC):#x}, "
            f"CFGR2 {stored(ADC[adc] + 0x10):#x}, calibrated {adc in analog.calibrated}"
        )
    for number, dacs in MINUS.items():
        control = stored(COMP + 4 * (number - 1))
        minus = analog.minus(number)
        volts = analog.dac(*minus) / 4095 * REFERENCE_V if minus else 0
        found[f"COMP{number}"] = (
            f"{analog.plus(number)} above {volts:.3f} V, on {control & 1}, "
            f"{HYSTERESIS_MV[control >> 16 & 7]} mV, inverted {control >> 15 & 1}, "
            f"blanked {control >> 19 & 7}"
        )
    found["OPAMP4"] = f"{analog.source(5, 5)} to ADC5, CSR {stored(OPAMP4):#x}"
    found["valve"] = f"code {analog.valve()}, mode {analog.dac_mode(1, 1)}"
    for dac in (1, 3, 4):
        found[f"DAC{dac}"] = f"CR {stored(DAC[dac]):#x}, MCR {stored(DAC[dac] + 0x3C):#x}"
    for dma in bus.dma:
        request = stored(DMAMUX1 + 4 * dma.number)
        if request:
            control = stored(dma.base) & ~1
            found[f"DMA1 channel {dma.number + 1}"] = f"request {request}, CR {control:#x}"
    for port in PORTS:
        for pin in (f"P{port}{number}" for number in range(16)):
            if (words := bus.pins.described(pin)) != "analogue":
                found[pin] = words
    found["PA0 to PB15, analogue"] = " ".join(
        f"P{port}{k}" for port in "AB" for k in range(16) if bus.pins.is_analog(f"P{port}{k}")
    )
    return found
