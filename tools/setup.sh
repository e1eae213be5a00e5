#!/usr/bin/env bash
# SPDX-License-Identifier: GPL-3.0-or-later
# Make this checkout ready: Debian's packages where missing, .venv, the simulator's native part.
# `make demo` runs it when something it reads has changed; with TESTS=1, as `make test` and
# `make setup` run it, it adds what only the tests need; with PEERS=1, as `make peers` runs it, what
# only `make bench` compares with.
set -euo pipefail
cd "$(dirname "$0")/.."

LOG=.venv/setup.log

# What the build, the simulator and `upload` need, and a file or command by which each is known.
PACKAGES=(
    gcc-avr:avr-gcc avr-libc:/usr/lib/avr/include/avr/io.h binutils-avr:avr-objcopy
    libsimavr-dev:/usr/include/simavr/sim_avr.h
    gcc:cc libc6-dev:/usr/include/stdio.h
    avrdude:avrdude
)
EXTRAS=

if [ "${CI:-}" = true ] || [ -n "${TESTS:-}${LINUXCNC:-}${EVIDENCE:-}" ]; then
    EXTRAS=dev
    PACKAGES+=(cppcheck:cppcheck chromium:chromium)
    PACKAGES+=(arduino-core-avr:/usr/share/arduino/hardware/arduino/avr/boards.txt)
fi

# LinuxCNC is large, and only one interface needs it: it is installed in CI, and where one asks
# for it (make setup LINUXCNC=1); elsewhere its tests are skipped. Xvfb is the panel's screen.
if [ "${CI:-}" = true ] || [ -n "${LINUXCNC:-}" ]; then
    PACKAGES+=(linuxcnc-uspace:halrun xvfb:Xvfb)
fi

# What only the whole evidence needs (make setup EVIDENCE=1, and CI): other simulators of the
# processor, a second compiler, OctoPrint, and Frama-C.
if [ "${CI:-}" = true ] || [ -n "${EVIDENCE:-}" ]; then
    EXTRAS=dev,evidence
    PACKAGES+=(qemu-system-misc:qemu-system-avr nodejs:node npm:npm frama-c-base:frama-c)
fi

if [ -n "${PEERS:-}" ]; then
    PACKAGES+=(nodejs:node npm:npm)
fi

say() { printf '%s\n' "$*"; }

stop() {
    printf '%s\n' "$*" >&2
    exit 3
}

# Run a command whose words matter only when it fails.
quietly() {
    if ! "$@" >>"$LOG" 2>&1; then
        tail -n 20 "$LOG" >&2
        stop "failed: $* (all of it is in $LOG)"
    fi
}

missing_packages() {
    local pair
    for pair in "${PACKAGES[@]}"; do
        if ! [ -e "${pair#*:}" ] && ! command -v "${pair#*:}" >/dev/null; then
            say "${pair%%:*}"
        fi
    done
    python3 -c 'import ensurepip' 2>/dev/null || say python3-venv
    python3 - <<'CHECK' || say python3-dev
import pathlib, sys, sysconfig
sys.exit(not pathlib.Path(sysconfig.get_paths()["include"], "Python.h").is_file())
CHECK
}

install_packages() {
    local packages=("$@") sudo=()
    command -v apt-get >/dev/null ||
        stop "missing: ${packages[*]} (Debian's names): install what they hold, then try again"
    if [ "$(id -u)" != 0 ]; then
        command -v sudo >/dev/null || stop "missing, as root: apt-get install ${packages[*]}"
        sudo=(sudo)
    fi
    say "installing Debian packages: ${packages[*]}"
    local install=("${sudo[@]}" env DEBIAN_FRONTEND=noninteractive apt-get install -qq --no-install-recommends "${packages[@]}")
    local status=0
    "${install[@]}" >>"$LOG" 2>&1 || status=$?
    if [ $status != 0 ] && [ $status != 100 ]; then # apt-get's own errors are 100
        tail -n 3 "$LOG" >&2
        stop "not installed, as root was not granted; as root: apt-get install ${packages[*]}"
    fi
    if [ $status = 100 ]; then
        say "  (its lists of packages may be old: updating them first)"
        quietly "${sudo[@]}" apt-get update -qq
        quietly "${install[@]}"
    fi
}

command -v python3 >/dev/null || stop "python3 is missing: sudo apt-get install python3"
python3 -c 'import sys; sys.exit(sys.version_info < (3, 11))' ||
    stop "$(python3 --version) is too old: 3.11 or later is needed"

mkdir -p .venv
: >"$LOG"
mapfile -t missing < <(missing_packages)
[ ${#missing[@]} = 0 ] || install_packages "${missing[@]}"

if ! [ -x .venv/bin/python ] || ! .venv/bin/python -c 'import pip' 2>/dev/null; then
    say "creating .venv"
    quietly python3 -m venv .venv
fi
say "installing the Python packages into .venv"
quietly .venv/bin/python -m pip install --quiet --disable-pip-version-check --no-input --editable ".${EXTRAS:+[campaign,$EXTRAS]}"

if [ -n "$EXTRAS" ]; then
    # Printrun's host core needs pyserial alone, which is among ours; the rest of Printrun asks for
    # graphics (wxPython, for which there is no wheel on Linux), and nothing of it is used.
    quietly .venv/bin/python -m pip install --quiet --disable-pip-version-check --no-input --no-deps printrun==2.2.0
fi

if { [ "$EXTRAS" = dev,evidence ] || [ -n "${PEERS:-}" ]; } && ! grep -qs '"version": "0.21.0"' build/judges/node_modules/avr8js/package.json; then
    say "installing avr8js into build/judges"
    quietly npm install --silent --no-audit --no-fund --prefix build/judges avr8js@0.21.0
fi

# OctoPrint asks for other versions than ours of what it needs: it has an environment of its own.
OCTOPRINT=build/judges/octoprint
if [ "$EXTRAS" = dev,evidence ] && ! compgen -G "$OCTOPRINT/lib/*/site-packages/?cto?rint-1.11.8.dist-info" >/dev/null; then
    say "installing OctoPrint into $OCTOPRINT"
    quietly python3 -m venv --clear "$OCTOPRINT"
    quietly "$OCTOPRINT/bin/pip" install --quiet --disable-pip-version-check --no-input OctoPrint==1.11.8
fi

# ESPHome, too, has an environment of its own.
ESPHOME=build/judges/esphome
if [ -n "${PEERS:-}" ] && ! compgen -G "$ESPHOME/lib/*/site-packages/esphome-2026.6.5.dist-info" >/dev/null; then
    say "installing ESPHome into $ESPHOME"
    quietly python3 -m venv --clear "$ESPHOME"
    quietly "$ESPHOME/bin/pip" install --quiet --disable-pip-version-check --no-input esphome==2026.6.5
fi

# The type checker knows nothing of an editable install: the packages under their names.
mkdir -p .typing/heatwright
for package in cli generator sim spec templates; do
    ln -sfn "../../$package" ".typing/heatwright/$package"
done

say "compiling the simulator's native part"
quietly .venv/bin/python -m heatwright.sim.native.build

# Python keeps compiled modules and templates from their first use, unless it is told not to.
say "compiling modules and templates"
quietly env -u PYTHONDONTWRITEBYTECODE .venv/bin/python -m compileall -q cli generator sim spec templates
quietly env -u PYTHONDONTWRITEBYTECODE .venv/bin/python -c '
from heatwright.generator import plan_firmware, render
from heatwright.spec import load
for example in ("chamber", "oven"):
    render(plan_firmware(load(f"spec/examples/{example}.yaml")))'
