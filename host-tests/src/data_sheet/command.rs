//! The command line of `cargo hil machine`.

use std::path::{Path, PathBuf};

use super::derive::Derived;
use super::sheet::Sheet;
use super::text;
use crate::failure::Failure;
use crate::gap::declared;
use crate::machine::Machine;
use crate::outputs::{Kind, Outputs, print};

/// What `cargo hil machine` takes. A value that a data sheet has is a number with its unit, as in 5400rpm.
#[derive(Debug, clap::Args)]
pub struct Args {
    /// What the machine is called
    #[arg(long, default_value = "machine")]
    pub name: String,
    /// Where the numbers are from: a document and its number, or its address; a comment in the file
    #[arg(long, value_name = "TEXT")]
    pub source: Option<String>,
    /// Nominal voltage, at which speeds, currents and torques are given, as in 12V
    #[arg(long)]
    pub voltage: Option<String>,
    /// Speed without a load, as in 5400rpm; of a linear actuator as in 32mm/s, of a servo as in 0.16s/60deg
    #[arg(long, value_name = "SPEED")]
    pub no_load_speed: Option<String>,
    /// Current without a load, as in 150mA
    #[arg(long, value_name = "CURRENT")]
    pub no_load_current: Option<String>,
    /// Torque at standstill, as in 12mNm, 21kg.cm, 290oz.in; of a linear actuator as in 50N
    #[arg(long, value_name = "TORQUE")]
    pub stall_torque: Option<String>,
    /// Current at standstill, as in 5.5A
    #[arg(long, value_name = "CURRENT")]
    pub stall_current: Option<String>,
    /// Terminal resistance, as in 2.3ohm
    #[arg(long)]
    pub resistance: Option<String>,
    /// Terminal inductance, as in 0.31mH; without it none
    #[arg(long)]
    pub inductance: Option<String>,
    /// Torque constant, as in 29.2mNm/A
    #[arg(long, value_name = "CONSTANT")]
    pub torque_constant: Option<String>,
    /// Speed constant, as in 328rpm/V
    #[arg(long, value_name = "CONSTANT")]
    pub speed_constant: Option<String>,
    /// Back-EMF constant, as in 3.05mV/rpm
    #[arg(long, value_name = "CONSTANT")]
    pub back_emf_constant: Option<String>,
    /// Inertia of the rotor, at the motor's shaft, as in 67.9gcm2
    #[arg(long, value_name = "INERTIA")]
    pub rotor_inertia: Option<String>,
    /// Mechanical time constant of the motor alone, as in 5.4ms: gives the rotor's inertia
    #[arg(long, value_name = "TIME")]
    pub mechanical_time_constant: Option<String>,
    /// Sliding friction, as in 0.12mNm
    #[arg(long, value_name = "TORQUE")]
    pub friction_torque: Option<String>,
    /// Sliding friction behind the motor (gear, belt, screw, rail), measured at the coordinate, as in 5N or 20mNm; it is added to
    /// the motor's own
    #[arg(long, value_name = "TORQUE")]
    pub load_friction: Option<String>,
    /// Friction that has to be overcome before it moves
    #[arg(long, value_name = "TORQUE")]
    pub breakaway_torque: Option<String>,
    /// Viscous friction at the coordinate, as in 0.015Nms/rad
    #[arg(long, value_name = "FRICTION")]
    pub viscous: Option<String>,
    /// Turns of the motor for one of the output, as in 50 or 50:1
    #[arg(long, value_name = "RATIO")]
    pub gear_ratio: Option<String>,
    /// Efficiency of gear and screw together, as in 0.7 or 70%
    #[arg(long, value_name = "EFFICIENCY")]
    pub gear_efficiency: Option<String>,
    /// Way for a turn of the gear's output, as in 2mm (screw, rack, belt): the coordinate is then a stroke
    #[arg(long, value_name = "LENGTH")]
    pub screw_lead: Option<String>,
    /// Which shaft the data sheet's speeds, torques and constants are of: that of the motor alone, or of the gearmotor, behind the
    /// gear; the ratio need not be known then
    #[arg(long, value_name = "SIDE", value_parser = ["motor", "gearmotor"])]
    pub values_of: Option<String>,
    /// Inertia of the load at the coordinate, as in 2kg.cm2; along a stroke its mass
    #[arg(long, value_name = "INERTIA")]
    pub load_inertia: Option<String>,
    /// Mass of a load whose centre is not on the axis, so that gravity turns it, as in 490g
    #[arg(long, value_name = "MASS", requires = "pendulum_length")]
    pub pendulum_mass: Option<String>,
    /// From the axis to the centre of that mass, as in 10cm
    #[arg(long, value_name = "LENGTH", requires = "pendulum_mass")]
    pub pendulum_length: Option<String>,
    /// Where it hangs, as in -90deg; without it at 0
    #[arg(
        long,
        value_name = "ANGLE",
        requires = "pendulum_mass",
        allow_hyphen_values = true
    )]
    pub gravity_rest: Option<String>,
    /// Return spring at the coordinate, as in 0.087Nm/rad
    #[arg(long, value_name = "STIFFNESS")]
    pub spring: Option<String>,
    /// Where the spring rests, as in 8deg; without it at 0
    #[arg(long, value_name = "POSITION", allow_hyphen_values = true)]
    pub spring_rest: Option<String>,
    /// Torque with which the spring starts on either side of its rest
    #[arg(long, value_name = "TORQUE")]
    pub spring_preload: Option<String>,
    /// Lower end stop, as in -30deg or 0mm
    #[arg(long, value_name = "POSITION", allow_hyphen_values = true)]
    pub lower_stop: Option<String>,
    /// Upper end stop
    #[arg(long, value_name = "POSITION", allow_hyphen_values = true)]
    pub upper_stop: Option<String>,
    /// Counts of the encoder for a turn of its shaft, all edges counted, as in 64
    #[arg(long, value_name = "COUNTS", requires = "encoder_side")]
    pub encoder_counts: Option<String>,
    /// Which shaft the encoder sits on: the motor's, or the load's behind gear (and before a screw)
    #[arg(long, value_name = "SIDE", value_parser = ["motor", "load"])]
    pub encoder_side: Option<String>,
    /// Resolution of the position at the coordinate instead, as in 0.088deg or 10um
    #[arg(long, value_name = "POSITION", conflicts_with = "encoder_counts")]
    pub resolution: Option<String>,
    /// What the log's `input` is: V, mV, duty (-1 to 1), %, or duty/255 (so many for the whole supply)
    #[arg(long, default_value = "V")]
    pub input: String,
    /// Supply voltage at a duty of 1 or 100 %; without it the nominal voltage
    #[arg(long, value_name = "VOLTAGE")]
    pub supply: Option<String>,
    /// The logs have a measured current: resistance and torque constant are fitted too, within their tolerance
    #[arg(long)]
    pub measured_current: bool,
    /// Write the machine file here instead of to standard output
    #[arg(long, value_name = "M.toml")]
    pub out: Option<PathBuf>,
}

/// What the options mean together, for the help.
pub const SHEET_HELP: &str = "\
Units: V mV; A mA; ohm kohm; mH uH; rpm rad/s mm/s s/60deg; Nm mNm Ncm kg.cm g.cm oz.in lb.in N kgf; mNm/A oz.in/A;
rpm/V; mV/rpm V/krpm; g.cm2 kg.cm2 kg.m2 oz.in2 kg; ms; deg rad mm; Nms/rad; Nm/rad N/mm.

What is needed                one of
  winding's resistance        --resistance; --stall-current and --voltage; --voltage, --no-load-speed and
                              --stall-torque (behind a gear with --gear-efficiency)
  torque constant             --torque-constant; --speed-constant; --back-emf-constant; --voltage and
                              --no-load-speed; --stall-torque and the current at standstill
  friction                    --no-load-current; --friction-torque; else guessed from the current at standstill;
                              beside either --load-friction
  rotor's inertia             --rotor-inertia; --mechanical-time-constant; else guessed from a time constant
Numbers that say the same twice are compared. They are refused if they differ by more than 10 %, which makers
allow their motors, and what was rounded away: half a unit of the last digit, zeros at a number's end not counted.
Every number in the file says where it comes from and how sure it is.";

/// Prints the machine file, or writes it.
///
/// # Errors
/// A wrong call, before anything is written: numbers that are none, that contradict each other, or that are
/// too few. A file that cannot be written.
pub fn run(args: &Args) -> Result<(), Failure> {
    let mut outputs = Outputs::reading([]);
    let out = outputs.file(args.out.as_deref(), Kind::Marked)?;
    let text = text_of(args).map_err(Failure::Usage)?;
    let Some(out) = out else {
        return print(&text);
    };
    outputs.stage(out, text)?;
    outputs.commit()
}

/// The machine file.
///
/// # Errors
/// As [`run`], in one line.
pub fn text_of(args: &Args) -> Result<String, String> {
    let sheet = Sheet::read(args)?;
    let derived = Derived::of(&sheet)?;
    let text = text::render(args, &sheet, &derived);
    // What is printed can be read, whatever the numbers are: of single precision they may ask too much.
    let path = Path::new("the machine file of these numbers");
    let machine = Machine::of_bytes(path, text.clone().into_bytes());
    machine
        .and_then(|machine| declared::model(&machine))
        .map_err(|error| format!("these numbers make no machine: {}", error.message))?;
    Ok(text)
}
