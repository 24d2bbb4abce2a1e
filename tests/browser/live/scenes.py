"""Event streams for every state of the page of `gravical live`, as docs/live.md describes them.

A scene is a list of events; the page has to show its end. The numbers are made up, the forms are
those of the program.
"""

import math

FACES = ["+x", "-x", "+y", "-y", "+z", "-z"]
ORDER = ["+z", "+x", "-x", "+y", "-y", "-z"]


def direction(face):
    d = [0.0, 0.0, 0.0]
    d["xyz".index(face[1])] = 1.0 if face[0] == "+" else -1.0
    return d


def unit(v):
    n = math.sqrt(sum(c * c for c in v))
    return [c / n for c in v]


def shortest(a):
    """Quaternion that carries the unit vector a to z."""
    w = 1.0 + a[2]
    if w < 1e-6:
        return [0.0, 1.0, 0.0, 0.0]
    q = [w, a[1], -a[0], 0.0]
    n = math.sqrt(sum(c * c for c in q))
    return [c / n for c in q]


def sentences(*parts):
    """Whole sentences, as the library makes them."""
    parts = [p.strip() for p in parts if p]
    cased = [p if p.split()[0].rstrip(":") in ("x", "y", "z") else p[0].upper() + p[1:] for p in parts]
    return " ".join(p if p[-1] in ".!?…" else p + "." for p in cased).replace(" -", " −") if cased else ""


def nearest(up):
    face = max(FACES, key=lambda f: sum(a * b for a, b in zip(up, direction(f))))
    cosine = sum(a * b for a, b in zip(up, direction(face)))
    return face, math.degrees(math.acos(max(-1.0, min(1.0, cosine))))


FREE = [unit(v) for v in ([1, 1, 1], [-1, 1, -1], [1, -1, -1], [-1, -1, 1])]
WORST_MG = {4: 78.0, 5: 41.0, 6: 14.0, 7: 8.6, 8: 5.6, 9: 3.9, 10: 3.1}


class Script:
    """Writes events as the program would."""

    def __init__(self, source="port", name="MPU6050 logger on /dev/ttyUSB0", gravity="latitude"):
        self.t = 0.0
        self.events = []
        self.poses = {}
        self.number = 0
        self.redo = set()
        self.up = unit([0.03, -0.02, 1.0])
        self.source = source
        self.add(
            "session", source=source, name=name, folder="session-2026-11-23T0325", tool="gravical 0.1.0",
            gravity_mps2=9.80665, gravity_source=gravity,
        )

    def add(self, name, /, **fields):
        self.events.append({"v": 1, "type": name, "t_s": round(self.t, 3), "text": "", **fields})
        return self

    def faces_done(self):
        return {f for f, _ in self.poses.values() if f}

    def tiles(self, state=None, face=None):
        out = {}
        for f in FACES:
            out[f] = "redo" if f in self.redo else "done" if f in self.faces_done() else "to_do"
        if face and state in ("settle", "capture") and out[face] != "done":
            out[face] = {"settle": "hold_still", "capture": "capturing"}[state]
        return out

    def status(self, state, sentence, hint=None, up=None, ring=0.0, still=True, noise=6.3, norm=1.004,
               welcome="face", limit=19.2):
        if up is not None:
            self.up = unit(up)
        face, tilt = nearest(self.up)
        return self.add(
            "status", state=state, text=sentences(sentence), hint=hint and sentences(hint), up=self.up, attitude=shortest(self.up),
            norm_g=norm, noise_mg=noise, limit_mg=limit, still=still, ring=ring, face=face,
            tilt_deg=round(tilt, 2), welcome=welcome, rate_hz=100.2, temperature_c=24.9,
            tiles=self.tiles(state, face if tilt < 25 else None),
        )

    def signal(self, seconds, moving, sentence="Turn the sensor to a face that is to do", towards=None):
        """Statuses that fill the strip chart: a turn or a hold."""
        begin = self.up
        for i in range(int(seconds * 10)):
            self.t += 0.1
            k = (i + 1) / (seconds * 10)
            wobble = math.sin(9.0 * k + self.t) * math.sin(3.1 * k)
            up = unit([a + k * (b - a) + 1e-3 for a, b in zip(begin, towards)]) if towards else None
            self.status(
                "wait" if moving else "settle", sentence, up=up, still=not moving,
                noise=84 * abs(wobble) + 20 if moving else 5.5 + 1.5 * math.sin(13 * self.t),
                norm=1.0 + 0.3 * wobble if moving else 1.004 + 0.003 * math.sin(17 * self.t + self.up[0]),
            )
        return self

    def identified(self):
        self.t = 1.0
        return self.add(
            "identified", rate_hz=100.2, unit="counts", gyro_unit="counts",
            text="100.2 Hz, 8 columns, counts, with gyroscope. Raw counts at ±2 g, from the magnitude of gravity.",
        )

    def floor(self):
        self.t = 4.0
        self.add("floor", noise_mg=[3.1, 3.0, 4.7], limit_mg=19.2,
                 text="Noise at rest 3.1, 3.0, 4.7 mg; above 19 mg it counts as moving.")
        return self.next()

    def next(self):
        """What is wanted next."""
        left = [f for f in ORDER if f not in self.faces_done()]
        if left:
            return self.add("next_pose", kind="face", faces=left, up=None, hint=None)
        n = len(self.poses)
        if WORST_MG.get(n, 2.0) <= 5:
            return self.add("next_pose", kind="none", faces=[], up=None, hint=None)
        up = FREE[(n - 6) % len(FREE)]
        return self.add("next_pose", kind="free", faces=[], up=up,
                        hint="x up, tilted 55°, y raised, z raised")

    def candidate(self, up):
        self.up = unit(up)
        return self.add("pose_candidate")

    def accept(self, up, note=None):
        self.up = unit(up)
        face, tilt = nearest(self.up)
        self.number += 1
        face = face if tilt < 25 else None
        self.poses[self.number] = (face, self.up)
        self.redo.discard(face)
        self.add(
            "pose_accepted", pose=self.number, face=face, up=self.up, tilt_deg=round(tilt, 2),
            mean=[16384.0 * c for c in self.up], norm_mps2=9.8312,
            noise_mg=3.14, temperature_c=24.9, seconds=3.0, lines=[611, 911],
            text=sentences(f"{face or 'free pose'} is done".replace("-", "−"), "‖a‖ 9.831 m/s², noise 3.1 mg", note),
        )
        return self.fit()

    def fit(self, suspect=None, grade=None):
        n = len(self.poses)
        if n >= 4:
            worst = WORST_MG.get(n, 2.6)
            grade = grade or ("not-verifiable" if n < 7 else "good" if worst <= 5 else "fair")
            self.add(
                "fit", bias_mg=[12.13, -8.31, 30.22],
                worst_mg=worst, leave_one_out_mg=None if n < 7 else 2.4, undetected_mg=None if n < 7 else round(130.0 / (n - 6) ** 3, 2),
                grade=grade,
                poses=n, suspect=suspect,
            )
            if n >= 6:
                self.verdict(grade)
        return self.next()

    def verdict(self, grade, final=False):
        said = {
            "good": "Good: error of ‖a‖ at most 3.9 mg (95 %). Finish, or add poses.",
            "fair": "Fair: error of ‖a‖ at most 8.6 mg (95 %). Two more free poses make it good.",
            "poor": "Poor: pose 3 (−x) contradicts the others by 41 mg. Record −x again.",
            "not-verifiable": "Six faces alone verify nothing: hold one more pose in any other direction.",
        }[grade]
        if final:
            said = said.replace(" Finish, or add poses.", "")
        return self.add("verdict", grade=grade, final=final, text=said, reasons=[
            "error of ‖a‖ at most 3.9 mg (95 %) in the worst direction (x up, y raised)",
            "an error of 6.1 mg of one pose would have shown",
            "leave-one-out error of ‖a‖: 2.4 mg rms over 9 poses",
        ])

    def hold(self, face_or_up, note=None):
        """A turn and a hold that is accepted."""
        up = direction(face_or_up) if isinstance(face_or_up, str) else face_or_up
        up = unit([a + b for a, b in zip(up, (0.012, -0.008, 0.01))])
        self.signal(3, True, towards=up)
        self.candidate(up)
        self.signal(3, False)
        return self.accept(up, note)

    def begun(self, faces=0, free=0):
        self.identified().floor()
        for face in ORDER[:faces]:
            self.hold(face)
        for i in range(free):
            self.hold(FREE[i])
        return self

    def ended(self, grade, final=True):
        self.verdict(grade, final=final)
        if self.source == "simulate":
            rows = [("bias x", "mg", 12.31, 12.13, 0.84), ("bias y", "mg", -8.02, -8.31, 0.82),
                    ("bias z", "mg", 31.90, 30.22, 1.04), ("scale x", "%", 1.19, 1.21, 0.06),
                    ("scale y", "%", -0.45, -0.43, 0.06), ("scale z", "%", 0.79, 0.80, 0.07),
                    ("misalignment xy", "°", 0.41, 0.40, 0.05)]
            self.add("truth", norm_error_mg=0.9, before_mg=32.0, rows=[
                dict(zip(("name", "unit", "truth", "found", "plus_minus"), r)) for r in rows])
        self.add("saved", file="calibration.json", folder="session-2026-11-23T0325", next=[
            "gravical apply calibration.json RECORDING.csv -o calibrated.csv",
            "gravical export calibration.json --to arduino"])
        return self.add("end", reason="finished", poses=len(self.poses), resume=None,
                        text=f"Done and saved: {len(self.poses)} poses, verdict {grade}.")


REJECTIONS = {
    "moved": ("it moved after 1.2 s: 84 mg, limit 19 mg", "lay it down, take the hand off, and wait"),
    "duplicate": ("+x is recorded already, 2° from this pose", "turn it to a face that is to do, or press R to record +x again"),
    "between-faces": ("34° from +x, the nearest face", "lay it flat on a side of the case, or hold it against a box"),
    "clipped": ("x reads the end of its range in 12 of 300 samples", "set a wider range (±4 g) and begin again"),
    "units": ("‖a‖ is 0.51 of gravity while the other poses read 1.00", "has the range changed? send the settings again"),
    "sign": ("−x reads +g like +x did", "turn it over: the side that was up goes down"),
    "frozen": ("y has not changed for 3 s while x and z did", "check the wiring, then unplug and plug it in"),
    "gaps": ("41 of 300 samples are missing", "close other programs that use the port"),
    "temperature": ("the sensor is 3.4 °C warmer than at the first pose", "let it warm up for 5 minutes and begin again"),
    "scale": ("‖a‖ is 12.4 m/s², 26 % from gravity", "is it a multiple of gravity? see the unit above"),
}


def rejected(reason):
    s = Script().begun(faces=2)
    s.signal(3, True, towards=direction("-x"))
    s.candidate(direction("-x"))
    s.signal(1.2, False)
    message, remedy = REJECTIONS[reason]
    s.add("pose_rejected", reason=reason, text=sentences(message, remedy))
    return s.status("wait", "Put −x up and hold it still", still=False, noise=84.0).events


def simulated():
    return Script("simulate", "simulated MPU6050", "standard")


def ports(count, tried=None, message="more than one port may be the board: /dev/ttyACM0, /dev/ttyUSB0", remedy="choose the one of your board", flash=()):
    port = lambda name, device, usb, serial, *holders: {"name": name, "device": device, "usb": usb, "serial": serial, "board": bool(usb), "open_in": list(holders)}
    all_ports = [port("/dev/ttyACM0", "Arduino Uno", "2341:0043", "95437313834351A0C1D2"),
                 port("/dev/ttyUSB0", "CH340 bridge, as on many Uno and Nano clones", "1a86:7523", None, "minicom (4711)"),
                 port("/dev/ttyS0", None, None, None)]
    return [{"v": 1, "t_s": 0.0, "type": "ports", "ports": all_ports[:count], "tried": tried, "text": sentences(message, remedy),
             "flash": list(flash), "simulate": True}]


def scenes():
    """Name → events."""
    out = {"connect": []}
    out["ports"] = ports(3)
    out["ports-none"] = ports(0, message="no board is plugged in: there is no USB serial port",
                              remedy="plug it in: it is opened when it is there. Some USB cables only charge; any other port can be chosen")
    out["ports-busy"] = ports(2, "/dev/ttyUSB0", "/dev/ttyUSB0: minicom (4711) has this port open", "close the serial monitor of the Arduino IDE, or another logger")
    out["connecting"] = [{"v": 1, "t_s": 0.0, "type": "connecting", "name": "/dev/ttyUSB0",
                         "text": "/dev/ttyUSB0 is open: waiting for its first rows."}]
    out["ports-silent"] = ports(2, "/dev/ttyUSB0", "/dev/ttyUSB0 is open, but nothing arrives: does the board have a sketch?",
                                "flash a sketch, ours or any that prints numbers; choose another port; or try the simulated sensor",
                                ["arduino-cli core install arduino:avr", "arduino-cli compile --fqbn arduino:avr:uno firmware/mpu6050_logger",
                                 "arduino-cli upload --fqbn arduino:avr:uno -p /dev/ttyUSB0 firmware/mpu6050_logger"])
    out["full"] = [{"v": 1, "t_s": 0.0, "type": "full"}]
    out["session"] = Script().events
    out["identify"] = Script().status("identify", "Reading: one second of samples tells rate and unit", ring=0.4, limit=None).events
    out["floor"] = Script().identified().status("floor", "Put the sensor on the table and take your hands off: 1.6 s", ring=0.45, limit=None).events
    for face in FACES:
        s = Script().begun()
        s.signal(2, True, towards=direction(face))
        out[f"wait{face}"] = s.status("wait", f"Hold it still: {face.replace('-', '−')} is up", up=direction(face), still=False, noise=44).events
    out["hint"] = (Script().begun(faces=1).signal(6, True, towards=direction("-y"))
                   .status("wait", "Put any face up that is to do, and hold it still", "still moving: 84 mg, limit 19 mg", up=unit([.2, -.9, .3]), still=False, noise=84, norm=1.03).events)
    out["between"] = (Script().begun(faces=3)
                      .status("wait", "Between two faces: lay it flat on one of them", "34° from +y, at most 25° count as a face", up=unit([.5, .74, .3]), welcome="between").events)
    s = Script().begun(faces=2).signal(3, True, towards=direction("-x"))
    out["settle"] = s.status("settle", "−x up: hold still", up=unit([-1, .04, .06]), ring=0.6).events
    s = Script().begun(faces=2).signal(3, True, towards=direction("-x")).candidate(direction("-x")).signal(1.8, False)
    out["capture"] = s.status("capture", "−x up: hold still, 1.2 s to go", up=unit([-1, .04, .06]), ring=0.6).events
    out["accept"] = Script().begun(faces=3).status("wait", "Put any face up that is to do: +y, −y or −z").events
    out["noted"] = (Script().begun(faces=2).hold(unit([-1, .2, .15]), note="14° off the face: the fit estimates it, a flatter pose is better")
                    .status("wait", "Put any face up that is to do: +y, −y or −z").events)
    for reason in REJECTIONS:
        out[f"rejected-{reason}"] = rejected(reason)
    s = Script().begun(faces=3)
    s.poses.pop(3)
    out["undone"] = s.add("pose_undone", pose=3, face="-x", why="undo", text="Pose 3 (−x) no longer counts. The others are untouched.").next().status("wait", "Put any face up that is to do").events
    s = Script().begun(faces=4)
    s.poses.pop(2)
    s.redo.add("+x")
    out["redo"] = s.add("pose_undone", pose=2, face="+x", why="redo", text="Pose 3 (+x) no longer counts. Put it up again.").next().status("wait", "Put +x up again and hold it still").events
    out["temperature"] = (Script().begun(faces=2)
                          .add("warning", kind="temperature", text="The sensor has warmed by 1.4 °C since the first pose; let it run for some minutes first for the best result.")
                          .status("wait", "Put any face up that is to do").events)
    out["gravity"] = Script(gravity="standard").begun(faces=1).status("wait", "Put any face up that is to do").events
    out["rough"] = Script().begun(faces=5).status("wait", "Put −z up: the last face").events
    out["free"] = (Script().begun(faces=6).signal(1, True, towards=unit([.8, .5, .2]))
                   .status("wait", "Now hold it as drawn: x up, tilted 55°, y raised, z raised", up=unit([.8, .5, .2]), welcome="free").events)
    out["free-capture"] = (Script().begun(faces=6, free=1).signal(1, True, towards=FREE[1]).candidate(FREE[1])
                           .status("capture", "Free pose: hold still, 2.1 s to go", up=FREE[1], ring=0.3, welcome="free").events)
    out["good"] = Script().begun(faces=6, free=3).status("wait", "Good: error of ‖a‖ at most 3.9 mg. Press Enter to finish, or add poses").events
    s = Script().begun(faces=6, free=2)
    s.events = [e for e in s.events if e["type"] != "verdict"]
    s.redo.add("-x")
    out["suspect"] = s.fit(suspect=3, grade="poor").status("wait", "−x contradicts the other poses by 41 mg: press R and record it again").events
    out["lost"] = (Script().begun(faces=4)
                   .add("lost", why="unplugged", text="Unplugged. 4 of 6 faces are safe. Plug it back in.", poses=4)
                   .status("lost", "Unplugged. 4 of 6 faces are safe. Plug it back in.").events)
    out["resumed"] = (Script().begun(faces=4)
                      .add("lost", why="unplugged", text="Unplugged. 4 of 6 faces are safe. Plug it back in.", poses=4)
                      .add("resumed", text="The board is back; 4 poses are kept.", poses=4)
                      .status("wait", "Put any face up that is to do: −y or −z").events)
    for grade, free in (("good", 3), ("fair", 1), ("poor", 2), ("not-verifiable", 0)):
        out[f"end-{grade}"] = Script().begun(faces=6, free=free).ended(grade).events
    out["interrupted"] = (Script().begun(faces=4).add("end", reason="interrupted", poses=4,
                          resume="gravical live --resume session-2026-11-23T0325", text="Stopped by Ctrl-C; 4 poses are kept.").events)
    out["simulate"] = simulated().begun(faces=2).status("wait", "Put any face up that is to do, and hold it still", up=unit([.4, -.2, .9])).events
    out["simulate-free"] = (simulated().begun(faces=6, free=1)
                            .status("wait", "Now hold it as drawn: x up, tilted 55°, y raised, z raised", up=unit([-.3, .8, -.2]), welcome="free").events)
    out["simulate-end"] = simulated().begun(faces=6, free=3).ended("good").events
    hostile = "<img src=x onerror=alert(1)>"
    s = Script(name=hostile)
    s.identified().floor()
    s.add("warning", kind="other", text=hostile)
    out["hostile"] = s.status("wait", hostile, hostile).events
    return out
