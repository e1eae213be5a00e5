"""LinuxCNC's HAL for a test: halrun as an ordinary user, and halcmd beside it.

HAL is one for the whole machine (its shared memory has fixed keys), so sessions wait for each
other, and each leaves nothing behind.
"""

import os
import pwd
import shutil
import subprocess
import tempfile
import time
from collections.abc import Iterator, Mapping
from contextlib import contextmanager
from pathlib import Path

from filelock import FileLock

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
    """Return what is generated for LinuxCNC, by its name in a configuration's folder."""
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
        """What halcmd answers; an error of its own fails the test."""
        done = self._run("halcmd", *words)
        assert done.returncode == 0, f"halcmd {' '.join(words)}: {done.stderr}\n{self.log()}"
        return done.stdout.strip()

    def pin(self, name: str) -> float:
        return self._value("getp", name)

    def signal(self, name: str) -> float:
        return self._value("gets", name)

    def _value(self, *words: str) -> float:
        text = self.command(*words)
        return float({"TRUE": "1", "FALSE": "0"}.get(text, text))

    def set_signal(self, name: str, value: float) -> None:
        self.command("sets", name, f"{value:g}")

    def press(self, name: str) -> None:
        """Make a signal go on and off, as a button does."""
        self.set_signal(name, 1)
        time.sleep(0.1)
        self.set_signal(name, 0)

    def wait(self, name: str, value: float, within_s: float = WAIT_S) -> None:
        """Wait until a signal has a value."""
        end = time.monotonic() + within_s
        while self.signal(name) != value:
            assert time.monotonic() < end, f"{name}\n{self.command('show', 'sig')}\n{self.log()}"
            time.sleep(POLL_S)

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
