//! A Functional Mock-up Unit for co-simulation, FMI 2.0, around the very C text of the other target.

use std::fs;
use std::io::{Cursor, Write as _};
use std::path::Path;
use std::process::Command;

use zip::CompressionMethod;
use zip::write::{SimpleFileOptions, ZipWriter};

use super::{Missing, Source, c};
use crate::failure::Failure;
use crate::machine::Coordinate;
use crate::outputs::{MARK, defer_signals};

/// The interface around the model, with a place for the GUID.
const INTERFACE: &str = include_str!("fmi2.c");

/// Name of the library, and of the model in it.
const IDENTIFIER: &str = "actuator";

/// The platform's directory in an FMU and its library's suffix, where this host is one that the standard names.
const PLATFORM: Option<(&str, &str)> = if cfg!(all(target_os = "linux", target_arch = "x86_64")) {
    Some(("linux64", "so"))
} else if cfg!(all(target_os = "macos", target_arch = "x86_64")) {
    Some(("darwin64", "dylib"))
} else {
    None
};

/// The FMU, and what is not in it.
///
/// # Errors
/// A C compiler that refuses the text; a directory for it that cannot be made.
pub(super) fn archive(source: &Source) -> Result<(Vec<u8>, Vec<Missing>), Failure> {
    let (model, mut missing) = c::text(source);
    let guid = guid(&model);
    let interface = format!("/* {MARK} export */\n#define GUID \"{guid}\"\n{INTERFACE}");
    let library = library(&model, &interface)?;
    if library.is_none() {
        missing.push(Missing {
            line: None,
            what: "there is no library for this host (no C compiler `cc`, or a platform that FMI 2.0 does not name): the \
                   sources have to be compiled by the importing tool"
                .into(),
        });
    }
    let description = description(source, &guid, &missing);
    let mut files: Vec<(String, Vec<u8>)> = vec![
        ("modelDescription.xml".into(), description.into_bytes()),
        ("sources/model.c".into(), model.into_bytes()),
        ("sources/fmi2.c".into(), interface.into_bytes()),
    ];
    if let (Some(bytes), Some((platform, suffix))) = (library, PLATFORM) {
        files.push((format!("binaries/{platform}/{IDENTIFIER}.{suffix}"), bytes));
    }
    let packed = packed(&files).map_err(|error| Failure::system("the FMU", error))?;
    Ok((packed, missing))
}

/// As they are, without compression: the first is read again to know whose archive it is.
fn packed(files: &[(String, Vec<u8>)]) -> zip::result::ZipResult<Vec<u8>> {
    let options = SimpleFileOptions::default().compression_method(CompressionMethod::Stored);
    let mut archive = ZipWriter::new(Cursor::new(Vec::new()));
    for (name, bytes) in files {
        archive.start_file(name.as_str(), options)?;
        archive.write_all(bytes)?;
    }
    Ok(archive.finish()?.into_inner())
}

/// A name for exactly this text: the hash of Fowler, Noll and Vo, from two starts.
fn guid(text: &str) -> String {
    let hash = |start: u64| {
        text.bytes().fold(start, |hash, byte| {
            (hash ^ u64::from(byte)).wrapping_mul(0x0000_0100_0000_01b3)
        })
    };
    let (a, b) = (hash(0xcbf2_9ce4_8422_2325), hash(0x8422_2325_cbf2_9ce4));
    format!(
        "{{{:08x}-{:04x}-{:04x}-{:04x}-{:012x}}}",
        a >> 32,
        (a >> 16) & 0xffff,
        a & 0xffff,
        b >> 48,
        b & 0xffff_ffff_ffff
    )
}

/// The library, where there are a compiler and a platform for it.
fn library(model: &str, interface: &str) -> Result<Option<Vec<u8>>, Failure> {
    let Some((_, suffix)) = PLATFORM else {
        return Ok(None);
    };
    // A signal waits until the directory is gone.
    let _deferred = defer_signals();
    let directory = std::env::temp_dir().join(format!("cargo-hil-export-{}", std::process::id()));
    fs::create_dir(&directory).map_err(|error| Failure::system(directory.display(), error))?;
    let built = compile(&directory, model, interface, suffix);
    // What is left of it is in nobody's way.
    let _ = fs::remove_dir_all(&directory);
    built
}

/// The library; none where there is no compiler.
fn compile(
    directory: &Path,
    model: &str,
    interface: &str,
    suffix: &str,
) -> Result<Option<Vec<u8>>, Failure> {
    let failed = |error| Failure::system(directory.display(), error);
    fs::write(directory.join("model.c"), model).map_err(failed)?;
    fs::write(directory.join("fmi2.c"), interface).map_err(failed)?;
    let library = format!("{IDENTIFIER}.{suffix}");
    let options = [
        "-std=c99",
        "-O2",
        "-ffp-contract=off",
        "-fPIC",
        "-shared",
        "-fvisibility=hidden",
    ];
    let output = Command::new("cc")
        .current_dir(directory)
        .args(options)
        .args(["-o", &library, "fmi2.c", "-lm"])
        .output();
    let Ok(output) = output else {
        return Ok(None);
    };
    if !output.status.success() {
        let said = String::from_utf8_lossy(&output.stderr);
        return Err(Failure::other(format!("cc refuses the model: {said}")));
    }
    fs::read(directory.join(library)).map(Some).map_err(failed)
}

/// One variable of the model, in the order of the value references.
struct Variable {
    name: &'static str,
    description: &'static str,
    attributes: &'static str,
    unit: &'static str,
    start: Option<&'static str>,
}

const INPUT: &str = "causality=\"input\" variability=\"continuous\"";
const OUTPUT: &str = "causality=\"output\" variability=\"continuous\" initial=\"calculated\"";
const PARAMETER: &str = "causality=\"parameter\" variability=\"fixed\" initial=\"exact\"";

fn variables(source: &Source) -> [Variable; 7] {
    let (position, velocity, load) = match source.machine.coordinate {
        Coordinate::Radian => ("rad", "rad/s", "N.m"),
        Coordinate::Metre => ("m", "m/s", "N"),
    };
    // The gain is part of the model: only with a gain of 1 is the unit of the input that of what it drives.
    let input = match (source.machine.gain == 1.0, source.machine.motor) {
        (false, _) => "",
        (true, Some(_)) => "V",
        (true, None) => load,
    };
    let variable = |name, description, attributes, unit, start| Variable {
        name,
        description,
        attributes,
        unit,
        start,
    };
    [
        variable("input", "what the drive is told", INPUT, input, Some("0")),
        variable(
            "load_torque",
            "against positive motion",
            INPUT,
            load,
            Some("0"),
        ),
        variable("position", "of the drive", OUTPUT, position, None),
        variable("velocity", "of the drive", OUTPUT, velocity, None),
        variable(
            "current",
            "of the winding, 0 without one",
            OUTPUT,
            "A",
            None,
        ),
        variable(
            "reported",
            "position as its sensor reports it",
            OUTPUT,
            position,
            None,
        ),
        variable(
            "start_position",
            "brought within the end stops",
            PARAMETER,
            position,
            Some("0"),
        ),
    ]
}

const UNITS: &str = "  <UnitDefinitions>
    <Unit name=\"rad\"><BaseUnit rad=\"1\"/></Unit>
    <Unit name=\"rad/s\"><BaseUnit rad=\"1\" s=\"-1\"/></Unit>
    <Unit name=\"m\"><BaseUnit m=\"1\"/></Unit>
    <Unit name=\"m/s\"><BaseUnit m=\"1\" s=\"-1\"/></Unit>
    <Unit name=\"A\"><BaseUnit A=\"1\"/></Unit>
    <Unit name=\"V\"><BaseUnit kg=\"1\" m=\"2\" s=\"-3\" A=\"-1\"/></Unit>
    <Unit name=\"N\"><BaseUnit kg=\"1\" m=\"1\" s=\"-2\"/></Unit>
    <Unit name=\"N.m\"><BaseUnit kg=\"1\" m=\"2\" s=\"-2\"/></Unit>
  </UnitDefinitions>
";

/// `modelDescription.xml`.
fn description(source: &Source, guid: &str, missing: &[Missing]) -> String {
    let mut text = format!("<?xml version=\"1.0\" encoding=\"UTF-8\"?>\n<!-- {MARK} export -->\n");
    for missing in missing {
        text += &format!("<!-- NOT EXPRESSED: {} -->\n", missing.what);
    }
    text += &format!(
        "<fmiModelDescription fmiVersion=\"2.0\" modelName=\"{}\" guid=\"{guid}\" generationTool=\"cargo hil export\" \
         variableNamingConvention=\"flat\" numberOfEventIndicators=\"0\">\n  <CoSimulation modelIdentifier=\"{IDENTIFIER}\" \
         canHandleVariableCommunicationStepSize=\"true\" canGetAndSetFMUstate=\"true\">\n    <SourceFiles><File \
         name=\"fmi2.c\"/></SourceFiles>\n  </CoSimulation>\n{UNITS}  <ModelVariables>\n",
        source.name()
    );
    let variables = variables(source);
    for (reference, variable) in variables.iter().enumerate() {
        let attribute = |name: &str, value: &str| format!(" {name}=\"{value}\"");
        let unit = Some(variable.unit).filter(|unit| !unit.is_empty());
        text += &format!(
            "    <ScalarVariable name=\"{}\" valueReference=\"{reference}\" description=\"{}\" {}><Real{}{}/></ScalarVariable>\n",
            variable.name,
            variable.description,
            variable.attributes,
            unit.map_or(String::new(), |unit| attribute("unit", unit)),
            variable
                .start
                .map_or(String::new(), |start| attribute("start", start)),
        );
    }
    let outputs = variables
        .iter()
        .zip(1..)
        .filter(|(variable, _)| variable.attributes == OUTPUT);
    let unknowns: String = outputs
        .map(|(_, index)| format!("<Unknown index=\"{index}\"/>"))
        .collect();
    text + &format!(
        "  </ModelVariables>\n  <ModelStructure>\n    <Outputs>{unknowns}</Outputs>\n    \
         <InitialUnknowns>{unknowns}</InitialUnknowns>\n  </ModelStructure>\n</fmiModelDescription>\n"
    )
}
