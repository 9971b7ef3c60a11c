//! What a fuzzer does with the readers of users' files: any bytes give a sound result or a clear error.
//! The console has its own, [`console_on_host::exercise`](crate::console_on_host::exercise).

use std::path::Path;

use crate::board_log::BoardLog;
use crate::error::InputError;
use crate::gap::declared;
use crate::log::Log;
use crate::machine::Machine;
use crate::printed_log;

/// Name of the file that there is not.
const FILE: &str = "bytes";

/// Reads bytes as a log.
///
/// # Panics
/// If the log is not what every log is, or the error is none that helps.
pub fn log(bytes: &[u8]) {
    let log = match Log::of_bytes(Path::new(FILE), bytes.to_vec()) {
        Ok(log) => log,
        Err(error) => return assert_helpful(&error, bytes),
    };
    let samples = log.samples();
    assert!(samples >= Log::MIN_SAMPLES);
    assert!(log.period_s > 0.0 && log.period_s.is_finite());
    assert!(log.start_s.is_finite() && log.time_s(samples - 1) > log.start_s);
    let optional = [
        &log.command,
        &log.current,
        &log.velocity,
        &log.brake,
        &log.load_torque,
        &log.enabled,
    ];
    let columns = [&log.input, &log.position].into_iter();
    for column in columns.chain(optional.into_iter().flatten()) {
        assert_eq!(column.len(), samples);
        assert!(column.iter().all(|value| value.is_finite()));
    }
}

/// Reads bytes as a machine file and builds its model.
///
/// # Panics
/// If a machine without a model has no error either, or the error is none that helps.
pub fn machine(bytes: &[u8]) {
    let machine = Machine::of_bytes(Path::new(FILE), bytes.to_vec());
    match machine.and_then(|machine| declared::model(&machine)) {
        // What is beyond the range of the core is refused by it.
        Ok(model) => drop(model.build(1e-3)),
        Err(error) => assert_helpful(&error, bytes),
    }
}

/// Looks at what bytes were decoded to as a board's log: each frame is a line or damaged, whatever it says. Reads
/// them as what probe-rs prints of one, too.
///
/// # Panics
/// If a frame is lost, or counted twice; if an error of the printed log is none that helps.
pub fn board_log(decoded: &BoardLog, bytes: &[u8]) {
    match printed_log::read(Path::new(FILE), bytes) {
        Ok(Some(printed)) => assert!(printed.log.lines.len() + printed.others <= bytes.len()),
        Ok(None) => {}
        Err(error) => assert_helpful(&error, bytes),
    }
    let frames = bytes.split_inclusive(|&byte| byte == 0);
    let sent = frames.filter(|&frame| frame != [0]).count();
    assert_eq!(decoded.lines.len() + decoded.damaged, sent);
    let recordings = decoded.recordings();
    let recorded: usize = recordings
        .iter()
        .map(|recording| recording.lines.len())
        .sum();
    assert_eq!(recorded, decoded.lines.len());
    for recording in recordings {
        recording.first_gap();
    }
}

/// One line that names the file, and a line of it if one.
fn assert_helpful(error: &InputError, bytes: &[u8]) {
    assert_eq!(error.file, Path::new(FILE));
    assert!(!error.message.is_empty() && !error.message.contains(['\n', '\r']));
    if let Some(line) = error.line {
        let ends = bytes.iter().filter(|&byte| matches!(byte, b'\n' | b'\r'));
        assert!((1..=ends.count() + 1).contains(&line), "{error}");
    }
}
