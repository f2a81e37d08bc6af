#!/usr/bin/python3
"""HAL component between `rarma act --controller linuxcnc` and LinuxCNC.

It carries numbers between a socket and pins, and decides nothing. Limits, rate and dead man
stand in rarma.hal, in the real-time part: `beat` changes with every step for as long as an
order is fresh; where it stops, for whatever reason, HAL goes back to factor 1.

    loadusr -Wn rarma python3 rarma_override.py [HOST:PORT]
"""

import json
import selectors
import socket
import sys
import time

import hal

ADDRESS = "127.0.0.1:9871"
STEP_S = 0.02
# An order that has not been said again for so long is none.
FRESH_S = 0.5
LONGEST = 4096

PINS = [
    ("commanded-rpm", hal.HAL_FLOAT, hal.HAL_IN),
    ("actual-rps", hal.HAL_FLOAT, hal.HAL_IN),
    ("operator", hal.HAL_FLOAT, hal.HAL_IN),
    ("operator-feed", hal.HAL_FLOAT, hal.HAL_IN),
    ("factor-in-force", hal.HAL_FLOAT, hal.HAL_IN),
    ("feed-in-force", hal.HAL_FLOAT, hal.HAL_IN),
    ("least", hal.HAL_FLOAT, hal.HAL_IN),
    ("most", hal.HAL_FLOAT, hal.HAL_IN),
    ("is-idle", hal.HAL_BIT, hal.HAL_IN),
    ("is-on", hal.HAL_BIT, hal.HAL_IN),
    ("factor", hal.HAL_FLOAT, hal.HAL_OUT),
    ("feed-follows", hal.HAL_BIT, hal.HAL_OUT),
    ("enable", hal.HAL_BIT, hal.HAL_OUT),
    ("beat", hal.HAL_BIT, hal.HAL_OUT),
    ("starting", hal.HAL_BIT, hal.HAL_OUT),
    ("proposed-rpm", hal.HAL_FLOAT, hal.HAL_OUT),
]


class Link:
    """One program at a time may order; another that connects is turned away."""

    def __init__(self, address):
        host, port = address.rsplit(":", 1)
        self.listening = socket.create_server((host, int(port)))
        self.listening.setblocking(False)
        self.selector = selectors.DefaultSelector()
        self.selector.register(self.listening, selectors.EVENT_READ)
        self.peer = None
        self.bytes = b""

    def wait(self, seconds):
        """Waits so long; the lines that have come meanwhile."""
        lines = []
        until = time.monotonic() + seconds
        while True:
            left = until - time.monotonic()
            if left <= 0:
                return lines
            for key, _ in self.selector.select(left):
                if key.fileobj is self.listening:
                    self.accept()
                else:
                    lines += self.read()

    def accept(self):
        peer, _ = self.listening.accept()
        if self.peer is not None:
            peer.close()
            return
        peer.setblocking(False)
        peer.setsockopt(socket.IPPROTO_TCP, socket.TCP_NODELAY, 1)
        self.peer, self.bytes = peer, b""
        self.selector.register(peer, selectors.EVENT_READ)

    def read(self):
        try:
            got = self.peer.recv(LONGEST)
        except BlockingIOError:
            return []
        except OSError:
            got = b""
        self.bytes += got
        *lines, self.bytes = self.bytes.split(b"\n")
        if not got or len(self.bytes) > LONGEST:
            self.close()
        return lines

    def say(self, what):
        if self.peer is None:
            return
        try:
            self.peer.sendall(json.dumps(what).encode() + b"\n")
        except OSError:
            # Gone, or it does not read: either way it is of no use.
            self.close()

    def close(self):
        if self.peer is not None:
            self.selector.unregister(self.peer)
            self.peer.close()
            self.peer = None


class Orders:
    """What is ordered, and whether it is fresh."""

    def __init__(self, pins):
        self.pins = pins
        self.at_s = None

    def take(self, line):
        """Returns False where the line is none of ours."""
        try:
            say = json.loads(line)
            if "factor" in say:
                factor = float(say["factor"]["spindle"])
                # HAL limits it; a number that is none never gets there.
                if not 0.0 < factor < 10.0:
                    return False
                self.pins["factor"] = factor
                self.pins["feed-follows"] = bool(say["factor"]["feed"])
                self.pins["starting"] = False
                self.at_s = time.monotonic()
            elif "leave" in say:
                self.at_s = None
            elif "propose" in say:
                self.pins["proposed-rpm"] = float(say["propose"][0]) if say["propose"] else 0.0
            else:
                return False
        except (ValueError, TypeError, KeyError, AttributeError):
            return False
        return True

    def step(self):
        if self.at_s is not None and time.monotonic() - self.at_s > FRESH_S:
            self.at_s = None
        fresh = self.at_s is not None
        self.pins["enable"] = fresh
        if fresh:
            self.pins["beat"] = not self.pins["beat"]


def status(pins):
    return {
        "commanded_rpm": pins["commanded-rpm"],
        "actual_rpm": 60.0 * pins["actual-rps"],
        "operator": pins["operator"],
        "operator_feed": pins["operator-feed"],
        "factor": pins["factor-in-force"],
        "feed_factor": pins["feed-in-force"],
        "running": not pins["is-idle"],
        "stopped": not pins["is-on"],
        "range": [pins["least"], pins["most"]],
    }


def main():
    link = Link(sys.argv[1] if len(sys.argv) > 1 else ADDRESS)
    pins = hal.component("rarma")
    for name, kind, way in PINS:
        pins.newpin(name, kind, way)
    pins["factor"] = 1.0
    pins["starting"] = True
    pins.ready()
    orders = Orders(pins)
    while True:
        for line in link.wait(STEP_S):
            if not orders.take(line):
                link.close()
        if link.peer is None:
            orders.at_s = None
        orders.step()
        link.say(status(pins))


if __name__ == "__main__":
    try:
        main()
    except KeyboardInterrupt:
        pass
