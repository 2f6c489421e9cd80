"""A study on a Slurm of one node, which the test starts: submitit submits each variant as a job of a batch script."""

import os
import shutil
import socket
import subprocess
import time
from contextlib import ExitStack, suppress
from pathlib import Path

import pytest
from heavylift import sweep

PROGRAMS = "mungekey", "munged", "slurmctld", "slurmd", "sbatch", "sinfo"
START_s, JOB_min = 30.0, 5
CONFIG = """ClusterName=one
SlurmctldHost={host}(127.0.0.1)
SlurmctldPort={ports[0]}
SlurmdPort={ports[1]}
SlurmUser={user}
SlurmdUser={user}
AuthType=auth/munge
AuthInfo=socket={folder}/munge/socket
CredType=cred/munge
ProctrackType=proctrack/linuxproc
TaskPlugin=task/none
StateSaveLocation={folder}/state
SlurmdSpoolDir={folder}/spool
SlurmctldPidFile={folder}/slurmctld.pid
SlurmdPidFile={folder}/slurmd.pid
SlurmctldLogFile={folder}/slurmctld.log
SlurmdLogFile={folder}/slurmd.log
MpiDefault=none
SwitchType=switch/none
AccountingStorageType=accounting_storage/none
JobAcctGatherType=jobacct_gather/none
NodeName={host} NodeAddr=127.0.0.1 CPUs=2
PartitionName=all Nodes=ALL Default=YES State=UP
"""


def free_port() -> int:
    with socket.socket() as found:
        found.bind(("127.0.0.1", 0))
        return int(found.getsockname()[1])


@pytest.fixture
def slurm(tmp_path: Path, monkeypatch: pytest.MonkeyPatch):
    """A running Slurm whose commands are found by the environment."""
    monkeypatch.setenv("PATH", f"{os.environ['PATH']}:/usr/sbin")
    if any(shutil.which(x) is None for x in PROGRAMS) or os.getuid() != 0:
        pytest.skip("no Slurm here: as root, apt-get install slurm-wlm munge")
    folder = tmp_path / "slurm"
    for name in ("munge", "state", "spool"):
        (folder / name).mkdir(parents=True)
    config, munge = folder / "slurm.conf", folder / "munge"
    host = socket.gethostname().partition(".")[0]
    ports = free_port(), free_port()
    config.write_text(CONFIG.format(host=host, folder=folder, ports=ports, user="root"))
    (folder / "cgroup.conf").write_text("CgroupPlugin=cgroup/v1\nCgroupAutomount=no\n")
    monkeypatch.setenv("SLURM_CONF", str(config))
    subprocess.run(["mungekey", "-c", "-k", munge / "key"], check=True)
    paths = {"--key-file": "key", "--socket": "socket", "--log-file": "log", "--pid-file": "pid", "--seed-file": "seed"}
    munged = ["munged", "-F", "--force", *(f"{option}={munge / name}" for option, name in paths.items())]
    with ExitStack() as stack:
        for command in (munged, ["slurmctld", "-D", "-c"], ["slurmd", "-D"]):
            program = stack.enter_context(
                subprocess.Popen(command, stdout=subprocess.DEVNULL, stderr=subprocess.DEVNULL, start_new_session=True)
            )
            stack.callback(program.terminate)
            time.sleep(1.0)
        end = time.monotonic() + START_s
        while time.monotonic() < end:
            with suppress(subprocess.SubprocessError):
                asked = subprocess.run(["sinfo", "-h", "-o", "%t"], capture_output=True, text=True, timeout=5.0)
                if asked.stdout.strip() == "idle":
                    break
            time.sleep(0.5)
        else:
            logs = "\n".join(x.read_text() for x in folder.glob("*.log"))
            pytest.fail(f"Slurm did not start in {START_s:g} s:\n{logs}")
        yield folder


def test_a_study_on_a_slurm_cluster_has_the_digests_of_a_local_study(slurm: Path, tmp_path: Path) -> None:
    submitit = pytest.importorskip("submitit", reason="submitit is not installed: pip install submitit")
    executor = submitit.AutoExecutor(tmp_path / "jobs")
    executor.update_parameters(timeout_min=JOB_min, cpus_per_task=1)
    assert executor.cluster == "slurm"
    vary = ["end={1 s, 2 s, 3 s}"]
    there = sweep("pendulum", vary, into=tmp_path / "there", executor=executor)
    here = sweep("pendulum", vary, into=tmp_path / "here", workers=1)
    assert [row["status"] for row in there.rows.values()] == ["done"] * 3
    assert {n: row["digest"] for n, row in there.rows.items()} == {n: row["digest"] for n, row in here.rows.items()}
    assert len([*(tmp_path / "jobs").glob("*_result.pkl")]) == 3
