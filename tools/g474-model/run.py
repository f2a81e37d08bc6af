#!/usr/bin/env python3
"""Runs an unmodified image for the NUCLEO-G474RE on a model of its chip.

    run.py IMAGE FOLDER --seconds S [--microphone-1 FILE] [--microphone-2 FILE]
           [--script FILE] [--count-from S] [--bridge-every N] [--resets N]

The microphones' files hold what the converter would give: sums of eight conversions,
little-endian 16 bits, 48000 a second. The script is JSON, a list of [seconds, name, value]:
a pin and its level (0 or 1) or its voltage (a number with a point; null: a current sensor
that is no longer held), "tacho" for a pulse,
"host" and bytes in hexadecimal, "exception" and its number, "stopped" for converters that
stand still from then on, "hang" for a program that goes round in a loop, "spoilt" and the
address of a double word of the flash whose check bits are wrong, "flash-fails" and the
address where a fetch finds such a word, "flash-holds" with an address and bytes in
hexadecimal, "supply-low" and 1 or 0, "crystal-fails", "halt" for a debugger that stops the
core, "options" and the option bytes' register, "reset" and its cause.

A run ends with the reset that follows --resets others (default: none).

With --bridge-every only one PWM period in N is made, which is quicker where the current
loop does not matter; from the moment on from which instructions are counted, every one is.

FOLDER gets `frames.bin`, what the link said, and `run.json`: what was seen from outside
(outputs, pins, DACs, resets, erases), the longest time between two feedings of the
watchdog, the stack used (at the start, and since the program has the lower part of its memory), what of
memory is read-only, the interrupts served, and with --count-from,
from that moment on, in `trace.bin`, what was executed (trace.py).
"""

import argparse
import json
import pathlib
import sys

import registers
from bus import TICK_HZ, Bus
from core import Core, NoImage, Stuck
from facts import facts


def arguments():
    """The command line."""
    parser = argparse.ArgumentParser(description=__doc__.split("\n", 1)[0])
    parser.add_argument("image", type=pathlib.Path)
    parser.add_argument("folder", type=pathlib.Path)
    parser.add_argument("--registers", type=pathlib.Path, default=registers.find())
    parser.add_argument("--seconds", type=float, required=True)
    parser.add_argument("--microphone-1", type=pathlib.Path)
    parser.add_argument("--microphone-2", type=pathlib.Path)
    parser.add_argument("--script", type=pathlib.Path)
    parser.add_argument("--count-from", type=float)
    parser.add_argument("--bridge-every", type=int, default=1)
    parser.add_argument("--resets", type=int, default=0)
    return parser.parse_args()


class Refused(Exception):
    """A file that cannot be used; the message says which and why."""


def script_of(path):
    """The steps of a script."""
    try:
        return json.loads(path.read_text())
    except (OSError, ValueError) as why:
        raise Refused(f"script {path} is broken: {why}") from why


def sound_of(path):
    """The codes of a microphone."""
    try:
        codes = path.read_bytes()
    except OSError as why:
        raise Refused(f"{path}: {why.strerror}") from why
    if len(codes) % 2:
        raise Refused(f"{path}: ends within a code of two bytes")
    return codes


def main():
    """One run; exit code 1 when the image got stuck."""
    given = arguments()
    steps = script_of(given.script) if given.script else []
    bus = Bus(
        [[round(s * TICK_HZ), name, value] for s, name, value in steps],
        registers.load(given.registers),
    )
    for pin, path in (("PA0", given.microphone_1), ("PA1", given.microphone_2)):
        if path:
            bus.analog.sounds[pin] = sound_of(path)
    bus.power.every = given.bridge_every
    core = Core(given.image, bus)
    end = round(given.seconds * TICK_HZ)
    seen = {}
    trouble = None
    try:
        if given.count_from is not None and core.run(round(given.count_from * TICK_HZ)):
            core.start_trace()
            bus.power.every = 1
            bus.advance(bus.now)
            seen["counted_samples"] = -bus.analog.taken
        for _ in range(given.resets):
            if core.run(end):
                break
            bus.restart()
            core.restart()
        core.run(end)
    except Stuck as why:
        trouble = str(why)
    if "counted_samples" in seen:
        seen["counted_samples"] += bus.analog.taken
    bus.tree.settled()
    seen |= {
        "trouble": trouble,
        "longest_unfed_s": bus.longest_unfed / TICK_HZ,
        "seconds": bus.now / TICK_HZ,
        "samples": bus.analog.taken,
        "stack_bytes": core.stack_used(),
        "start_stack_bytes": core.start_stack,
        "read_only": core.parts,
        "reset_by": bus.reset_by,
        "interrupts": core.served,
        "trace": bus.trace,
        "judged": bus.judge.report(),
        "facts": facts(bus),
    }
    given.folder.mkdir(parents=True, exist_ok=True)
    (given.folder / "frames.bin").write_bytes(bus.serial.said)
    if core.trace:
        (given.folder / "trace.bin").write_bytes(core.trace.whole())
    (given.folder / "run.json").write_text(json.dumps(seen, indent=1))
    if trouble:
        print(f"stuck: {trouble}", file=sys.stderr)
    return 1 if trouble else 0


if __name__ == "__main__":
    try:
        sys.exit(main())
    except (registers.NoRegisters, NoImage, Refused) as refused:
        print(f"run.py: {refused}", file=sys.stderr)
        sys.exit(2)
