"""Work counted instead of timed: a computation takes the same steps on every machine."""

import gc
import sys


def steps_of(function, *arguments, **named):
    """Steps of the interpreter (opcodes) in one run of a function and all that it calls."""
    count = 0

    def trace(frame, event, arg):
        nonlocal count
        if event == "call":
            frame.f_trace_lines, frame.f_trace_opcodes = False, True
        count += event == "opcode"
        return trace

    before = sys.gettrace()
    gc.disable()  # it calls back at its own moments
    sys.settrace(trace)
    try:
        function(*arguments, **named)
    finally:
        sys.settrace(before)
        gc.enable()
    return count
