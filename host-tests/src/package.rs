//! Packages beside the workspace, which are built when somebody needs them.

use std::io::IsTerminal;
use std::path::PathBuf;
use std::process::{Command, Stdio};

use crate::failure::Failure;
use crate::toolchain::clean_command;
use crate::workspace;

/// A package of `host-tests` that is no part of the workspace, built into `target/NAME`.
#[derive(Debug, Clone, Copy)]
pub struct Package {
    /// Its name, and that of its directory.
    pub name: &'static str,
}

impl Package {
    /// A cargo command on it.
    fn cargo(self, subcommand: &str) -> Command {
        let mut cargo = clean_command("cargo");
        cargo
            .arg(subcommand)
            .arg("--manifest-path")
            .arg(format!("host-tests/{}/Cargo.toml", self.name))
            .stderr(if std::io::stderr().is_terminal() {
                Stdio::inherit()
            } else {
                Stdio::piped()
            });
        cargo
    }

    /// What its cargo builds with, besides `features`.
    fn build_arguments(self, features: &str) -> [String; 7] {
        [
            "--release".to_owned(),
            "--locked".to_owned(),
            // What is built may ask for a newer compiler than it needs.
            "--ignore-rust-version".to_owned(),
            "--target-dir".to_owned(),
            format!("target/{}", self.name),
            "--features".to_owned(),
            features.to_owned(),
        ]
    }

    /// Builds a program of it with `features`, or finds it built.
    ///
    /// # Errors
    /// What the compiler says.
    pub fn build(self, program: &str, features: &str) -> Result<PathBuf, Failure> {
        let mut command = self.cargo("build");
        command.args(self.build_arguments(features));
        command.args(["--bin", program]);
        self.succeed(command, "does not build")?;
        Ok(self.executable(program))
    }

    /// Where a program of it is once it is built.
    pub(crate) fn executable(self, program: &str) -> PathBuf {
        let program = format!("release/{program}{}", std::env::consts::EXE_SUFFIX);
        let target = workspace::root().join("target").join(self.name);
        target.join(program)
    }

    /// Formatting of its code.
    ///
    /// # Errors
    /// What is not in order.
    pub fn check_format(self) -> Result<(), Failure> {
        let mut format = self.cargo("fmt");
        format.arg("--check");
        self.succeed(format, "is not formatted")
    }

    /// Lints of its code with `features`.
    ///
    /// # Errors
    /// What they say.
    pub fn lint(self, features: &str) -> Result<(), Failure> {
        let mut lint = self.cargo("clippy");
        lint.args(self.build_arguments(features));
        lint.args(["--all-targets", "--", "-D", "warnings"]);
        self.succeed(lint, "has lints")
    }

    /// Tests of its code with `features`.
    ///
    /// # Errors
    /// What fails.
    pub fn test(self, features: &str) -> Result<(), Failure> {
        let mut test = self.cargo("test");
        test.args(self.build_arguments(features));
        self.succeed(test, "has tests that fail")
    }

    fn succeed(self, mut command: Command, what: &str) -> Result<(), Failure> {
        let output = command
            .output()
            .map_err(|error| Failure::system("cargo cannot be run", &error))?;
        if output.status.success() {
            return Ok(());
        }
        Err(Failure::Other(format!(
            "host-tests/{} {what}\n{}{}",
            self.name,
            String::from_utf8_lossy(&output.stdout),
            String::from_utf8_lossy(&output.stderr)
        )))
    }
}
