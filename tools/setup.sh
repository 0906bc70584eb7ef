#!/bin/sh
# Sets up what a run needs (setup.sh run) or what the tests need beside it (setup.sh test), in .venv, and leaves a stamp there.
# System packages come by apt where that is allowed (root, or sudo without a password); otherwise a message says what to install.
set -eu
cd "$(dirname "$0")/.."
what=${1:?run or test}
venv=.venv

say() { printf 'setup: %s\n' "$*" >&2; }
die() { say "$*"; exit 1; }

as_root=
if [ "$(id -u)" -ne 0 ]; then
    as_root='sudo -n'
fi
may_apt() { command -v apt-get >/dev/null 2>&1 && { [ -z "$as_root" ] || $as_root true 2>/dev/null; }; }
# A fresh image has no package lists: the first try may fail for that alone.
apt_install() {
    may_apt || return 1
    say "apt-get install $*"
    { $as_root env DEBIAN_FRONTEND=noninteractive apt-get install -y --no-install-recommends "$@" ||
        { $as_root apt-get update && $as_root env DEBIAN_FRONTEND=noninteractive apt-get install -y --no-install-recommends "$@"; }
    } </dev/null >&2
}

setup_venv() {
    command -v python3 >/dev/null 2>&1 || apt_install python3 || die "python3 is missing: apt-get install python3 python3-venv"
    if ! "$venv/bin/python3" -m pip --version >/dev/null 2>&1; then
        python3 -m venv --clear "$venv" >/dev/null 2>&1 || {
            apt_install python3-venv && python3 -m venv --clear "$venv"
        } || die "python3 cannot make a virtual environment: apt-get install python3-venv"
    fi
}

pip_install() { "$venv/bin/python3" -m pip install --quiet --disable-pip-version-check "$@" </dev/null >&2; }

setup_run() {
    setup_venv
    pip_install -r tools/requirements-run.txt
    pip_install --only-binary :all: -r tools/requirements-optional.txt ||
        say "there is no pytetwild for this Python: parts that gmsh cannot fill will be refused"
    # The wheel's own script starts whatever `python` is on the PATH, which outside the environment is another one or none.
    python=$(pwd)/$venv/bin/python3
    script=$venv/bin/gmsh
    case $python in
    *[[:space:]]*) # The first line of a script cannot name such a path.
        printf '#!/bin/sh\nexec "%s" -c "import sys, gmsh; gmsh.initialize(sys.argv, run=True); gmsh.finalize()" "$@"\n' "$python" >"$script" ;;
    *) sed -i "1s|.*|#!$python|" "$script" ;;
    esac
    chmod +x "$script"
    libraries='libglu1-mesa libgl1 libxrender1 libxcursor1 libxft2 libxinerama1 libgomp1'
    if ! "$venv/bin/gmsh" --version </dev/null >/dev/null 2>&1; then
        # shellcheck disable=SC2086
        apt_install $libraries || die "gmsh lacks system libraries and apt may not be used here: apt-get install $libraries"
        "$venv/bin/gmsh" --version </dev/null >/dev/null 2>"$venv/gmsh-complaint" ||
            die "gmsh does not start: $(tail -n 1 "$venv/gmsh-complaint")"
    fi
}

setup_test() {
    pip_install -r tests/python/requirements.txt
    if ! command -v ccx >/dev/null 2>&1; then
        apt_install calculix-ccx || say "CalculiX (ccx) is missing and apt may not be used here: its tests will be skipped (apt-get install calculix-ccx)"
    fi
}

case $what in
run) setup_run ;;
test) setup_test ;;
*) die "no such set-up: $what" ;;
esac
touch "$venv/.$what-ready"
