#!/usr/bin/python3
"""Stands where LinuxCNC's screen would be: runs programs as it is told on a socket.

A line `run S F` cuts in a straight line at S 1/min and F mm/min; `override P` turns the operator's
own override of the spindle to P percent; `abort` ends the program; `estop` is the emergency
stop; `hal WORDS` is done by halcmd; `kill` kills rarma's component, as a defect would; `factor` asks for
rarma's factor as HAL has it; `quit` ends LinuxCNC. Each is answered in one line, with `done` where
nothing was asked.
"""

import os
import signal
import socket
import subprocess
import sys
import time

import linuxcnc

ADDRESS = ("127.0.0.1", 9872)
PROGRAM = "cut.ngc"

command = linuxcnc.command()
status = linuxcnc.stat()


def until(ready, seconds=5.0):
    """Waits for a state; in automatic mode wait_complete would block."""
    end = time.monotonic() + seconds
    while time.monotonic() < end:
        status.poll()
        if ready():
            return
        time.sleep(0.005)
    raise TimeoutError(f"state {status.task_state}, mode {status.task_mode}")


def switch_on():
    command.state(linuxcnc.STATE_ESTOP_RESET)
    until(lambda: status.task_state != linuxcnc.STATE_ESTOP)
    command.state(linuxcnc.STATE_ON)
    until(lambda: status.task_state == linuxcnc.STATE_ON)


def run(speed, feed):
    switch_on()
    with open(PROGRAM, "w", encoding="ascii") as program:
        program.write(f"G21 G90 G94 M52 P1\nM3 S{speed}\nG0 X0 Y0 Z0\nG1 X9000 F{feed}\nM5\nM2\n")
    command.mode(linuxcnc.MODE_AUTO)
    until(lambda: status.task_mode == linuxcnc.MODE_AUTO)
    command.program_open(PROGRAM)
    time.sleep(0.1)
    command.auto(linuxcnc.AUTO_RUN, 0)
    until(lambda: status.interp_state != linuxcnc.INTERP_IDLE)


def abort():
    command.abort()
    until(lambda: status.interp_state == linuxcnc.INTERP_IDLE)
    command.mode(linuxcnc.MODE_MANUAL)
    until(lambda: status.task_mode == linuxcnc.MODE_MANUAL)
    command.spindle(linuxcnc.SPINDLE_OFF)
    command.spindleoverride(1.0)


def halcmd(*words):
    return subprocess.run(["halcmd", *words], check=True, capture_output=True, text=True).stdout


def kill():
    # ID, type, name, process, state; the name `rarma` alone is the component's.
    rows = [line.split() for line in halcmd("-s", "show", "comp", "rarma").splitlines()]
    (process,) = [int(row[3]) for row in rows if row[2:3] == ["rarma"]]
    os.kill(process, signal.SIGKILL)


def obey(line):
    """Returns the answer, or None when it is to end."""
    name, *values = line.split()
    if name == "run":
        run(float(values[0]), float(values[1]))
    elif name == "override":
        command.spindleoverride(float(values[0]) / 100.0)
    elif name == "abort":
        abort()
    elif name == "estop":
        command.state(linuxcnc.STATE_ESTOP)
        until(lambda: status.task_state == linuxcnc.STATE_ESTOP)
    elif name == "hal":
        halcmd(*values)
    elif name == "kill":
        kill()
    elif name == "factor":
        return halcmd("-s", "getp", "rarma-limit.out").strip()
    elif name == "quit":
        return None
    else:
        return f"not known: {name}"
    return "done"


def main():
    with socket.create_server(ADDRESS) as listening:
        peer, _ = listening.accept()
        with peer, peer.makefile("rw") as lines:
            for line in lines:
                answer = obey(line)
                if answer is None:
                    return
                lines.write(answer + "\n")
                lines.flush()


if __name__ == "__main__":
    sys.exit(main())
