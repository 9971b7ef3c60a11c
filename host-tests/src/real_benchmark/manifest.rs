//! Which measured logs are traced, and what is known of the devices behind them.
//!
//! None of the logs is part of the project. What is right was settled from the authors' papers, and from
//! spectra and scatter plots of the logs, before any of them was traced; it stands beside each row.

/// One device: its logs, how a user would declare it, and what an answer may say.
#[derive(Debug, Clone, Copy)]
pub struct Row {
    /// The device's name, and its directory among the logs.
    pub log: &'static str,
    /// Files to train on.
    pub train: &'static [&'static str],
    /// Files to validate on; where there are none the errors are those on the training logs.
    pub validate: &'static [&'static str],
    /// Its machine file, below `host-tests/machines/measured`.
    pub machine: &'static str,
    /// What is known, in a sentence.
    pub known: &'static str,
    /// What must be named: of each set one effect, or a class that it is in. Empty where nothing is plain
    /// in these logs.
    pub needed: &'static [&'static [&'static str]],
    /// What may be named beside it.
    pub tolerated: &'static [&'static str],
    /// Ripples of a `cogging` that are there, in a turn; another period is another effect. Empty where no
    /// cogging is known.
    pub per_turn: &'static [f64],
}

/// All of them.
pub const ROWS: [Row; 6] = [
    // The authors (Extended Friction Models, 2025) reject a constant friction for all servos of the kind
    // and need its growth with the load and a Stribeck curve. A regression of the winding's torque over
    // 0.3 rad/s leaves 29 % with a constant friction and 22 % with one that grows with the gravity torque,
    // by 0.43 of it. A Stribeck curve alone gains nothing there, but below that speed nothing was
    // regressed. So either is right, and both are. The supply is known to sag by 3 %.
    Row {
        log: "xl330",
        train: &["train-sines.csv", "train-up-and-down.csv"],
        validate: &["validate-chirp.csv"],
        machine: "xl330.toml",
        known: "friction that grows with the load, and a Stribeck curve; the supply sags by 3 %",
        needed: &[&["load_dependent_friction", "stribeck"]],
        tolerated: &["load_dependent_friction", "stribeck", "supply_sag"],
        per_turn: &[],
    },
    // 0.032 N·m of friction forward and 0.010 backward, but these logs turn forward only, where both of
    // these are the fitted Coulomb level: naming the asymmetry is not needed, and no mistake. Under a
    // constant torque the speed still wanders: it falls by 1.4 % over the last four seconds of the
    // validation, while it rose for as long on the training log. So a drift is tolerated. The input steps
    // at 10 s and no load does.
    Row {
        log: "hsm",
        train: &["train.csv"],
        validate: &["validate.csv"],
        machine: "hsm.toml",
        known: "friction differs by direction, but both logs turn one way; no external load",
        needed: &[],
        tolerated: &["asymmetric_coulomb", "offset_torque", "friction_drift"],
        per_turn: &[],
    },
    // With a fourth-order polynomial in the angle taken out, 200 a turn is the largest line of the torque:
    // 0.66 and 0.43 of what is left at 5 °/s, 0.1 and 0.4 at 10 °/s. At 20 °/s it hardly shows, and 361 and
    // 120 a turn have 0.3 and 0.15; nobody has said what these would be, so that they do not count. Friction
    // differs by direction, but every log moves from hanging upwards, so that naming this is not needed.
    // There is no gear and no shaft.
    Row {
        log: "cicese",
        train: &["train-5.csv", "train-10.csv", "train-20.csv"],
        validate: &["validate-5.csv", "validate-10.csv", "validate-20.csv"],
        machine: "cicese.toml",
        known: "a torque ripple of 200 a turn; friction differs by direction; no elastic shaft",
        needed: &[&["cogging"]],
        tolerated: &["cogging", "asymmetric_coulomb", "offset_torque"],
        per_turn: &[200.0],
    },
    // Lines of the current over the angle: 7 a turn with 0.76 of its variance, then its multiples, and 12.
    Row {
        log: "odrive",
        train: &["slow.csv"],
        validate: &["slow-resampled-validate.csv"],
        machine: "odrive.toml",
        known: "cogging of 7, 14, 28 a turn",
        needed: &[&["cogging"]],
        tolerated: &["cogging"],
        per_turn: &[7.0, 12.0, 14.0, 21.0, 28.0, 35.0, 42.0, 49.0],
    },
    // Lines of the current over the angle: 72 a turn with 0.37 of its variance, 144 with 0.03, 18 with 0.02.
    Row {
        log: "laas",
        train: &["speed.csv"],
        validate: &[],
        machine: "laas.toml",
        known: "cogging of 72 a turn",
        needed: &[&["cogging"]],
        tolerated: &["cogging"],
        per_turn: &[18.0, 36.0, 72.0, 144.0, 216.0],
    },
    // Friction and breakaway are published and declared. The breakaway is over twice the Coulomb level,
    // and how it falls to it is a Stribeck curve; in these logs the machine breaks away once.
    Row {
        log: "kinova",
        train: &["train-0.30.csv", "train-0.70.csv"],
        validate: &["validate-0.50.csv"],
        machine: "kinova.toml",
        known: "nothing beyond Coulomb, viscous friction and a breakaway of twice the Coulomb level",
        needed: &[],
        tolerated: &["stribeck"],
        per_turn: &[],
    },
];
