# shellcheck shell=bash
# shellcheck disable=SC2034,SC2154  # failed, self: of who sources this
# Hosts out of namespaces, for scripts/test-hosts and scripts/test-slurm: network, UTS, mount and IPC of their own, /dev/shm, TMPDIR, time zone, a
# network for messages (eth0) and one for launchers (eth1). Sourced, never run; prepare.sh before it. The disk is shared, as Moraine wants it.

skip() { say "several hosts are not tested ($1)." && exit 77; }

# in_namespace ARGUMENT...: starts the script again in a network of its own, which is gone with it.
in_namespace() {
    [[ -z ${MORAINE_IN_NAMESPACE:-} ]] || return 0
    command -v ip nsenter unshare mpirun >/dev/null || skip "ip, nsenter, unshare or mpirun is missing; Debian: iproute2, util-linux"
    mpirun --version 2>/dev/null | grep -q "Open MPI" || skip "this MPI is not Open MPI"
    local ways=(--net --mount)
    [[ $EUID -eq 0 ]] || ways+=(--user --map-root-user)
    unshare "${ways[@]}" unshare --net --uts --mount --ipc true 2>/dev/null || skip "namespaces may not be made here"
    MORAINE_IN_NAMESPACE=1 exec unshare "${ways[@]}" "$self" "$@"
}

# make_work: a folder for all, gone at the end with the hosts.
make_work() {
    work=$(mktemp -d) holders=() failed=0
    trap leave EXIT
}
leave() {
    kill "${holders[@]}" 2>/dev/null
    wait "${holders[@]}" 2>/dev/null
    rm -rf "$work"
}

# The agent that mpirun starts its daemons with, as it would ssh: agent HOST WORDS...
make_agent() {
    cat >"$work/agent" <<END
#!/bin/bash
host=\$1 && shift
read -r pid <$work/\$host.pid
exec nsenter --target "\$pid" --net --uts --mount --ipc --wd="\$PWD" env TMPDIR=$work/\$host TZ=UTC-\${host#mr} \
    bash -c "\$*"
END
    chmod +x "$work/agent"
}

# make_host K: a namespace held by a process that sleeps, a cable to the bridge, names.
make_host() {
    local host=mr$1 pid net
    mkdir "$work/$host"
    unshare --net --uts --mount --ipc sleep infinity &
    pid=$! && holders+=("$pid")
    until [[ $(readlink "/proc/$pid/exe") == *sleep ]]; do :; done
    echo "$pid" >"$work/$host.pid"
    for net in 0 1; do
        ip link add "v$1-$net" type veth peer name "eth$net" netns "$pid" && ip link set "v$1-$net" master "br$net" up || return 1
        "$work/agent" "$host" "ip addr add 10.9.$net.$1/24 dev eth$net && ip link set eth$net up" || return 1
    done
    "$work/agent" "$host" "hostname $host && ip link set lo up &&
        mount --make-rprivate / && mount -t tmpfs none /dev/shm && mount --bind $work/hosts /etc/hosts"
}

make_hosts() {
    local k
    ip link set lo up
    for k in 0 1; do ip link add br$k type bridge forward_delay 0 && ip link set br$k up || return 1; done
    { echo 127.0.0.1 localhost && for k in 1 2 3; do echo "10.9.1.$k mr$k"; done; } >"$work/hosts"
    make_agent
    for k in 1 2 3; do make_host $k || return 1; done
}

# is NAME COMMAND...: one thing that must be true.
is() {
    local name=$1
    shift
    if "$@"; then echo "ok      $name"; else
        failed=1 && echo "FAILED  $name"
        tail -n 5 "$work"/*.log
    fi
}
