"""Drops a file on a window as a file manager does: the XDND protocol, version 5.

Run as a program (python x_drop.py WINDOW PATH), because xdotool cannot.
"""

from __future__ import annotations

import ctypes
import ctypes.util
import sys
import time
from pathlib import Path

_SELECTION_NOTIFY, _SELECTION_REQUEST, _CLIENT_MESSAGE = 31, 30, 33
_XA_ATOM_FORMAT_8, _PROP_MODE_REPLACE = 8, 0
_VERSION = 5
_Head = [
    ("type", ctypes.c_int),
    ("serial", ctypes.c_ulong),
    ("send_event", ctypes.c_int),
    ("display", ctypes.c_void_p),
]


class ClientMessage(ctypes.Structure):
    _fields_ = [
        *_Head,
        ("window", ctypes.c_ulong),
        ("message_type", ctypes.c_ulong),
        ("format", ctypes.c_int),
        ("data", ctypes.c_long * 5),
    ]


class SelectionRequest(ctypes.Structure):
    _fields_ = [
        *_Head,
        ("owner", ctypes.c_ulong),
        ("requestor", ctypes.c_ulong),
        ("selection", ctypes.c_ulong),
        ("target", ctypes.c_ulong),
        ("property", ctypes.c_ulong),
        ("time", ctypes.c_ulong),
    ]


class SelectionNotify(ctypes.Structure):
    _fields_ = [
        *_Head,
        ("requestor", ctypes.c_ulong),
        ("selection", ctypes.c_ulong),
        ("target", ctypes.c_ulong),
        ("property", ctypes.c_ulong),
        ("time", ctypes.c_ulong),
    ]


class Event(ctypes.Union):
    _fields_ = [
        ("type", ctypes.c_int),
        ("client", ClientMessage),
        ("request", SelectionRequest),
        ("notify", SelectionNotify),
        ("pad", ctypes.c_long * 24),
    ]


def drop(target: int, path: Path, seconds: float = 240.0) -> None:
    """Drop `path` on the window `target`; return when it has been taken."""
    x11 = ctypes.CDLL(ctypes.util.find_library("X11") or "libX11.so.6")
    x11.XOpenDisplay.restype = ctypes.c_void_p
    x11.XInternAtom.restype = x11.XCreateSimpleWindow.restype = ctypes.c_ulong
    x11.XDefaultRootWindow.restype = ctypes.c_ulong
    display = ctypes.c_void_p(x11.XOpenDisplay(None))
    root = ctypes.c_ulong(x11.XDefaultRootWindow(display))
    source = x11.XCreateSimpleWindow(display, root, 0, 0, 1, 1, 0, 0, 0)

    def atom(name: str) -> int:
        return int(x11.XInternAtom(display, name.encode(), 0))

    def send(name: str, *data: int) -> None:
        event = Event()
        event.client.type = _CLIENT_MESSAGE
        event.client.window = target
        event.client.message_type = atom(name)
        event.client.format = 32
        for index, value in enumerate((source, *data)):
            event.client.data[index] = value
        x11.XSendEvent(display, ctypes.c_ulong(target), 0, ctypes.c_long(0), ctypes.byref(event))
        x11.XFlush(display)

    selection, uris = atom("XdndSelection"), atom("text/uri-list")
    x11.XSetSelectionOwner(
        display, ctypes.c_ulong(selection), ctypes.c_ulong(source), ctypes.c_ulong(0)
    )
    send("XdndEnter", _VERSION << 24, uris)
    send("XdndPosition", 0, 10 << 16 | 10, 0, atom("XdndActionCopy"))
    end = time.monotonic() + seconds
    event = Event()
    while time.monotonic() < end:
        if not x11.XPending(display):
            time.sleep(0.02)
            continue
        x11.XNextEvent(display, ctypes.byref(event))
        if event.type == _SELECTION_REQUEST:
            _hand_over(x11, display, event.request, path)
        elif event.type == _CLIENT_MESSAGE:
            if event.client.message_type == atom("XdndStatus"):
                send("XdndDrop", 0, 0)
            elif event.client.message_type == atom("XdndFinished"):
                return
    raise TimeoutError("the window does not take the file")


def _hand_over(
    x11: ctypes.CDLL, display: ctypes.c_void_p, request: SelectionRequest, path: Path
) -> None:
    data = f"{path.resolve().as_uri()}\r\n".encode()
    x11.XChangeProperty(
        display,
        ctypes.c_ulong(request.requestor),
        ctypes.c_ulong(request.property),
        ctypes.c_ulong(request.target),
        _XA_ATOM_FORMAT_8,
        _PROP_MODE_REPLACE,
        data,
        len(data),
    )
    answer = Event()
    answer.notify.type = _SELECTION_NOTIFY
    for name in ("requestor", "selection", "target", "property", "time"):
        setattr(answer.notify, name, getattr(request, name))
    x11.XSendEvent(
        display, ctypes.c_ulong(request.requestor), 0, ctypes.c_long(0), ctypes.byref(answer)
    )
    x11.XFlush(display)


if __name__ == "__main__":
    drop(int(sys.argv[1]), Path(sys.argv[2]))
