//! An image that is the same wherever its sources lie.
//!
//! Panics carry the paths of their source files, so an image's size depends on the user's home and
//! on where the checkout lies. The compiler is told to write other paths in their stead.

use std::collections::BTreeSet;
use std::path::{Path, PathBuf};

/// The rustc flags that replace paths.
///
/// Given are what `cargo metadata` says of the workspace, the compiler's sysroot and the commit that
/// it was built from. A compiler without its own sources already calls them by that commit.
pub fn flags(metadata: &serde_json::Value, sysroot: &Path, commit: &str) -> Vec<String> {
    let flag = |from: &Path, to: &str| format!("--remap-path-prefix={}={to}", from.display());
    let mut flags: Vec<String> = registries(metadata)
        .iter()
        .map(|directory| flag(directory, "/registry"))
        .collect();
    if let Some(root) = metadata["workspace_root"].as_str() {
        flags.push(flag(Path::new(root), "/workspace"));
    }
    flags.push(flag(
        &sysroot.join("lib/rustlib/src/rust"),
        &format!("/rustc/{commit}"),
    ));
    flags
}

/// The directories that hold the sources of packages from elsewhere.
fn registries(metadata: &serde_json::Value) -> BTreeSet<PathBuf> {
    metadata["packages"]
        .as_array()
        .into_iter()
        .flatten()
        .filter(|package| package["source"].is_string())
        .filter_map(|package| package["manifest_path"].as_str())
        .filter_map(|manifest| Path::new(manifest).ancestors().nth(2))
        .map(Path::to_owned)
        .collect()
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn registry_workspace_and_compiler_get_other_paths() {
        let registry = "/home/a b/.cargo/registry/src/index";
        let metadata = serde_json::json!({
            "workspace_root": "/home/a b/ema",
            "packages": [
                {"source": "registry+https", "manifest_path": format!("{registry}/libm-0.2/Cargo.toml")},
                {"source": "registry+https", "manifest_path": format!("{registry}/defmt-1.2/Cargo.toml")},
                {"source": null, "manifest_path": "/home/a b/ema/firmware/Cargo.toml"},
            ],
        });
        assert_eq!(
            flags(&metadata, Path::new("/opt/rust"), "abc"),
            [
                &format!("--remap-path-prefix={registry}=/registry"),
                "--remap-path-prefix=/home/a b/ema=/workspace",
                "--remap-path-prefix=/opt/rust/lib/rustlib/src/rust=/rustc/abc",
            ]
        );
    }
}
