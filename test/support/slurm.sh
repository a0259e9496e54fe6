# A Slurm of one node on this machine, for as long as a test runs.
#
# slurm_start DIR: 0 if it takes jobs; SLURM_CONF is then its configuration.
# slurm_stop DIR
slurm_missing() { # says what is missing, or fails
  test "$(id -u)" = 0 || {
    echo "not root"
    return
  }
  for program in slurmctld slurmd munged sbatch; do
    command -v $program >/dev/null || {
      echo "no $program (Debian: slurmctld, slurmd, slurm-client, munge)"
      return
    }
  done
  return 1
}

slurm_start() {
  mkdir "$1" "$1/state" "$1/spool" "$1/munge" || return 1
  chmod 755 "$1/munge"
  (umask 077 && head -c 1024 /dev/urandom >"$1/key")
  munged --force --key-file="$1/key" --socket="$1/munge/socket" \
    --pid-file="$1/munge/munged.pid" --log-file="$1/munge/log" \
    --seed-file="$1/munge/seed" 2>"$1/munge/err" || return 1
  host=$(hostname -s)
  # ports that are hardly another test's; more CPUs than there are, as the recipe asks for
  port=$((20000 + $$ % 20000))
  cat >"$1/slurm.conf" <<END
ClusterName=test
SlurmctldHost=$host(localhost)
SlurmUser=root
AuthType=auth/munge
AuthInfo=socket=$1/munge/socket
StateSaveLocation=$1/state
SlurmdSpoolDir=$1/spool
SlurmctldPidFile=$1/slurmctld.pid
SlurmdPidFile=$1/slurmd.pid
SlurmctldLogFile=$1/slurmctld.log
SlurmdLogFile=$1/slurmd.log
SlurmctldPort=$port
SlurmdPort=$((port + 1))
ProctrackType=proctrack/linuxproc
SlurmdParameters=config_overrides
NodeName=$host NodeAddr=localhost CPUs=16 State=UNKNOWN
PartitionName=all Nodes=$host Default=YES State=UP
END
  SLURM_CONF=$1/slurm.conf
  export SLURM_CONF
  slurmctld -c && slurmd -c || return 1
  for second in 1 2 3 4 5 6 7 8 9 10 11 12 13 14 15; do
    sinfo -h -t idle 2>/dev/null | grep -q idle && return 0
    sleep 1
  done
  return 1
}

slurm_stop() { # and waits, as they write into the folder until the end
  for file in "$1/slurmd.pid" "$1/slurmctld.pid" "$1/munge/munged.pid"; do
    test -e "$file" || continue
    pid=$(cat "$file")
    kill "$pid"
    for second in 1 2 3 4 5 6 7 8 9 10; do
      kill -0 "$pid" 2>/dev/null || break
      sleep 1
    done
  done
}
