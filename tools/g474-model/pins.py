"""What reaches a peripheral from a pin: the pin's mode, and the function chosen for it.

Which function a number means at which pin, and which pins a converter, a comparator or an
amplifier can have, is the register file's.
"""

PORTS = {port: 0x4800_0000 + 0x400 * k for k, port in enumerate("ABCDEFG")}
MODER, OTYPER, OSPEEDR, PUPDR, AFRL = 0x00, 0x04, 0x08, 0x0C, 0x20
INPUT, OUTPUT, ALTERNATE, ANALOG = range(4)


class Pins:
    """The pins' modes, as the registers have them now."""

    def __init__(self, bus, data):
        self.bus = bus
        self.functions, self.analog = {}, {}
        for name, part in data["peripherals"].items():
            for pin, signal, number in part["pins"]:
                if number is None:
                    self.analog.setdefault(f"{name}_{signal}", []).append(pin)
                else:
                    self.functions.setdefault((pin, number), set()).add(f"{name}_{signal}")

    def _bits(self, pin, offset, width):
        base, number = PORTS[pin[1]], int(pin[2:])
        if width == 4:
            offset, number = offset + 4 * (number >> 3), number & 7
        return self.bus.stored(base + offset) >> number * width & (1 << width) - 1

    def mode(self, pin):
        """Input, output, a peripheral's, or analogue."""
        return self._bits(pin, MODER, 2)

    def leads_to(self, pin, signal):
        """Whether a peripheral has this pin as that signal, by its function's number."""
        if self.mode(pin) != ALTERNATE:
            return False
        return signal in self.functions.get((pin, self._bits(pin, AFRL, 4)), ())

    def is_analog(self, pin):
        """Whether converters, comparators and DACs have it."""
        return self.mode(pin) == ANALOG

    def described(self, pin):
        """Its mode in words."""
        mode = self.mode(pin)
        pull = ("", ", pulled up", ", pulled down", ", pulled both ways")[self._bits(pin, PUPDR, 2)]
        if mode == ANALOG:
            return "analogue" + pull
        if mode == INPUT:
            return "input" + pull
        kind = ("push-pull", "open drain")[self._bits(pin, OTYPER, 1)]
        speed = ("low", "medium", "high", "very high")[self._bits(pin, OSPEEDR, 2)]
        if mode == OUTPUT:
            return f"output, {kind}, {speed} speed{pull}"
        number = self._bits(pin, AFRL, 4)
        names = "/".join(sorted(self.functions.get((pin, number), ["nothing"])))
        return f"{names}, {kind}, {speed} speed{pull}"

    def channel(self, adc, number):
        """The pin of a converter's channel, if it has one that is analogue."""
        for pin in self.analog.get(f"ADC{adc}_IN{number}", ()):
            if self.is_analog(pin):
                return pin
        return None
