"""What a rotor does in its auxiliary bearings after the magnetic bearings are lost: the motion of figures 4.16 to 4.18.

Of each end, from an instant on: z = rotor - auxiliary bearing (complex), its angle followed without jumps.
  whirl     [Hz]  turns of the angle over the time: negative against the spin
  contact   [-]   share of the time in which it touches
  swing     [deg] from the smallest to the largest angle
  wall      [-]   share of the time in which abs(z) is above `NEAR_WALL` of the clearance
A motion is named by the end that whirls the faster:
  backward_whirl, forward_whirl   over `LEAST_WHIRL_HZ`, for at least `LEAST_TURNS` turns, and along the wall for at
                least `LEAST_WALL` of the time: bounces across the bearing turn the angle, too
  oscillation   touches for at least `LASTING` of the time and swings by at least `LEAST_SWING_DEG` about the bottom
  rest          touches for at least `LASTING`, swings less
  spring        leaves and comes back again and again, to the end
  free          no contact
A run that ends at a magnet (`ended`) has the motion of its last `BEFORE_HIT_S`; one that does not last as long, or ends
otherwise, is named by its end: `magnet_hit`, `diverged`.
"""
from __future__ import annotations

import dataclasses

import numpy

LEAST_WHIRL_HZ, LEAST_TURNS = 10.0, 2.0
NEAR_WALL, LEAST_WALL = 0.8, 0.8
LASTING, LEAST_SWING_DEG = 0.9, 2.0
LEAST_FAILURE_S = 0.1  # half of it is one turn of a slow whirl
BEFORE_HIT_S = 0.05


@dataclasses.dataclass
class Motion:
    """The motion after `from_s`; of the end that whirls the faster."""
    kind: str
    whirl_hz: float
    contact_share: float
    swing_deg: float
    wall_share: float
    contacts: int
    radius: float             # mean distance of the rotor from the stator's axis over the clearance
    peaks: list               # (frequency [Hz], amplitude [m]) of the horizontal motion, the largest first
    ended: str = ""           # magnet_hit: the rotor reached a magnet; diverged; empty: the run came to its end

    def text(self) -> str:
        peaks = ", ".join(f"{frequency:.1f} Hz ({1e6 * amplitude:.1f} um)" for frequency, amplitude in self.peaks[:4])
        return (f"{self.kind.replace('_', ' ')}: whirl {self.whirl_hz:+.1f} Hz, touches {100 * self.contact_share:.1f} %"
                f" of the time ({self.contacts} contacts), near the wall {100 * self.wall_share:.1f} %, mean radius "
                f"{self.radius:.2f} clearances; horizontal spectrum {peaks}")


def peaks(signal, rate_hz: float, highest_hz: float = 600.0) -> list:
    """Maxima of the amplitude spectrum (Hann window) that no larger one is near to, the largest first."""
    window = numpy.hanning(len(signal))
    amplitude = numpy.abs(numpy.fft.rfft((signal - numpy.mean(signal)) * window)) * 2.0 / window.sum()
    frequency = numpy.fft.rfftfreq(len(signal), 1.0 / rate_hz)
    inner = amplitude[1:-1]
    places = 1 + numpy.flatnonzero((inner > amplitude[:-2]) & (inner >= amplitude[2:]) & (frequency[1:-1] < highest_hz))
    places = places[numpy.argsort(-amplitude[places])]
    return [(float(frequency[place]), float(amplitude[place])) for place in places]


def motion_of_run(result: dict, from_s: float) -> Motion:
    """The motion that a run (`_core.simulate`) ends in, from an instant on where it lasts so long."""
    if result["status"] == "ok":
        return motion(result["columns"], result["clearance_m"], from_s)
    ended = "magnet_hit" if result["status"] == "magnet_hit" else "diverged"
    begin = result["time_s"] - BEFORE_HIT_S
    if ended == "magnet_hit" and begin > 0.0 and numpy.count_nonzero(result["columns"]["t_s"] >= begin) >= 16:
        return dataclasses.replace(motion(result["columns"], result["clearance_m"], begin), ended=ended)
    return Motion(ended, 0.0, 0.0, 0.0, 0.0, 0, float("inf"), [], ended)


def power_failure(scenario: dict) -> tuple[float, float] | None:
    """The longest time in which a scenario (its file as a dictionary) has all axes of both magnetic bearings off; None: there
    is none, or it is too short to name a motion."""
    longest = None
    for fault in scenario["faults"]:
        if fault["type"] != "amb_off" or fault["end"] != "both" or fault["axis"] != "both":
            continue
        begin, end = float(fault["start_s"]), float(scenario["duration_s"])
        if fault["duration_s"] > 0.0:
            end = min(end, begin + float(fault["duration_s"]))
        end = min([end, *(float(other["start_s"]) for other in scenario["faults"]
                          if other["type"] == "amb_on" and other["start_s"] > begin)])
        if end - begin >= LEAST_FAILURE_S and (longest is None or end - begin > longest[1] - longest[0]):
            longest = begin, end
    return longest


def motion(columns: dict, clearance: float, from_s: float) -> Motion:
    """The motion that a table of `amb simulate` shows from an instant on."""
    part = columns["t_s"] >= from_s
    time = columns["t_s"][part]
    seconds = time[-1] - time[0]
    best = None
    for end in "ab":
        x = (columns[f"aux_{end}x_m"] - columns[f"centre_{end}x_m"])[part]
        y = (columns[f"aux_{end}y_m"] - columns[f"centre_{end}y_m"])[part]
        angle = numpy.unwrap(numpy.arctan2(y, x))
        touching = columns[f"normal_{end}_N"][part] > 0.0
        starts = numpy.flatnonzero(numpy.diff(touching.astype(int)) == 1)
        turns = (angle[-1] - angle[0]) / (2.0 * numpy.pi)
        whirl, share = turns / seconds, float(touching.mean())
        swing = float(numpy.degrees(numpy.ptp(angle)))
        wall = float((numpy.hypot(x, y) > NEAR_WALL * clearance).mean())
        if abs(whirl) >= LEAST_WHIRL_HZ and abs(turns) >= LEAST_TURNS and wall >= LEAST_WALL:
            kind = "backward_whirl" if whirl < 0 else "forward_whirl"
        elif share >= LASTING:
            kind = "oscillation" if swing >= LEAST_SWING_DEG else "rest"
        else:
            kind = "spring" if touching[-len(touching) // 4:].any() else "free"
        found = Motion(kind, float(whirl), share, swing, wall, len(starts),
                       float(numpy.mean(numpy.hypot(columns[f"aux_{end}x_m"], columns[f"aux_{end}y_m"])[part])) / clearance,
                       peaks(columns[f"aux_{end}x_m"][part], (len(time) - 1) / seconds))
        if best is None or abs(found.whirl_hz) > abs(best.whirl_hz):
            best = found
    return best
