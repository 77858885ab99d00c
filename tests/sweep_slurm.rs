//! The job-array script, submitted to a real Slurm that this test starts for itself on loopback.
//!
//! Without Slurm installed (Debian: `apt-get install slurm-wlm munge`) the test says so and passes, unless `SLURM=require`
//! is set, as in CI: a misspelt `#SBATCH` line is ignored without a word, so only submitting tells.

use std::{
    env, fs,
    net::TcpListener,
    path::{Path, PathBuf},
    process::{Child, Command, Stdio},
    thread::sleep,
    time::Duration,
};

const SWEEP: &str = r#"
name = "it's small"
scenes = ["floor"]
sizes = [[20, 15]]
filters = ["bilinear", "trilinear", "point"]
set.lod.bits = [4, 8]
"#;

fn found(program: &str) -> Option<PathBuf> {
    let paths = env::var_os("PATH").unwrap_or_default();
    let known = ["/usr/sbin", "/usr/bin"].map(PathBuf::from);
    env::split_paths(&paths).chain(known).map(|folder| folder.join(program)).find(|path| path.is_file())
}

fn free_port() -> u16 {
    TcpListener::bind("127.0.0.1:0").unwrap().local_addr().unwrap().port()
}

/// The daemons of one cluster of one node; they end with it.
struct Cluster {
    folder: tempfile::TempDir,
    daemons: Vec<Child>,
}

impl Drop for Cluster {
    fn drop(&mut self) {
        for daemon in self.daemons.iter_mut().rev() {
            let _ = daemon.kill();
            let _ = daemon.wait();
        }
    }
}

impl Cluster {
    fn start() -> Option<Self> {
        let [munged, controller, node] = [found("munged")?, found("slurmctld")?, found("slurmd")?];
        found("sbatch")?;
        // Sockets have short names: not below the build folder.
        let folder = tempfile::Builder::new().prefix("texunit-slurm-").tempdir_in("/tmp").unwrap();
        let at = |name: &str| folder.path().join(name);
        fs::write(at("munge.key"), [0x5A; 1024]).unwrap();
        private(&at("munge.key"), 0o600);
        private(folder.path(), 0o755);
        for name in ["state", "spool", "munge"] {
            fs::create_dir(at(name)).unwrap();
        }
        let host = fs::read_to_string("/proc/sys/kernel/hostname").unwrap();
        let host = host.trim().split('.').next().unwrap();
        let (controller_port, node_port) = (free_port(), free_port());
        let user = if fs::metadata("/proc/self").is_ok() { whoami() } else { "root".into() };
        let root = folder.path().display();
        let configuration = format!(
            "ClusterName=texunit\nSlurmctldHost={host}(127.0.0.1)\nSlurmctldPort={controller_port}\n\
             SlurmdPort={node_port}\nAuthType=auth/munge\nAuthInfo=socket={root}/munge/socket\nCredType=cred/munge\n\
             SlurmUser={user}\nSlurmdUser={user}\nStateSaveLocation={root}/state\nSlurmdSpoolDir={root}/spool\n\
             SlurmctldPidFile={root}/slurmctld.pid\nSlurmdPidFile={root}/slurmd.pid\n\
             SlurmctldLogFile={root}/slurmctld.log\nSlurmdLogFile={root}/slurmd.log\n\
             ProctrackType=proctrack/linuxproc\nTaskPlugin=task/none\nSelectType=select/cons_tres\n\
             SelectTypeParameters=CR_Core\nReturnToService=2\nMpiDefault=none\n\
             JobAcctGatherType=jobacct_gather/none\nAccountingStorageType=accounting_storage/none\n\
             NodeName={host} NodeAddr=127.0.0.1 CPUs=2 State=UNKNOWN\n\
             PartitionName=main Nodes={host} Default=YES MaxTime=INFINITE State=UP\n"
        );
        fs::write(at("slurm.conf"), configuration).unwrap();
        let mut cluster = Self { folder, daemons: Vec::new() };
        let root = cluster.folder.path().display().to_string();
        let munge = |name: &str| format!("--{name}={root}/munge/{name}");
        cluster.spawn(
            &munged,
            &[
                "--foreground",
                "--force",
                &format!("--key-file={root}/munge.key"),
                &format!("--socket={root}/munge/socket"),
                &munge("pid-file"),
                &munge("log-file"),
                &munge("seed-file"),
            ],
        );
        wait_for("the socket of munged", || Path::new(&format!("{root}/munge/socket")).exists());
        let configuration = format!("{root}/slurm.conf");
        cluster.spawn(&controller, &["-D", "-i", "-f", &configuration]);
        cluster.spawn(&node, &["-D", "-f", &configuration]);
        wait_for("an idle node", || {
            cluster
                .command("sinfo")
                .args(["-h", "-o", "%T"])
                .output()
                .is_ok_and(|output| output.stdout.starts_with(b"idle"))
        });
        Some(cluster)
    }

    fn spawn(&mut self, program: &Path, arguments: &[&str]) {
        let log = fs::File::create(self.folder.path().join(format!("daemon-{}.log", self.daemons.len()))).unwrap();
        let daemon = Command::new(program)
            .args(arguments)
            .stdin(Stdio::null())
            .stdout(log.try_clone().unwrap())
            .stderr(log)
            .spawn()
            .unwrap();
        self.daemons.push(daemon);
    }

    fn command(&self, program: &str) -> Command {
        let mut command = Command::new(program);
        command.env("SLURM_CONF", self.folder.path().join("slurm.conf"));
        command
    }
}

fn whoami() -> String {
    String::from_utf8(Command::new("id").arg("-un").output().unwrap().stdout).unwrap().trim().to_owned()
}

#[cfg(unix)]
fn private(path: &Path, mode: u32) {
    use std::os::unix::fs::PermissionsExt;
    fs::set_permissions(path, fs::Permissions::from_mode(mode)).unwrap();
}

fn wait_for(what: &str, mut ready: impl FnMut() -> bool) {
    for _ in 0..600 {
        if ready() {
            return;
        }
        sleep(Duration::from_millis(200));
    }
    panic!("waited two minutes for {what}");
}

#[test]
fn the_array_runs_every_point_and_the_merge_after_it() {
    let Some(cluster) = Cluster::start() else {
        assert_ne!(env::var("SLURM").as_deref(), Ok("require"), "Slurm is not installed");
        eprintln!("SKIPPED: Slurm is not installed (apt-get install slurm-wlm munge)");
        return;
    };
    let folder = cluster.folder.path().join("a sweep");
    fs::create_dir(&folder).unwrap();
    fs::write(folder.join("s.toml"), SWEEP).unwrap();
    let texunit = |arguments: &[&str]| {
        let output = Command::new(env!("CARGO_BIN_EXE_texunit")).args(arguments).current_dir(&folder).output().unwrap();
        assert!(output.status.success(), "{}", String::from_utf8_lossy(&output.stderr));
        output.stdout
    };
    texunit(&["sweep", "run", "s.toml", "-o", "here"]);
    // Six points in three tasks of two.
    fs::write(
        folder.join("job.sh"),
        texunit(&["sweep", "slurm", "s.toml", "-o", "there", "--tasks", "3", "--at-once", "2"]),
    )
    .unwrap();
    let submitted = cluster.command("sh").arg("job.sh").current_dir(&folder).output().unwrap();
    assert!(submitted.status.success(), "{}", String::from_utf8_lossy(&submitted.stderr));
    let merged = folder.join("there/sweep.csv");
    wait_for("the merged table", || merged.exists());
    assert_eq!(fs::read(merged).unwrap(), fs::read(folder.join("here/sweep.csv")).unwrap());
}
