//! Which probe is opened.

use std::error::Error;
use std::io;

use probe_rs::probe::list::{Accessibility, Lister, ProbeListItem};
use probe_rs::probe::{DebugProbeInfo, DebugProbeSelector, Probe};

/// How a user gets access to probes, where the system gives them to root alone.
const ACCESS: &str = "this user may not open it; add the udev rule of https://probe.rs/docs/getting-started/probe-setup/ and plug \
                      the probe in again";

/// Opens the probe that `choice` names (VID:PID or VID:PID:SERIAL), or the only one.
///
/// # Errors
/// No such probe, or several; one that this user may not open, or that another program has.
pub fn open(choice: Option<&str>) -> Result<Probe, String> {
    let selector = choice.map(selector).transpose()?;
    let all = Lister::new().list_all_with_access();
    let probe = only(&all, selector.as_ref())?;
    if probe.accessibility == Accessibility::PermissionDenied {
        return Err(format!("probe {}: {ACCESS}", shown(&probe.info)));
    }
    probe
        .info
        .open()
        .map_err(|error| unopened(&shown(&probe.info), &error))
}

fn selector(choice: &str) -> Result<DebugProbeSelector, String> {
    let expected = "expected VID:PID or VID:PID:SERIAL, such as 0483:374b";
    choice.parse().map_err(|_| format!("{choice}: {expected}"))
}

/// The only probe, of those that the selector takes.
fn only<'p>(
    all: &'p [ProbeListItem],
    selector: Option<&DebugProbeSelector>,
) -> Result<&'p ProbeListItem, String> {
    let taken: Vec<_> = all
        .iter()
        .filter(|probe| selector.is_none_or(|selector| selector.matches_probe(&probe.info)))
        .collect();
    match (&taken[..], selector) {
        (&[probe], _) => Ok(probe),
        ([], None) => Err(
            "no debug probe is attached: plug an ST-Link, a J-Link or a CMSIS-DAP probe into this computer".to_owned(),
        ),
        ([], Some(selector)) => Err(format!(
            "no debug probe {selector} is attached; {}",
            match all {
                [] => "nor any other".to_owned(),
                _ => format!("there is {}", list(all.iter())),
            }
        )),
        (several, _) => Err(format!(
            "several debug probes are attached: say `--probe VID:PID:SERIAL` with one of {}",
            list(several.iter().copied())
        )),
    }
}

fn list<'p>(probes: impl Iterator<Item = &'p ProbeListItem>) -> String {
    let shown: Vec<String> = probes.map(|probe| shown(&probe.info)).collect();
    shown.join(", ")
}

/// A probe as `--probe` takes it, with its name.
fn shown(probe: &DebugProbeInfo) -> String {
    format!("{} ({})", DebugProbeSelector::from(probe), probe.identifier)
}

/// Why a probe that is there could not be opened.
fn unopened(probe: &str, error: &(dyn Error + 'static)) -> String {
    let denied = causes(error)
        .filter_map(|cause| cause.downcast_ref::<io::Error>())
        .any(|cause| cause.kind() == io::ErrorKind::PermissionDenied);
    if denied {
        return format!("probe {probe}: {ACCESS}");
    }
    format!(
        "probe {probe} cannot be opened ({}): a probe has one program at a time; end `cargo flash-controller`, `probe-rs`, \
         OpenOCD or what else has it",
        reason(error)
    )
}

/// An error and what led to it.
fn causes<'e>(error: &'e (dyn Error + 'static)) -> impl Iterator<Item = &'e (dyn Error + 'static)> {
    std::iter::successors(Some(error), |&error| error.source())
}

/// An error in a line, with what led to it.
pub fn reason(error: &(dyn Error + 'static)) -> String {
    let mut causes: Vec<String> = causes(error).map(ToString::to_string).collect();
    // One that only hands on what led to it says the same.
    causes.dedup();
    causes.join(": ").replace('\n', " ")
}

#[cfg(test)]
mod tests {
    use probe_rs::probe::stlink::StLinkFactory;

    use super::*;

    fn attached(serials: &[&str]) -> Vec<ProbeListItem> {
        let probe = |serial: &&str| {
            let serial = Some((*serial).to_owned());
            let name = "STLink V2-1";
            let info =
                DebugProbeInfo::new(name, 0x0483, 0x374B, serial, &StLinkFactory, None, false);
            ProbeListItem::accessible(info)
        };
        serials.iter().map(probe).collect()
    }

    fn chosen(serials: &[&str], choice: Option<&str>) -> Result<String, String> {
        let selector = choice.map(|choice| selector(choice).unwrap());
        only(&attached(serials), selector.as_ref())
            .map(|probe| probe.info.serial_number.clone().unwrap())
    }

    #[test]
    fn the_only_probe_needs_no_name_and_one_of_several_does() {
        assert_eq!(chosen(&["A"], None), Ok("A".to_owned()));
        assert_eq!(chosen(&["A"], Some("0483:374b")), Ok("A".to_owned()));
        assert_eq!(chosen(&["A", "B"], Some("0483:374B:B")), Ok("B".to_owned()));
        for choice in [None, Some("0483:374b")] {
            let said = chosen(&["A", "B"], choice).unwrap_err();
            assert!(
                said.ends_with("0483:374b:A (STLink V2-1), 0483:374b:B (STLink V2-1)"),
                "{said}"
            );
        }
    }

    #[test]
    fn where_there_is_none_it_is_said_what_there_is() {
        let said = chosen(&[], None).unwrap_err();
        assert!(
            said.starts_with("no debug probe is attached: plug"),
            "{said}"
        );
        let said = chosen(&[], Some("0483:374b")).unwrap_err();
        assert_eq!(said, "no debug probe 0483:374b is attached; nor any other");
        let said = chosen(&["A"], Some("1366:0105")).unwrap_err();
        assert_eq!(
            said,
            "no debug probe 1366:0105 is attached; there is 0483:374b:A (STLink V2-1)"
        );
        let said = selector("jlink").unwrap_err();
        assert!(said.contains("expected VID:PID"), "{said}");
    }

    #[test]
    fn what_hinders_a_probe_is_said_with_what_to_do() {
        let denied = io::Error::from(io::ErrorKind::PermissionDenied);
        let error = probe_rs::probe::DebugProbeError::Usb(denied);
        assert!(unopened("0483:374b:A", &error).contains("udev rule"));
        let busy = io::Error::other("interface is busy");
        let error = probe_rs::probe::DebugProbeError::Usb(busy);
        let said = unopened("0483:374b:A", &error);
        assert!(said.contains("interface is busy"), "{said}");
        assert!(said.contains("end `cargo flash-controller`"), "{said}");
    }
}
