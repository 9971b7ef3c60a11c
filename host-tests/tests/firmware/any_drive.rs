//! Any drive: an actuator within its tolerances, with a load, a noisy current sensor and any supply, and what it is told.

use firmware::app::fault::observer::Tolerances;
use firmware::app::machine::{EMA, Machine};
use host_tests::operation_on_host::{Drop, Motor, OperationOnHost, SharedFlash};
use model_core::numeric::random::Random;
use model_core::plant::Directional;
use model_core::plant::parameters::{Drive, Parameters};

/// How far the actuator may be from what is declared.
pub const TOLERANCES: Tolerances = Tolerances::INDUSTRIAL;

/// Resistance, inductance and torque constant of the declared winding.
pub const fn winding() -> [f32; 3] {
    winding_of(&EMA)
}

/// Those of a machine's winding.
pub const fn winding_of(machine: &Machine) -> [f32; 3] {
    match machine.plant.drive {
        Drive::Voltage {
            resistance,
            inductance,
            torque_constant,
        } => [resistance, inductance, torque_constant],
        Drive::Torque => panic!("the actuator has a winding"),
    }
}

/// Evenly from −1 to 1.
pub fn either_way(random: &mut Random) -> f32 {
    2.0 * random.uniform() - 1.0
}

/// An actuator somewhere within the declared tolerances, with a load.
pub fn any_actuator(random: &mut Random) -> Parameters {
    let [resistance, inductance, torque_constant] = winding();
    let mut off = |share: f32| 1.0 + share * either_way(random);
    let drive = Drive::Voltage {
        resistance: resistance * off(TOLERANCES.resistance),
        inductance: inductance * off(TOLERANCES.inductance),
        torque_constant: torque_constant * off(TOLERANCES.torque_constant),
    };
    let inertia = EMA.plant.inertia * off(TOLERANCES.inertia);
    let friction = off(TOLERANCES.mechanics);
    let scaled = |level: Directional| Directional::both(level.forward * friction);
    let stroke = EMA.plant.upper_stop - EMA.plant.lower_stop;
    let mut moved = || TOLERANCES.stop * stroke * either_way(random);
    Parameters {
        drive,
        inertia,
        viscous: scaled(EMA.plant.viscous),
        coulomb: scaled(EMA.plant.coulomb),
        breakaway: scaled(EMA.plant.breakaway),
        lower_stop: EMA.plant.lower_stop + moved(),
        upper_stop: EMA.plant.upper_stop + moved(),
        offset: EMA.limits.load * either_way(random),
        ..EMA.plant
    }
}

/// Any drop between bridge and winding, within what [`Tolerances::INDUSTRIAL`] is made of.
pub fn any_drop(random: &mut Random) -> Drop {
    Drop {
        dead_time: TOLERANCES.dead_time * random.uniform(),
        brushes: TOLERANCES.brushes * random.uniform(),
        ..Drop::default()
    }
}

/// A winding whose temperature changes, and that of its magnets with it.
pub struct Warming {
    /// Resistance and torque constant.
    numbers: [f32; 2],
    /// By which share they change in a second.
    rates: [f32; 2],
}

impl Warming {
    /// Of a motor that has any winding within its tolerances from here on.
    pub fn any(motor: &mut Motor, random: &mut Random) -> Self {
        let numbers = BOUNDS.map(|[low, high]| low + (high - low) * random.uniform());
        let mut warming = Self {
            numbers,
            rates: [0.0; 2],
        };
        warming.step(motor, 0.0);
        warming
    }

    /// From now on by any rate that there is. Copper has 0.393 % more a kelvin, ferrite magnets 0.2 % less.
    pub fn turn(&mut self, random: &mut Random) {
        let rate = WARMING * either_way(random);
        self.rates = [0.00393 * rate, -0.002 * rate];
    }

    /// Goes on for some seconds, within the tolerances.
    pub fn step(&mut self, motor: &mut Motor, seconds: f32) {
        for ((number, rate), [low, high]) in self.numbers.iter_mut().zip(self.rates).zip(BOUNDS) {
            *number = (*number * (1.0 + rate * seconds)).clamp(low, high);
        }
        motor.warm(self.numbers);
    }
}

/// How fast a winding warms or cools at most, K/s: copper that keeps the heat of 85 % of the peak current, where the continuous one has
/// 15 A/mm², which is an assumption.
const WARMING: f32 = {
    let density = 15e6 * 0.85 * EMA.limits.peak_current / EMA.limits.continuous_current;
    let heat = 2.3e-8 * density * density;
    heat / (8.89e3 * 385.0)
};

/// Where resistance and torque constant lie.
const BOUNDS: [[f32; 2]; 2] = {
    let [resistance, _, torque_constant] = winding();
    let [r, k] = [TOLERANCES.resistance, TOLERANCES.torque_constant];
    [
        [(1.0 - r) * resistance, (1.0 + r) * resistance],
        [(1.0 - k) * torque_constant, (1.0 + k) * torque_constant],
    ]
};

/// A command of any kind in either mode, weak or strong.
pub fn any_command(random: &mut Random) -> (&'static str, String) {
    let (mode, most) = if random.uniform() < 0.6 {
        ("mode position", 1.0)
    } else {
        ("mode voltage", 24.0)
    };
    let mut value = || {
        let strength = random.uniform();
        most * strength * either_way(random)
    };
    let (first, second) = (value(), value());
    let frequency = 0.5 + 9.5 * random.uniform();
    let line = match (random.uniform() * 5.0) as u32 {
        0 | 1 => format!("step {first} {second} {}", 0.1 * random.uniform()),
        2 => format!("ramp {first} {second} {}", 0.01 + random.uniform()),
        3 => format!("sine 0 {first} {frequency}"),
        _ => format!("triangle {} {} {frequency}", 0.5 * first, 0.5 * second),
    };
    (mode, line)
}

/// The image in this flash, that drives it, and knows where it is.
pub fn image(flash: &SharedFlash, random: &mut Random) -> OperationOnHost<Motor> {
    let mut image = started(flash, random);
    perform(&mut image, &["zero"]);
    image
}

/// The same behind its start.
pub fn started(flash: &SharedFlash, random: &mut Random) -> OperationOnHost<Motor> {
    let actuator = any_actuator(random);
    let mut image = OperationOnHost::controller(flash, &actuator);
    image.plant.noise = Some(Random::new(random.bits().into(), 2));
    image.plant.supply = 20.0 + 9.0 * random.uniform();
    image.run_ms(20);
    image
}

/// Lines that must be done.
pub fn perform(image: &mut OperationOnHost<Motor>, lines: &[&str]) {
    for line in lines {
        assert_eq!(image.line(line), "ok", "{line}");
    }
}

/// How often the actuator turns round in so many milliseconds, by more than ten counts of the encoder each time.
pub fn turns(image: &mut OperationOnHost<Motor>, milliseconds: u32) -> u32 {
    let least = 10.0 * EMA.converters.position.unit();
    let mut farthest = image.plant.state.position.value();
    let (mut way, mut turns) = (0.0_f32, 0);
    for _ in 0..milliseconds {
        image.run_ms(1);
        let moved = image.plant.state.position.value() - farthest;
        if moved.abs() > least && moved * way < 0.0 {
            turns += 1;
        }
        if moved.abs() > least {
            way = moved.signum();
        }
        if moved.abs() > least || moved * way > 0.0 {
            farthest += moved;
        }
    }
    turns
}
