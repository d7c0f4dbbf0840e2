# shellcheck shell=bash
# What scripts/run, scripts/test and .ci/run share: install what is missing, build a preset, count cores.
# Sourced, never run. All progress goes to stderr; messages read `problem (why). suggestion?`.

root=$(cd "$(dirname "${BASH_SOURCE[0]}")/.." && pwd)
export CMAKE_BUILD_PARALLEL_LEVEL=${CMAKE_BUILD_PARALLEL_LEVEL:-$(nproc)}

# Open MPI refuses root and more ranks than cores, which is what containers and small machines are.
export OMPI_ALLOW_RUN_AS_ROOT=1 OMPI_ALLOW_RUN_AS_ROOT_CONFIRM=1 OMPI_MCA_rmaps_base_oversubscribe=1

say() { echo "$(basename "$0"): $*" >&2; }

# fail CODE MESSAGE: exit codes are those of the program (docs/guide/results.md): 1 internal, 2 input, 4 the machine.
fail() {
    say "$2"
    exit "$1"
}

installed() { [[ $(dpkg-query -W -f='${db:Status-Status}' "$1" 2>/dev/null) == installed ]]; }

# missing_packages GROUP...: the packages of these groups that are neither installed nor replaced by a command.
missing_packages() {
    local group package command
    while read -r group package command; do
        [[ " $* " == *" $group "* ]] || continue
        installed "$package" && continue
        [[ $command != - ]] && command -v "$command" >/dev/null && continue
        echo "$package"
    done <"$root/scripts/packages.txt" | sort -u
}

# as_root COMMAND...: directly as root, else by sudo where it asks for no password, else returns 1.
as_root() {
    if [[ $EUID -eq 0 ]]; then
        "$@"
    elif command -v sudo >/dev/null && sudo -n true 2>/dev/null; then
        sudo -n "$@"
    else
        return 1
    fi
}

# install_packages GROUP...: installs what is missing; returns 1 where that cannot be done.
install_packages() {
    command -v dpkg-query >/dev/null || return 0  # not a Debian: CMake will name what it does not find
    local missing
    mapfile -t missing < <(missing_packages "$@")
    [[ ${#missing[@]} -gt 0 ]] || return 0
    if ! as_root true; then
        say "packages are missing (installing them needs root). Install them by this line, then try again?"
        echo "sudo apt-get update && sudo apt-get install -y --no-install-recommends ${missing[*]}" >&2
        return 1
    fi
    say "installing ${missing[*]}"
    as_root env DEBIAN_FRONTEND=noninteractive apt-get -o Acquire::Retries=3 -qq update </dev/null >&2 ||
        say "apt-get update failed (see above); trying with the lists at hand"
    as_root env DEBIAN_FRONTEND=noninteractive apt-get -o Acquire::Retries=3 -o Dpkg::Use-Pty=0 -qq install -y \
        --no-install-recommends "${missing[@]}" </dev/null >&2
}

# require_packages GROUP...: the same, and the end where it fails.
require_packages() {
    install_packages "$@" || fail 4 "stopped (packages are missing)."
}

# build_preset PRESET TARGET [CMake option...]: configures when there is a reason to, then builds. One at a time in a folder:
# ninja and CMake know nothing of each other's second copies.
build_preset() {
    mkdir -p "$root/build"
    (
        if command -v flock >/dev/null && ! flock -n 9; then
            say "another build into build/$1 is under way; waiting for it"
            flock 9
        fi
        build_alone "$@" 9>&-
    ) 9>"$root/build/$1.lock" || exit
}

build_alone() {
    local preset=$1 target=$2 ninja=$root/build/$1/build.ninja
    shift 2
    if [[ $# -gt 0 || ! -e $ninja || $root/CMakePresets.json -nt $ninja ]]; then
        say "configuring build/$preset"
        (cd "$root" && cmake --preset "$preset" "$@") >&2 ||
            fail 4 "configuring failed (see above). Is a package of scripts/packages.txt missing?"
    fi
    [[ $target == all || -e $root/build/$preset/$target ]] || say "building $target (some minutes, the first time only)"
    (cd "$root" && cmake --build --preset "$preset" --target "$target") >&2 ||
        fail 1 "the build failed (see above). Remove build/$preset and try again?"
}

# cores: physical cores that this process may use, within the quota of a container.
cores() {
    local n physical quota period
    n=$(nproc)
    physical=$(lscpu -p=Core,Socket 2>/dev/null | grep -v '^#' | sort -u | wc -l) || physical=0
    if ((physical > 0 && physical < n)); then n=$physical; fi
    if read -r quota period 2>/dev/null </sys/fs/cgroup/cpu.max && [[ $quota != max ]]; then
        quota=$(((quota + period - 1) / period))
        if ((quota < n)); then n=$quota; fi
    fi
    echo "$n"
}
