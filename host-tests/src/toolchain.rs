//! Set-up of what the firmware needs on this machine: a compiler with a `core` for the microcontroller, and
//! its linker.
//!
//! There are three ways to a `core` for [`TARGET`], tried in this order:
//!
//! 1. the toolchain in use has it;
//! 2. rustup adds it to that toolchain;
//! 3. Debian's packages [`COMPILER_PACKAGES`] build it from source.
//!
//! Set-up may add a target, puts the linker into `target/tools` unless the user has it, and installs
//! missing Debian packages where it runs as root. It never installs or updates a toolchain.

use std::ffi::OsStr;
use std::io::IsTerminal;
use std::path::{Path, PathBuf};
use std::process::{Command, Stdio};

use crate::failure::Failure;
use crate::{remap, workspace};

/// The microcontroller's target: Cortex-M4F.
pub const TARGET: &str = "thumbv7em-none-eabihf";

/// The firmware's feature for its board.
const BOARD: &str = "stm32f405";

/// Debian's way to [`TARGET`].
pub const COMPILER_PACKAGES: [&str; 4] = ["rustc-web", "cargo-web", "rust-web-src", "lld"];

/// The linker, which `.cargo/config.toml` names: it puts the stack below the variables, so that an
/// overflow is a fault and no silent damage.
pub const LINKER: &str = "flip-link";

/// The version of [`LINKER`] that is installed where there is none.
pub const LINKER_VERSION: &str = "0.1.12";

/// A browser in which the tests open the live page, by the names that it goes by.
pub const BROWSERS: [&str; 3] = ["chromium", "chromium-browser", "google-chrome"];

/// What [`LINKER`] runs. Debian has it under the name [`DEBIAN_LLD`].
#[cfg(unix)]
const LLD: &str = "rust-lld";

#[cfg(unix)]
const DEBIAN_LLD: &str = "/usr/bin/ld.lld";

/// The way that was taken to a `core` for [`TARGET`].
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Route {
    /// The toolchain in use has the target.
    Present,
    /// rustup added the target.
    Added,
    /// Debian's compiler builds `core` from source.
    Debian,
}

impl Route {
    /// For the user to read.
    pub fn describe(self) -> &'static str {
        match self {
            Self::Present => "the toolchain in use",
            Self::Added => "the toolchain in use, target added by rustup",
            Self::Debian => "Debian's rustc-web, core built from source",
        }
    }
}

/// What set-up asks of the machine and does to it.
trait Machine {
    /// Whether the toolchain in use has the target.
    fn has_target(&mut self) -> bool;
    /// Has rustup add the target.
    fn add_target(&mut self) -> Result<(), String>;
    /// Whether this is a system whose packages are Debian's.
    fn is_debian(&mut self) -> bool;
    /// Whether a Debian package is installed.
    fn has_package(&mut self, package: &str) -> bool;
    /// Whether a program is on the path.
    fn has_program(&mut self, program: &str) -> bool;
    /// Whether packages may be installed.
    fn is_root(&mut self) -> bool;
    /// Installs Debian packages.
    fn install(&mut self, packages: &[&str]) -> Result<(), String>;
    /// Installs a program from the registry for this workspace alone.
    fn install_program(&mut self, program: &str, version: &str) -> Result<(), String>;
}

/// Finds a way to the target, or says what to run.
fn choose_route(machine: &mut impl Machine) -> Result<Route, String> {
    if machine.has_target() {
        return Ok(Route::Present);
    }
    let reason = match machine.add_target() {
        Ok(()) => return Ok(Route::Added),
        Err(reason) => reason,
    };
    if !machine.is_debian() {
        return Err(format!(
            "no way to build for {TARGET} ({reason}); run: rustup target add {TARGET}"
        ));
    }
    ensure_packages(machine, &COMPILER_PACKAGES)?;
    Ok(Route::Debian)
}

/// Sees to the linker, or says what to run.
fn ensure_linker(machine: &mut impl Machine) -> Result<(), String> {
    if machine.has_program(LINKER) {
        return Ok(());
    }
    machine
        .install_program(LINKER, LINKER_VERSION)
        .map_err(|reason| {
            format!("{reason}; try: cargo install {LINKER} --version {LINKER_VERSION} --locked")
        })
}

/// Sees to one of [`BROWSERS`], which only a test needs.
///
/// # Errors
/// There is none, and what to run.
pub fn set_up_browser() -> Result<(), String> {
    ensure_browser(&mut ThisMachine)
}

fn ensure_browser(machine: &mut impl Machine) -> Result<(), String> {
    if BROWSERS.iter().any(|browser| machine.has_program(browser)) {
        return Ok(());
    }
    if !machine.is_debian() {
        return Err("there is no Chromium on this machine".to_owned());
    }
    ensure_packages(machine, &BROWSERS[..1])
}

fn ensure_packages(machine: &mut impl Machine, packages: &[&'static str]) -> Result<(), String> {
    let missing: Vec<&str> = packages
        .iter()
        .copied()
        .filter(|package| !machine.has_package(package))
        .collect();
    if missing.is_empty() {
        return Ok(());
    }
    let by_hand = format!(
        "sudo apt-get update && sudo apt-get install --yes {}",
        missing.join(" ")
    );
    if !machine.is_root() {
        return Err(format!("missing Debian packages; run: {by_hand}"));
    }
    machine
        .install(&missing)
        .map_err(|reason| format!("{reason}; try: {by_hand}"))
}

/// A way to build the firmware on this machine.
#[derive(Debug, Clone)]
pub struct Toolchain {
    route: Route,
    compiler: Compiler,
    /// Flags by which the image does not tell where its sources lie.
    remap: Vec<String>,
}

/// What the compiler says of itself.
#[derive(Debug, Clone, PartialEq, Eq)]
struct Compiler {
    /// With the commit, or with whoever else built it.
    version: String,
    host: String,
    commit: String,
}

impl Compiler {
    /// From `rustc --version --verbose`.
    fn read(said: &str) -> Option<Self> {
        let value = |name: &str| {
            said.lines()
                .find_map(|line| line.strip_prefix(name)?.strip_prefix(": "))
                .map(str::to_owned)
        };
        Some(Self {
            version: said.lines().next()?.to_owned(),
            host: value("host")?,
            commit: value("commit-hash")?,
        })
    }
}

/// A built image.
#[derive(Debug, Clone)]
pub struct Build {
    /// The ELF file.
    pub elf: PathBuf,
    /// What the compiler warned about in this workspace.
    pub warnings: Vec<String>,
}

impl Toolchain {
    /// Sees to the compiler and the linker.
    ///
    /// # Errors
    /// What is missing, with the command that brings it.
    pub fn set_up() -> Result<Self, Failure> {
        let mut machine = ThisMachine;
        let route = choose_route(&mut machine).map_err(Failure::Other)?;
        ensure_linker(&mut machine).map_err(Failure::Other)?;
        if route == Route::Debian {
            provide_lld().map_err(|error| Failure::system(debian_tools().display(), &error))?;
        }
        let said = answer(route.command("rustc").args(["--version", "--verbose"]))?;
        let compiler = Compiler::read(&said)
            .ok_or_else(|| Failure::other("rustc does not say its version"))?;
        let sysroot = answer(route.command("rustc").args(["--print", "sysroot"]))?;
        let metadata = answer(
            route
                .command("cargo")
                .args(["metadata", "--format-version=1"]),
        )?;
        let metadata = serde_json::from_str(&metadata)
            .map_err(|error| Failure::Other(format!("cargo metadata: {error}")))?;
        Ok(Self {
            route,
            remap: remap::flags(&metadata, Path::new(sysroot.trim_end()), &compiler.commit),
            compiler,
        })
    }

    /// What decides over an image's every byte, beside its sources.
    pub fn compiler(&self) -> String {
        let Compiler { version, host, .. } = &self.compiler;
        let core = match self.route {
            Route::Present | Route::Added => "",
            Route::Debian => ", core from source",
        };
        format!("{version}, {host}{core}")
    }

    /// The way that was taken.
    pub fn route(&self) -> Route {
        self.route
    }

    /// Builds one of the firmware's images.
    ///
    /// # Errors
    /// What the compiler says.
    pub fn build(&self, program: &str) -> Result<Build, Failure> {
        let mut cargo = self.cargo("build");
        cargo.args(["--bin", program, "--message-format=json"]);
        let progress = std::io::stderr().is_terminal();
        let output = cargo
            .stdout(Stdio::piped())
            .stderr(if progress {
                Stdio::inherit()
            } else {
                Stdio::piped()
            })
            .output()
            .map_err(|error| Failure::system("cargo cannot be run", &error))?;
        let report = CargoReport::read(&output.stdout, program);
        if !output.status.success() {
            return Err(Failure::Other(format!(
                "the firmware does not build\n{}{}",
                report.errors.concat(),
                String::from_utf8_lossy(&output.stderr)
            )));
        }
        let elf = report
            .executable
            .ok_or_else(|| Failure::other("cargo built no image"))?;
        Ok(Build {
            elf,
            warnings: report.warnings,
        })
    }

    /// Holds clippy against the firmware with its hardware. False if this way has no clippy.
    ///
    /// # Errors
    /// What clippy says.
    pub fn lint(&self) -> Result<bool, Failure> {
        if self.route == Route::Debian {
            return Ok(false);
        }
        let output = self
            .cargo("clippy")
            .args(["--quiet", "--", "-D", "warnings"])
            .output()
            .map_err(|error| Failure::system("cargo cannot be run", &error))?;
        if output.status.success() {
            Ok(true)
        } else {
            Err(Failure::Other(format!(
                "clippy finds fault with the firmware\n{}",
                String::from_utf8_lossy(&output.stderr)
            )))
        }
    }

    /// A cargo command on the firmware with the board's hardware.
    fn cargo(&self, subcommand: &str) -> Command {
        let mut cargo = self.route.command("cargo");
        // Not the host's target directory: two compilers, and no waiting for the other's lock.
        cargo
            .args([subcommand, "--release", "--package", "firmware"])
            .args(["--target", TARGET, "--target-dir", "target/firmware"])
            .args(["--features", BOARD])
            // Added to the flags in .cargo/config.toml.
            .arg("--config")
            .arg(format!(
                "target.{TARGET}.rustflags={}",
                toml::Value::from(self.remap.clone())
            ));
        if self.route == Route::Debian {
            cargo.arg("-Zbuild-std=core");
        }
        cargo
    }
}

/// What cargo says in `--message-format=json`.
#[derive(Debug, Default, PartialEq)]
struct CargoReport {
    executable: Option<PathBuf>,
    warnings: Vec<String>,
    errors: Vec<String>,
}

impl CargoReport {
    fn read(output: &[u8], program: &str) -> Self {
        let mut report = Self::default();
        let messages = serde_json::Deserializer::from_slice(output).into_iter();
        for message in messages.map_while(Result::<serde_json::Value, _>::ok) {
            if message["target"]["name"] == program
                && let Some(executable) = message["executable"].as_str()
            {
                report.executable = Some(PathBuf::from(executable));
            }
            let rendered = || message["message"]["rendered"].as_str().map(str::to_owned);
            match message["message"]["level"].as_str() {
                Some("warning") => report.warnings.extend(rendered()),
                Some("error") => report.errors.extend(rendered()),
                _ => {}
            }
        }
        report
    }
}

impl Route {
    /// A program of this way's toolchain, in the workspace's root.
    fn command(self, program: &str) -> Command {
        match self {
            Self::Present | Self::Added => clean_command(program),
            Self::Debian => debian_command(program),
        }
    }
}

/// Standard output of a command that succeeds.
fn answer(command: &mut Command) -> Result<String, Failure> {
    let name = command.get_program().to_string_lossy().into_owned();
    let output = command
        .output()
        .map_err(|error| Failure::system(&name, &error))?;
    if output.status.success() {
        Ok(String::from_utf8_lossy(&output.stdout).into_owned())
    } else {
        Err(Failure::Other(format!(
            "{name} failed\n{}",
            String::from_utf8_lossy(&output.stderr)
        )))
    }
}

/// Variables by which the cargo that runs this program would choose its children's toolchain, flags
/// or log level.
const INHERITED: [&str; 13] = [
    "CARGO",
    "CARGO_BUILD_RUSTFLAGS",
    "CARGO_BUILD_TARGET",
    "CARGO_ENCODED_RUSTFLAGS",
    "DEFMT_LOG",
    "RUSTC",
    "RUSTC_BOOTSTRAP",
    "RUSTC_WORKSPACE_WRAPPER",
    "RUSTC_WRAPPER",
    "RUSTDOC",
    "RUSTFLAGS",
    "RUSTUP_TOOLCHAIN",
    "RUSTUP_TOOLCHAIN_SOURCE",
];

/// Where this workspace's own programs are.
fn tools() -> PathBuf {
    workspace::root().join("target/tools")
}

/// Where [`LINKER`] finds Debian's linker under the name that it looks for.
fn debian_tools() -> PathBuf {
    tools().join("debian")
}

#[cfg(unix)]
fn provide_lld() -> std::io::Result<()> {
    let link = debian_tools().join(LLD);
    std::fs::create_dir_all(debian_tools())?;
    if link.is_symlink() {
        return Ok(());
    }
    std::os::unix::fs::symlink(DEBIAN_LLD, link)
}

#[cfg(not(unix))]
fn provide_lld() -> std::io::Result<()> {
    Err(std::io::ErrorKind::Unsupported.into())
}

/// The directories in which programs are looked for: the user's own, and after them this
/// workspace's.
fn search_path() -> Vec<PathBuf> {
    let inherited = std::env::var_os("PATH").unwrap_or_default();
    let mut directories: Vec<PathBuf> = std::env::split_paths(&inherited).collect();
    directories.push(tools().join("bin"));
    directories
}

/// A command in the workspace's root that chooses its own toolchain, and installs none.
pub(crate) fn clean_command(program: impl AsRef<OsStr>) -> Command {
    let mut command = Command::new(program);
    for variable in INHERITED {
        command.env_remove(variable);
    }
    set_search_path(&mut command, search_path());
    command
        .env("RUSTUP_AUTO_INSTALL", "0")
        .current_dir(workspace::root())
        .stdin(Stdio::null());
    command
}

fn debian_command(program: &str) -> Command {
    let programs = Path::new("/usr/bin");
    let mut command = clean_command(programs.join(program));
    let mut directories = vec![programs.to_owned()];
    directories.extend(search_path());
    directories.push(debian_tools());
    set_search_path(&mut command, directories);
    // -Zbuild-std is not stable.
    command.env("RUSTC_BOOTSTRAP", "1");
    command
}

fn set_search_path(command: &mut Command, directories: Vec<PathBuf>) {
    // A directory with a separator in its name cannot be on the path; then it stays as it is.
    if let Ok(path) = std::env::join_paths(directories) {
        command.env("PATH", path);
    }
}

/// The machine that this program runs on.
struct ThisMachine;

impl Machine for ThisMachine {
    fn has_target(&mut self) -> bool {
        let output = clean_command("rustc")
            .args(["--print", "target-libdir", "--target", TARGET])
            .output();
        output.is_ok_and(|output| {
            output.status.success()
                && Path::new(String::from_utf8_lossy(&output.stdout).trim_end()).is_dir()
        })
    }

    fn add_target(&mut self) -> Result<(), String> {
        if !self.has_program("rustup") {
            return Err("rustup is not installed".to_owned());
        }
        announce(&format!(
            "Adding the target {TARGET} to the toolchain in use"
        ));
        let output = clean_command("rustup")
            .args(["target", "add", TARGET])
            .output()
            .map_err(|error| format!("rustup cannot be run ({error})"))?;
        if output.status.success() {
            return Ok(());
        }
        let said = String::from_utf8_lossy(&output.stderr);
        let error = said.lines().find(|line| line.starts_with("error"));
        Err(format!("rustup: {}", error.unwrap_or("failed")))
    }

    fn is_debian(&mut self) -> bool {
        self.has_program("apt-get") && self.has_program("dpkg-query")
    }

    fn has_package(&mut self, package: &str) -> bool {
        let output = clean_command("dpkg-query")
            .args(["--show", "--showformat", "${db:Status-Status}", package])
            .output();
        output.is_ok_and(|output| output.stdout == b"installed")
    }

    fn has_program(&mut self, program: &str) -> bool {
        let file = format!("{program}{}", std::env::consts::EXE_SUFFIX);
        search_path()
            .iter()
            .any(|directory| directory.join(&file).is_file())
    }

    fn is_root(&mut self) -> bool {
        let output = clean_command("id").arg("-u").output();
        output.is_ok_and(|output| output.stdout.trim_ascii() == b"0")
    }

    fn install(&mut self, packages: &[&str]) -> Result<(), String> {
        announce(&format!(
            "Installing Debian packages: {}",
            packages.join(" ")
        ));
        for arguments in [
            &["update"][..],
            &["install", "--yes", "--no-install-recommends"][..],
        ] {
            let installs = arguments[0] == "install";
            let output = clean_command("apt-get")
                .args(arguments)
                .args(if installs { packages } else { &[] })
                .env("DEBIAN_FRONTEND", "noninteractive")
                .output()
                .map_err(|error| format!("apt-get cannot be run ({error})"))?;
            if !output.status.success() {
                let said = String::from_utf8_lossy(&output.stderr);
                let last = said.lines().last().unwrap_or_default();
                return Err(format!("apt-get {} failed ({last})", arguments[0]));
            }
        }
        Ok(())
    }

    fn install_program(&mut self, program: &str, version: &str) -> Result<(), String> {
        announce(&format!("Installing {program} {version} into target/tools"));
        let output = clean_command("cargo")
            .args([
                "install",
                program,
                "--version",
                version,
                "--locked",
                "--root",
            ])
            .arg(tools())
            .output()
            .map_err(|error| format!("cargo cannot be run ({error})"))?;
        if output.status.success() {
            return Ok(());
        }
        let said = String::from_utf8_lossy(&output.stderr);
        let error = said.lines().find(|line| line.starts_with("error"));
        Err(format!(
            "{program} cannot be installed ({})",
            error.unwrap_or("cargo failed")
        ))
    }
}

/// Set-up changes the machine: it says so, in a pipe too.
fn announce(what: &str) {
    crate::error::tell(what);
}

#[cfg(test)]
mod tests {
    use super::*;

    /// A machine of which every answer is known beforehand, and which writes down what is done to it.
    #[derive(Default)]
    struct Faked {
        target: bool,
        rustup_works: bool,
        debian: bool,
        packages: Vec<&'static str>,
        programs: Vec<&'static str>,
        root: bool,
        mirror_fails: bool,
        installed: Vec<String>,
    }

    impl Machine for Faked {
        fn has_target(&mut self) -> bool {
            self.target
        }
        fn add_target(&mut self) -> Result<(), String> {
            assert!(!self.target, "adds a target that is there");
            if self.rustup_works {
                Ok(())
            } else {
                Err("no network".to_owned())
            }
        }
        fn is_debian(&mut self) -> bool {
            self.debian
        }
        fn has_package(&mut self, package: &str) -> bool {
            self.packages.contains(&package)
        }
        fn has_program(&mut self, program: &str) -> bool {
            self.programs.contains(&program)
        }
        fn is_root(&mut self) -> bool {
            self.root
        }
        fn install(&mut self, packages: &[&str]) -> Result<(), String> {
            if self.mirror_fails {
                return Err("apt-get update failed".to_owned());
            }
            self.installed
                .extend(packages.iter().map(|&package| package.to_owned()));
            Ok(())
        }
        fn install_program(&mut self, program: &str, version: &str) -> Result<(), String> {
            if self.mirror_fails {
                return Err("no network".to_owned());
            }
            self.installed.push(format!("{program} {version}"));
            Ok(())
        }
    }

    #[test]
    fn a_target_that_is_there_is_used_as_it_is() {
        let mut machine = Faked {
            target: true,
            ..Faked::default()
        };
        assert_eq!(choose_route(&mut machine), Ok(Route::Present));
    }

    #[test]
    fn rustup_comes_before_debian() {
        let mut machine = Faked {
            rustup_works: true,
            debian: true,
            packages: COMPILER_PACKAGES.to_vec(),
            ..Faked::default()
        };
        assert_eq!(choose_route(&mut machine), Ok(Route::Added));
    }

    #[test]
    fn debian_serves_where_rustup_does_not() {
        let mut machine = Faked {
            debian: true,
            packages: COMPILER_PACKAGES.to_vec(),
            ..Faked::default()
        };
        assert_eq!(choose_route(&mut machine), Ok(Route::Debian));
        assert!(machine.installed.is_empty());
    }

    #[test]
    fn root_installs_only_what_is_missing() {
        let mut machine = Faked {
            debian: true,
            root: true,
            packages: vec!["rustc-web", "lld"],
            ..Faked::default()
        };
        assert_eq!(choose_route(&mut machine), Ok(Route::Debian));
        assert_eq!(machine.installed, ["cargo-web", "rust-web-src"]);
    }

    #[test]
    fn without_root_the_error_is_the_command_to_run() {
        let mut machine = Faked {
            debian: true,
            packages: vec!["rustc-web", "cargo-web", "rust-web-src"],
            ..Faked::default()
        };
        let error = choose_route(&mut machine).unwrap_err();
        assert!(
            error.ends_with("run: sudo apt-get update && sudo apt-get install --yes lld"),
            "{error}"
        );
        assert!(machine.installed.is_empty());
    }

    #[test]
    fn an_installation_that_fails_says_why_and_what_to_try() {
        let mut machine = Faked {
            debian: true,
            root: true,
            mirror_fails: true,
            ..Faked::default()
        };
        let error = choose_route(&mut machine).unwrap_err();
        assert!(
            error.starts_with("apt-get update failed; try: sudo apt-get"),
            "{error}"
        );
    }

    #[test]
    fn elsewhere_the_error_names_rustup_and_its_reason() {
        let error = choose_route(&mut Faked::default()).unwrap_err();
        assert!(error.contains("no network"), "{error}");
        assert!(
            error.ends_with("rustup target add thumbv7em-none-eabihf"),
            "{error}"
        );
    }

    #[test]
    fn a_browser_is_installed_only_where_there_is_none() {
        let mut there = Faked {
            programs: vec!["google-chrome"],
            ..Faked::default()
        };
        assert_eq!(ensure_browser(&mut there), Ok(()));
        assert!(ensure_browser(&mut Faked::default()).is_err());
        let mut missing = Faked {
            debian: true,
            root: true,
            ..Faked::default()
        };
        assert_eq!(ensure_browser(&mut missing), Ok(()));
        assert_eq!(missing.installed, ["chromium"]);
    }

    #[test]
    fn the_linker_is_installed_only_where_the_user_has_none() {
        let mut there = Faked {
            programs: vec![LINKER],
            ..Faked::default()
        };
        assert_eq!(ensure_linker(&mut there), Ok(()));
        assert!(there.installed.is_empty());

        let mut absent = Faked::default();
        assert_eq!(ensure_linker(&mut absent), Ok(()));
        assert_eq!(absent.installed, ["flip-link 0.1.12"]);

        let mut offline = Faked {
            mirror_fails: true,
            ..Faked::default()
        };
        assert_eq!(
            ensure_linker(&mut offline),
            Err("no network; try: cargo install flip-link --version 0.1.12 --locked".to_owned())
        );
    }

    #[test]
    fn the_compiler_says_what_it_is() {
        let said = "rustc 1.95.0 (598076 2026-04-14)\nbinary: rustc\ncommit-hash: 598076\n\
                    commit-date: 2026-04-14\nhost: x86_64-unknown-linux-gnu\nrelease: 1.95.0\n";
        assert_eq!(
            Compiler::read(said),
            Some(Compiler {
                version: "rustc 1.95.0 (598076 2026-04-14)".to_owned(),
                host: "x86_64-unknown-linux-gnu".to_owned(),
                commit: "598076".to_owned(),
            })
        );
        assert_eq!(Compiler::read("rustc 1.95.0"), None);
    }

    #[test]
    fn cargo_reports_image_warnings_and_errors() {
        let output = br#"{"reason":"compiler-artifact","target":{"name":"firmware"},"executable":null}
{"reason":"compiler-message","target":{"name":"firmware"},"message":{"level":"warning","rendered":"unused\n"}}
{"reason":"compiler-artifact","target":{"name":"emulated"},"executable":"/x/emulated"}
{"reason":"build-finished","success":true}
"#;
        assert_eq!(
            CargoReport::read(output, "emulated"),
            CargoReport {
                executable: Some(PathBuf::from("/x/emulated")),
                warnings: vec!["unused\n".to_owned()],
                errors: vec![],
            }
        );
    }
}
