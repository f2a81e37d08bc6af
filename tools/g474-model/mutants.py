#!/usr/bin/env python3
"""Changes each configuration write of the image in turn and looks whether anything notices.

    mutants.py IMAGE FOLDER --scene FILE --microphone-1 FILE [--part K/N] [--first N] [--at-once N]

A configuration write is one of the start, before the core sleeps for the first time. Each field
that one changes is a mutant, once for every value it is given: `kept`, the field stays as it
was (a field that acts when written does not act), and for a field of several bits `other`,
it gets the neighbour of the value it should have. The image is not built again: the
change is made as the write reaches the bus.

The scene is JSON: {"seconds": S, "driven_from": S, "script": [...], "events": {name: [seconds, script]}}. Every
mutant runs the script up to `seconds`, and one that nobody has noticed then every event from
there on. What is looked at is, in this order, `CHECKS`, the short events, the facts (facts.py),
the long events. Everything but the register data is compared with the run of the unchanged
image, which the tests of the image hold against the host, the facts against a committed file.

FOLDER gets `mutants.json`: every mutant with what killed it, or null.
"""

import argparse
import json
import os
import pathlib
import signal
import sys
import traceback

import registers
from bus import TICK_HZ, Bus
from core import RAM, RAM_BYTES, Core, NoImage, Stuck
from facts import facts
from unicorn import UcError

CHECKS = (
    "register data", "start", "resets", "samples", "tacho", "frames", "outputs", "coils",
)  # fmt: skip
EVENT_CHECKS = [name for name in CHECKS if name not in ("samples", "tacho")]
# Events that are longer come last, after what the registers say by themselves.
SHORT_S = 0.005
RARELY = 48
# A start, and a run or an event, that have not come to their ends by then go round in a loop:
# seconds of this process, of which a start takes one and the longest event three.
START_S, RUN_S = 5, 30
# Two runs' currents that are less apart are the same.
COIL_A = 0.005
EARLIER_BYTES = 200
# Of the DMA, from 0, and the bytes that are looked at where it writes.
MICROPHONE_CHANNELS, TACHO_CHANNEL, CARRIED_BYTES = (0, 1), 4, 128
# TIM2_EGR acts when it is written, which the register file does not say of it.
EGR = 0x4000_0014
# Written for every sleep: when to wake, and that.
SLEEPS = (0x4000_0010, 0x4000_0034)


class Changes:
    """The configuration writes: listed, and one of them changed."""

    def __init__(self, bus, reached):
        self.bus, self.reached = bus, reached
        self.number = 0
        self.seen = set()
        self.open = True

    def _fields(self, address, mask, value):
        """Fields that a write changes: name, place, mask, value before and after."""
        register = self.bus.judge.registers.get(address)
        if register is None:
            return
        old = self.bus.stored(address)
        for name, (at, width, how, _) in sorted(register.fields.items()):
            before, after = old >> at & width, value >> at & width
            acts = how in ("set by 1", "clear by 1") or not register.readable or address == EGR
            if not mask >> at & 1 or how is None and register.mask["read only"] >> at & 1:
                continue
            if acts and after or not acts and before != after:
                yield f"{register.name}.{name}", at, width, 0 if acts else before, after

    def write(self, address, mask, value):
        """Every store passes here; what is returned reaches the bus."""
        if not self.open or self.bus.core.has_slept or address in SLEEPS:
            return value
        whole = self.bus.stored(address) & ~mask | value & mask
        for name, at, width, before, after in self._fields(address, mask, whole):
            others = {"kept": before}
            if width > 1 and after ^ 1 != before:
                others["other"] = after ^ 1
            # Where the linker has put a buffer is no part of a name.
            named = "memory" if RAM <= after < RAM + RAM_BYTES else f"{after:#x}"
            for kind, instead in others.items():
                key = f"{name} {named} {kind}"
                if key in self.seen:
                    continue
                self.seen.add(key)
                if self.reached({"mutant": key, "instead": hex(instead)}):
                    self.open = False
                    return value & ~(width << at) | instead << at
        return value


class Trial:
    """One process's run of the scene."""

    def __init__(self, given):
        self.scene = json.loads(given.scene.read_text())
        steps = self.scene["script"]
        self.bus = Bus(ticks(steps), registers.load(given.registers))
        sound = given.microphone_1.read_bytes()
        # The second microphone hears the same, a little earlier.
        self.bus.analog.sounds = {"PA0": sound, "PA1": sound[EARLIER_BYTES:]}
        # Until something is driven one PWM period in so many is enough.
        self.bus.power.every = RARELY
        self.core = Core(given.image, self.bus)

    def outcome(self):
        """What there is to look at now."""
        bus = self.bus
        trace = [step for step in bus.trace if step["kind"] != "script"]
        return {
            "register data": [
                f"{f['what']} {f['register']} {f['field']}" for f in bus.judge.findings.values()
            ],
            "resets": [step for step in trace if step["kind"] == "reset"],
            "samples": [
                *bus.analog.count.values(),
                *(self.carried(k) for k in MICROPHONE_CHANNELS),
                *(step for step in trace if step["kind"] == "sampling"),
            ],
            "tacho": self.carried(TACHO_CHANNEL),
            "frames": bytes(bus.serial.said).hex(),
            "outputs": [s for s in trace if s["kind"] in ("outputs", "pin", "dac", "erase")],
            "coils": [*bus.analog.current_a, bus.analog.valve()],
            "facts": facts(bus),
        }

    def carried(self, channel):
        """What a channel of the DMA has written, from its start."""
        place = self.bus.stored(self.bus.dma[channel].base + 12)
        try:
            return bytes(self.core.uc.mem_read(place, CARRIED_BYTES)).hex()
        except UcError as why:
            return str(why)

    def run(self, seconds):
        """Runs to a moment, through one reset."""
        end, driven = round(seconds * TICK_HZ), round(self.scene["driven_from"] * TICK_HZ)
        try:
            if self.bus.now < driven:
                self.core.run(driven)
                self.bus.power.every = 1
            if not self.core.run(end):
                self.bus.tree.settled()
                self.bus.restart()
                self.core.restart()
                self.core.run(end)
        except Stuck as why:
            return {"start": str(why)} | self.outcome()
        self.bus.tree.settled()
        return {"start": None} | self.outcome()

    def lasts_s(self, event):
        """From the end of the script to the end of an event."""
        return self.scene["events"][event][0] - self.scene["seconds"]

    def event(self, name):
        """What an event makes, from now on, in a process of its own."""
        seconds, steps = self.scene["events"][name]

        def act():
            if self.lasts_s(name) > SHORT_S:
                # Nothing is driven any more.
                self.bus.power.every = RARELY
            self.bus.script = sorted(self.bus.script + ticks(steps), key=lambda step: step[0])
            return self.run(seconds)

        return in_child(act)


def ticks(steps):
    """A script's steps with times in ticks."""
    return [[round(s * TICK_HZ), name, value] for s, name, value in steps]


def in_child(act):
    """The result of a call in a process of its own; none when that does not end by itself."""
    reader, writer = os.pipe()
    child = os.fork()
    if child == 0:
        os.close(reader)
        give(RUN_S)
        with os.fdopen(writer, "w") as out:
            json.dump(act(), out)
        os._exit(0)
    os.close(writer)
    with os.fdopen(reader) as answer:
        text = answer.read()
    os.waitpid(child, 0)
    return json.loads(text) if text else None


def give(seconds):
    """This process ends when it has taken so much of the processor from now on."""
    signal.setitimer(signal.ITIMER_VIRTUAL, seconds)


def differs(name, seen, wanted):
    """Whether a check notices a difference."""
    if name == "register data":
        return bool(seen[name])
    if name == "coils":
        return any(abs(a - b) > COIL_A for a, b in zip(seen[name], wanted[name]))
    return seen[name] != wanted[name]


def killed_by(trial, baseline):
    """The first check that notices, or none."""
    while not trial.core.has_slept and trial.bus.reset_by is None:
        trial.core.run(trial.bus.now + 1)
    give(RUN_S)
    if trial.bus.judge.findings:
        return "register data"
    seen = trial.run(trial.scene["seconds"])
    for name in CHECKS:
        if differs(name, seen, baseline):
            return name
    long = [event for event in baseline["events"] if trial.lasts_s(event) > SHORT_S]
    for event in [event for event in baseline["events"] if event not in long] + ["facts"] + long:
        if event == "facts":
            if differs("facts", seen, baseline):
                return "facts"
            continue
        after, wanted = trial.event(event), baseline["events"][event]
        if after is None:
            return f"event {event}: hangs"
        for name in EVENT_CHECKS:
            if differs(name, after, wanted):
                return f"event {event}: {name}"
    return None


def whole(trial):
    """The unchanged image: the scene, and every event after it."""
    seen = trial.run(trial.scene["seconds"])
    seen["events"] = {name: trial.event(name) for name in trial.scene["events"]}
    return seen


def arguments():
    """The command line."""
    parser = argparse.ArgumentParser(description=__doc__.split("\n", 1)[0])
    parser.add_argument("image", type=pathlib.Path)
    parser.add_argument("folder", type=pathlib.Path)
    parser.add_argument("--registers", type=pathlib.Path, default=registers.find())
    parser.add_argument("--scene", type=pathlib.Path, required=True)
    parser.add_argument("--microphone-1", type=pathlib.Path, required=True)
    parser.add_argument("--part", default="0/1")
    parser.add_argument("--first", type=int, default=0)
    parser.add_argument("--at-once", type=int, default=os.cpu_count() or 1)
    return parser.parse_args()


class Herd:
    """Mutants at work, each in a process of its own, a few at once."""

    def __init__(self, trial, baseline, given):
        self.trial, self.baseline, self.given = trial, baseline, given
        self.part, self.parts = map(int, given.part.split("/"))
        self.listed, self.running, self.answer = [], {}, None

    def reached(self, mutant):
        """A write that can be changed: true in the process in which it is."""
        number = len(self.listed)
        self.listed.append(mutant)
        if number % self.parts != self.part or number < self.given.first:
            return False
        while len(self.running) >= self.given.at_once:
            self.collect()
        reader, writer = os.pipe()
        child = os.fork()
        if child:
            os.close(writer)
            self.running[child] = (mutant, reader)
            return False
        os.close(reader)
        give(START_S)
        self.answer = writer
        return True

    def tell(self, verdict):
        """A mutant's last word; the unchanged image has none, and is not stuck."""
        if self.answer is not None:
            os.write(self.answer, json.dumps(verdict).encode())
            os._exit(0)
        raise SystemExit(f"mutants.py: the unchanged image: {verdict}")

    def collect(self):
        """Waits for one to end."""
        child, status = os.wait()
        mutant, reader = self.running.pop(child)
        with os.fdopen(reader) as answer:
            text = answer.read()
        if os.WIFEXITED(status) and os.WEXITSTATUS(status):
            raise SystemExit(f"mutants.py: the model fails at {mutant['mutant']}")
        mutant["killed_by"] = json.loads(text) if text else "start: does not end"
        print(f"{mutant['mutant']}: {mutant['killed_by']}", file=sys.stderr)

    def work(self):
        """Runs the start; every mutant leaves it at its own write."""
        trial = self.trial
        trial.bus.changes = Changes(trial.bus, self.reached)
        try:
            while not trial.core.has_slept and self.answer is None:
                trial.core.run(trial.bus.now + 1)
            if self.answer is not None:
                self.tell(killed_by(trial, self.baseline))
        except Stuck as why:
            self.tell(f"start: {why}")
        except BaseException:
            traceback.print_exc()
            os._exit(1)
        while self.running:
            self.collect()
        return self.listed


def main():
    """Lists, runs and judges; exit code 0 when every mutant has been run."""
    given = arguments()
    trial = Trial(given)
    baseline = in_child(lambda: whole(trial))
    if baseline is None or baseline["start"] or baseline["register data"]:
        print(
            f"mutants.py: the unchanged image fails: {baseline and baseline['register data']}",
            file=sys.stderr,
        )
        return 1
    listed = Herd(trial, baseline, given).work()
    given.folder.mkdir(parents=True, exist_ok=True)
    (given.folder / "mutants.json").write_text(json.dumps(listed, indent=1))
    return 0


if __name__ == "__main__":
    try:
        sys.exit(main())
    except (registers.NoRegisters, NoImage) as refused:
        print(f"mutants.py: {refused}", file=sys.stderr)
        sys.exit(2)
