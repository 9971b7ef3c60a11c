//! What a log of a world is: rows, delays, the logger's sins.

use std::f64::consts::TAU;

use super::plant::axis;
use crate::random::Random;
use crate::world::control::Drive;
use crate::world::{InputRow, Law, Machine, Motion, Quality, Record, Scene, Sins, play};

fn drive(machine: &Machine) -> Drive {
    let mut drive = Drive::draw(&mut Random::new(1), machine, (1e-3, 0.0, 4.0), 1.0);
    drive.kind = crate::world::DriveKind::Pid;
    drive.motion = Motion::Sines(vec![[1.0, TAU, 0.0]]);
    drive
}

fn recorded(laws: &[Law], sins: Sins) -> Record {
    let machine = Machine {
        coulomb: 0.1,
        breakaway: 0.12,
        resolution: 1e-6,
        ..axis()
    };
    play(&Scene {
        machine: &machine,
        laws,
        drive: &drive(&machine),
        quality: Quality {
            position_noise: 0.0,
            current_noise: None,
            velocity_noise: None,
            filter: 0.0,
        },
        sins,
        rate: 1e3,
        rows: 3000,
        seed: 1,
    })
}

#[test]
fn the_loop_follows_its_command() {
    let record = recorded(&[], Sins::NONE);
    let late = record.time.iter().zip(&record.true_position).skip(1000);
    let worst = late
        .map(|(time, place)| (place - (TAU * time).sin()).abs())
        .fold(0.0, f64::max);
    assert!(worst < 0.3, "{worst}");
    assert_eq!(record.saturated, 0.0);
}

/// The acceleration of a row follows from the input of the row, or from the one of so many rows before.
#[test]
fn a_late_input_acts_later_by_its_delay() {
    for (seconds, whole, share) in [(0.0, 0, 0.0), (2.5e-3, 2, 0.5)] {
        let law = Law::InputDelay { seconds };
        let record = recorded(&[law], Sins::NONE);
        let mut worst = 0.0_f64;
        for row in 1000..2900 {
            let (before, after) = (record.true_velocity[row], record.true_velocity[row + 1]);
            if before.abs() < 0.5 || before * after < 0.0 {
                continue;
            }
            let input = |back: usize| record.input[row - back];
            let mean = (1.0 - share) * input(whole) + share * input(whole + 1);
            let expected = (mean - 0.1 * before.signum()) / 0.01 * 1e-3;
            worst = worst.max((after - before - expected).abs());
        }
        assert!(worst < 1e-6, "{seconds}: {worst}");
    }
}

#[test]
fn a_late_sensor_reports_what_was() {
    let law = Law::SensorDelay { seconds: 3.25e-3 };
    let record = recorded(&[law], Sins::NONE);
    for row in 1000..2900 {
        let (now, next) = (record.true_position[row - 4], record.true_position[row - 3]);
        let expected = now + 0.75 * (next - now);
        // Between the rows the path is bent by a few parts in a million.
        assert!((record.position[row] - expected).abs() < 2e-5, "{row}");
    }
}

#[test]
fn loggers_sin_as_they_say() {
    let good = recorded(&[], Sins::NONE);
    let late = recorded(
        &[],
        Sins {
            input: InputRow::RowLate,
            ..Sins::NONE
        },
    );
    assert_eq!(late.input[101], good.input[100]);
    assert_eq!(late.position, good.position);

    let fast = Sins {
        corrections: 4,
        input: InputRow::Averaged,
        ..Sins::NONE
    };
    let fast = recorded(&[], fast);
    assert_eq!(fast.time.len(), 3000);
    assert!((fast.time[1000] - 1.0).abs() < 1e-9);

    let shaken = Sins {
        jitter: 0.2,
        dropped: 0.01,
        glitch: true,
        ..Sins::NONE
    };
    let shaken = recorded(&[], shaken);
    assert!((2930..2995).contains(&shaken.time.len()));
    assert!(shaken.time.windows(2).all(|pair| pair[1] > pair[0]));
    let off = shaken.position.iter().zip(&shaken.true_position);
    let wrong = off.filter(|(seen, is)| (*seen - *is).abs() > 0.05).count();
    assert_eq!(wrong, 1);
}

#[test]
fn a_log_reads_as_a_users_file() {
    let record = recorded(&[], Sins::NONE);
    let text = record.to_csv();
    let mut lines = text.lines();
    assert_eq!(lines.next(), Some("time_s,input,position"));
    assert_eq!(lines.clone().count(), 3000);
    let first: Vec<f64> = lines
        .next()
        .unwrap_or_default()
        .split(',')
        .filter_map(|field| field.parse().ok())
        .collect();
    assert_eq!(first.len(), 3);
}
