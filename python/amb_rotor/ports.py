"""A port for a ROS master of one's own."""
from __future__ import annotations

import random
import socket

# Below those that systems hand out to whoever asks for any (Linux: from 32768): the servers of nodes that start at the same time do,
# and would take one of these between its choice and the start of the master.
LOWEST, HIGHEST = 20000, 32000
TRIES = 100


def free_port() -> int:
    for port in random.SystemRandom().sample(range(LOWEST, HIGHEST), TRIES):
        with socket.socket() as probe:
            try:
                probe.bind(("localhost", port))
            except OSError:
                continue
            return port
    raise RuntimeError(f"no port between {LOWEST} and {HIGHEST} is free")
