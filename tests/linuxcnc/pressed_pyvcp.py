"""LinuxCNC's own pyvcp with a finger: run by the system's Python, which has Tk and HAL.

Lines of the file `finger` are done in turn: `press TEXT`, `release TEXT` of a button, or
`type TEXT` into the only field and Return.
"""

import runpy
import sys
import tkinter
from pathlib import Path

FINGER = Path("finger")
LOOK_MS = 50


def widgets(parent):
    for child in parent.winfo_children():
        yield child
        yield from widgets(child)


def enter(window, text):
    field = next(each for each in widgets(window) if isinstance(each, tkinter.Spinbox))
    field.delete(0, "end")
    field.insert(0, text)
    field.focus_force()
    field.event_generate("<Return>")


def look(window, done=0):
    orders = FINGER.read_text().splitlines() if FINGER.exists() else []
    for order in orders[done:]:
        verb, _, text = order.partition(" ")
        if verb == "type":
            enter(window, text)
        else:
            buttons = [each for each in widgets(window) if isinstance(each, tkinter.Button)]
            button = next(each for each in buttons if each.cget("text") == text)
            button.event_generate("<ButtonPress-1>" if verb == "press" else "<ButtonRelease-1>")
    window.after(LOOK_MS, look, window, len(orders))


_mainloop = tkinter.Tk.mainloop


def mainloop(window, n=0):
    window.update()
    look(window)
    _mainloop(window, n)


tkinter.Tk.mainloop = mainloop
sys.argv[0] = "/usr/bin/pyvcp"
runpy.run_path(sys.argv[0], run_name="__main__")
