"""LinuxCNC's HAL for a test (halrun as an ordinary user, halcmd beside it), and a simulated slave.

HAL is one for the whole machine (its shared memory has fixed keys), so sessions wait for each
other, and each leaves nothing behind.

The slave has the register map of the fabricator behind a pseudo-terminal: no firmware, no plant.
What it answers the Modbus tests' oracle says, which was written from the documents, and keeps the
rules that the master side leans on: a loop is switched on only after it was off, and never while a
fault is latched; a fault is acknowledged by a change from 0 to 1.
"""

import os
import pwd
import select
import shutil
import subprocess
import tempfile
import threading
import time
import tty
from collections.abc import Iterator, Mapping
from contextlib import contextmanager
from pathlib import Path

import pytest
from filelock import FileLock
from rig.firmware import controller_of
from rig.live import wait_for
from rig.modbus_oracle import Oracle

from heatwright.sim.interfaces.modbus_rtu.frames import EXCEPTION, framed

LOCK = Path(tempfile.gettempdir()) / "heatwright-hal.lock"
TOOLS = ("halrun", "halcmd", "mb2hal", "pyvcp")
USER = "nobody"
"""HAL's real-time part refuses root; where the tests run as root, HAL runs as this one."""
WAIT_S = 30.0
POLL_S = 0.05


@contextmanager
def folder() -> Iterator[Path]:
    """A folder that the ordinary user may enter and write to: pytest's are root's own."""
    place = Path(tempfile.mkdtemp(prefix="heatwright-hal-"))
    place.chmod(0o755)
    try:
        yield place
    finally:
        shutil.rmtree(place, ignore_errors=True)


def linuxcnc_files(files: Mapping[str, str]) -> dict[str, str]:
    found = {Path(path): text for path, text in files.items()}
    return {path.name: text for path, text in found.items() if path.parts[0] == "linuxcnc"}


class Hal:
    """One session; a context manager. `folder` holds the HAL files and becomes the user's home."""

    def __init__(self, place: Path, script: str, display: str | None = None) -> None:
        self._place, self._script, self._log = place, script, place / "hal.log"
        self._environment = {"HOME": str(place), "PATH": os.environ["PATH"], "LANG": "C.UTF-8"}
        if display is not None:
            self._environment["DISPLAY"] = display
        self._lock = FileLock(LOCK, mode=0o666)

    def __enter__(self) -> "Hal":
        """Skip without LinuxCNC's HAL; in CI a test that is skipped for the want of it fails."""
        absent = [tool for tool in TOOLS if shutil.which(tool) is None]
        if absent:
            pytest.skip(f"LinuxCNC is not installed ({', '.join(absent)}): make setup LINUXCNC=1")
        self._lock.acquire(timeout=300)
        try:
            self._start()
        except BaseException:
            self._stop()
            raise
        return self

    def __exit__(self, *error: object) -> None:
        self._stop()

    def command(self, *words: str) -> str:
        done = self._run("halcmd", *words)
        assert done.returncode == 0, f"halcmd {' '.join(words)}: {done.stderr}\n{self.log()}"
        return done.stdout.strip()

    def signal(self, name: str, verb: str = "gets") -> float:
        text = self.command(verb, name)
        return float({"TRUE": "1", "FALSE": "0"}.get(text, text))

    def set_signal(self, name: str, value: float) -> None:
        self.command("sets", name, f"{value:g}")

    def press(self, name: str) -> None:
        self.set_signal(name, 1)
        time.sleep(0.1)
        self.set_signal(name, 0)

    def wait(self, name: str, value: float, within_s: float = WAIT_S) -> None:
        def told() -> str:
            return f"{name}\n{self.command('show', 'sig')}\n{self.log()}"

        wait_for(lambda: self.signal(name) == value, told, within_s, POLL_S)

    def log(self) -> str:
        return self._log.read_text(errors="replace")[-4000:]

    def _start(self) -> None:
        self._user: list[str] = []
        if os.geteuid() == 0:
            user = pwd.getpwnam(USER)
            ids = f"--reuid={user.pw_uid}", f"--regid={user.pw_gid}"
            self._user = ["setpriv", *ids, "--clear-groups"]
            for path in (self._place, *self._place.rglob("*")):
                os.chown(path, user.pw_uid, user.pw_gid, follow_symlinks=False)
        with self._log.open("w") as log:
            self._halrun = subprocess.Popen(
                [*self._user, "halrun", "-I", self._script], cwd=self._place,
                env=self._environment, stdin=subprocess.PIPE, stdout=log, stderr=log,
                start_new_session=True,
            )  # fmt: skip
        # The prompt comes when the whole script has been done.
        assert self._halrun.stdin is not None
        self._halrun.stdin.write(b"print ready\n")
        self._halrun.stdin.flush()
        end = time.monotonic() + WAIT_S
        while not any(line.endswith("ready") for line in self.log().splitlines()):
            assert self._halrun.poll() is None, self.log()
            assert time.monotonic() < end, self.log()
            time.sleep(POLL_S)

    def _stop(self) -> None:
        try:
            self._halrun.communicate(b"exit\n", timeout=WAIT_S)
        except (BrokenPipeError, subprocess.TimeoutExpired):
            self._halrun.kill()
            self._halrun.wait()
        finally:
            self._run("halrun", "-U")
            self._lock.release()

    def _run(self, *words: str) -> "subprocess.CompletedProcess[str]":
        return subprocess.run(
            [*self._user, *words], cwd=self._place, env=self._environment,
            capture_output=True, text=True, check=False, timeout=WAIT_S,
        )  # fmt: skip


FABRICATOR = "fabricator"
REQUEST_BYTES = 8
"""Length of everything that mb2hal sends: it reads, and writes one value at a time."""
BUSY = 6
WRITES = (5, 6)
WORK, HEAT, COOL, WARM = 1, 2, 4, 8
DEAD_BAND_K = 2


class MadeUpBoard:
    def __init__(self) -> None:
        self.oracle = Oracle(controller_of(FABRICATOR))
        self.nozzle = self.oracle.loops["nozzle"]
        self.celsius, self.duty_percent, self.amperes = 21.5, 12.3, 1.78
        self.has_measured, self.deaf = True, False
        self.slow_s = 0.0
        """How long after it was switched on it reports WORK."""
        self.refused: set[int] = set()
        """Values of writes that were answered with an exception."""
        self._end, self._master = os.openpty()
        tty.setraw(self._master)
        self.port = os.ttyname(self._master)
        os.chmod(self.port, 0o666)  # noqa: PTH101, S103 - mb2hal runs as another user
        self._over = threading.Event()
        self._thread = threading.Thread(target=self._serve)
        self.restart()
        self._enabled_at = self._start

    def __enter__(self) -> "MadeUpBoard":
        self._thread.start()
        return self

    def __exit__(self, *error: object) -> None:
        self._over.set()
        self._thread.join(10)
        os.close(self._end)
        os.close(self._master)

    @property
    def enabled(self) -> bool:
        return self.nozzle.enabled

    @property
    def setpoint_celsius(self) -> float:
        return round(self.nozzle.setpoint, 4)

    def restart(self) -> None:
        self._start = time.monotonic()
        self.nozzle.enabled = self.nozzle.released = False

    def trip(self, code: int, celsius: float) -> None:
        self.oracle.fault, self.oracle.world["fault_temperature"] = code, celsius
        self.nozzle.enabled = self.nozzle.released = False

    def turn_digest(self, bits: int) -> None:
        self.oracle.digest = f"{int(self.oracle.digest, 16) ^ bits:08x}"

    def _serve(self) -> None:
        data = b""
        while not self._over.is_set():
            ready, _, _ = select.select([self._end], [], [], 0.1)
            data = data + os.read(self._end, 256) if ready else b""
            if len(data) >= REQUEST_BYTES:
                os.write(self._end, self._answer(data))
                data = b""

    def _answer(self, request: bytes) -> bytes:
        if self.deaf:
            return framed(request[0], bytes([request[1] | EXCEPTION, BUSY]))
        was_enabled = self.enabled
        self.oracle.world |= self._world()
        answer = self.oracle.hear(request)
        if self.enabled and not was_enabled:
            self._enabled_at = time.monotonic()
        if request[1] in WRITES and answer[1:2] == bytes([request[1] | EXCEPTION]):
            self.refused.add(int.from_bytes(request[4:6], "big"))
        return answer

    def _world(self) -> dict[str, float]:
        works = self.enabled and time.monotonic() - self._enabled_at >= self.slow_s
        above_k = self.celsius - self.nozzle.setpoint
        state = HEAT if above_k < -DEAD_BAND_K else COOL if above_k > DEAD_BAND_K else WARM
        return {
            "uptime": int(time.monotonic() - self._start),
            "nozzle.has_reading": self.has_measured, "nozzle.temperature": self.celsius,
            "nozzle.duty": self.duty_percent, "nozzle.setpoint_in_force": self.nozzle.setpoint,
            "nozzle.current": self.amperes, "nozzle.states": (WORK | state) * works,
        }  # fmt: skip
