"""A port for a master is free, and none that a node's server may be given meanwhile."""
from __future__ import annotations

import pathlib
import socket

import pytest

from amb_rotor import ports

HANDED_OUT = pathlib.Path("/proc/sys/net/ipv4/ip_local_port_range")


def test_a_port_is_free_and_not_handed_out():
    port = ports.free_port()
    if HANDED_OUT.exists():
        assert port < int(HANDED_OUT.read_text().split()[0])
    with socket.socket() as own:
        own.bind(("localhost", port))


def test_a_port_that_is_taken_is_passed_over(monkeypatch):
    with socket.socket() as taken:
        taken.bind(("localhost", 0))
        busy = taken.getsockname()[1]
        monkeypatch.setattr(ports.random.SystemRandom, "sample", lambda *_: [busy, ports.LOWEST + 7])
        assert ports.free_port() == ports.LOWEST + 7
        monkeypatch.setattr(ports.random.SystemRandom, "sample", lambda *_: [busy])
        with pytest.raises(RuntimeError, match="is free"):
            ports.free_port()
