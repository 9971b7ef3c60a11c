//! The line through the logs' estimates, beside SciPy's; how often its intervals hold, and how often an alarm is false.

use host_tests::track::trend::{Estimate, FALSE_ALARMS, LEAST_LOGS, Line, OUTSIDE, Reach, holm};
use rig::Random;

fn estimates(rows: &[(f64, f64, f64)]) -> Vec<Estimate> {
    let estimate = |&(place, value, std): &(f64, f64, f64)| Estimate { place, value, std };
    rows.iter().map(estimate).collect()
}

#[track_caller]
fn near(value: f64, expected: f64) {
    let off = (value - expected).abs();
    assert!(off < 1e-9 * expected.abs().max(1e-3), "{value} {expected}");
}

/// Six logs whose scatter is above their standard errors. NumPy 2 and SciPy 1.17: weighted least squares, `brentq` for τ²,
/// `stats.t`, and `brentq` on Fieller's condition.
#[test]
fn the_line_is_that_of_scipy() {
    let rows = [
        (0.0, 0.118, 0.001),
        (1.0, 0.125, 0.002),
        (2.0, 0.121, 0.001),
        (3.0, 0.133, 0.004),
        (4.0, 0.131, 0.002),
        (5.0, 0.142, 0.001),
    ];
    let line = Line::through(&estimates(&rows), 5.0).unwrap();
    near(line.level, 0.138_983_829_638);
    near(line.slope, 0.004_349_507_158_16);
    near(line.scatter, 0.003_684_113_006);
    near(line.slope_interval().0, 0.001_747_530_418_5);
    near(line.slope_interval().1, 0.006_951_483_897_81);
    near(line.interval_at(5.0).0, 0.130_871_840_638);
    near(line.interval_at(5.0).1, 0.147_095_818_639);
    near(line.p_value(), 0.009_725_617_618_31);
    let limit = 0.166_780_595_565_960_16;
    let Reach::In { logs, interval } = line.reach(limit, 0.0) else {
        panic!("{:?}", line.reach(limit, 0.0));
    };
    near(logs.unwrap(), 6.390_785_189_43);
    near(interval.0, 2.937_411_164_73);
    near(interval.1.unwrap(), 19.809_058_667_1);
    assert_eq!(line.reach(0.138, 0.0), Reach::Reached);
    // Below where it was at first: a lower limit, from which it leads away for certain.
    assert_eq!(line.reach(0.1, 0.0), Reach::Never);
}

/// One log is missing in the middle, and no scatter shows: the logs' own errors remain. SciPy, as above.
#[test]
fn no_trend_has_no_end() {
    let rows = [
        (0.0, 1.0, 0.05),
        (1.0, 1.02, 0.04),
        (3.0, 0.97, 0.06),
        (4.0, 1.01, 0.05),
    ];
    let line = Line::through(&estimates(&rows), 5.0).unwrap();
    assert_eq!(line.scatter, 0.0);
    near(line.slope_interval().0, -0.070_530_496_312_8);
    near(line.interval_at(5.0).1, 1.236_762_366_481);
    near(line.p_value(), 0.876_584_511_542);
    let expected = Reach::In {
        logs: None,
        interval: (0.0, None),
    };
    assert_eq!(line.reach(1.195, 0.0), expected);
    // The slope may be zero, but the limit is outside of what the level may be now: not before some logs have passed.
    let rows = [1.0, 1.02, 0.97, 1.01, 1.06];
    let rows = rows
        .iter()
        .zip(0..)
        .map(|(&value, place)| (f64::from(place), value, 0.02));
    let line = Line::through(&estimates(&rows.collect::<Vec<_>>()), 4.0).unwrap();
    let Reach::In { logs, interval } = line.reach(1.5, 0.0) else {
        panic!("{:?}", line.reach(1.5, 0.0));
    };
    near(logs.unwrap(), 42.363_636_363_6);
    near(interval.0, 9.231_870_307_6);
    assert_eq!(interval.1, None);
}

#[test]
fn too_few_logs_have_no_line() {
    let rows = [(0.0, 1.0, 0.1), (1.0, 2.0, 0.1)];
    assert!(rows.len() < LEAST_LOGS);
    assert!(Line::through(&estimates(&rows), 1.0).is_none());
    let one_place = [(2.0, 1.0, 0.1), (2.0, 2.0, 0.1), (2.0, 1.5, 0.1)];
    assert!(Line::through(&estimates(&one_place), 2.0).is_none());
}

/// Holm's own order: 0.05/3, 0.05/2, 0.05, and nothing behind the first that fails.
#[test]
fn significant_is_what_holm_keeps() {
    let cases: [(&[f64], &[bool]); 4] = [
        (&[0.02, 0.01, 0.04], &[true, true, true]),
        (&[0.03, 0.01, 0.04], &[false, true, false]),
        (&[0.02, 0.02, 0.02], &[false, false, false]),
        (&[], &[]),
    ];
    for (p_values, expected) in cases {
        assert_eq!(holm(p_values, 0.05), expected, "{p_values:?}");
    }
}

/// A number of a machine over its logs: standard errors that differ fourfold, and scatter from log to log.
fn drawn(logs: usize, slope: f64, scatter: f64, random: &mut Random) -> Vec<Estimate> {
    let each = |place: usize| {
        let std = 0.5 * 4.0_f64.powf(random.uniform());
        let off = std * random.normal() + scatter * random.normal();
        let place = place as f64;
        Estimate {
            place,
            value: 100.0 + slope * place + off,
            std,
        }
    };
    (0..logs).map(each).collect()
}

const DRAWS: usize = 2000;

/// Three deviations of a share of [`DRAWS`].
fn chance(share: f64) -> f64 {
    3.0 * (share * (1.0 - share) / DRAWS as f64).sqrt()
}

const LOGS: [usize; 5] = [3, 4, 8, 20, 50];
const SCATTERS: [f64; 4] = [0.0, 0.5, 2.0, 10.0];

#[test]
fn intervals_hold_as_often_as_they_say() {
    let inside = 1.0 - OUTSIDE;
    for logs in LOGS {
        for scatter in SCATTERS {
            let mut random = Random::new(11 + logs as u64);
            let (mut of_slope, mut of_reach) = (0, 0);
            for _ in 0..DRAWS {
                let slope = 1.5;
                let last = (logs - 1) as f64;
                let line = Line::through(&drawn(logs, slope, scatter, &mut random), last).unwrap();
                let (low, high) = line.slope_interval();
                of_slope += usize::from((low..=high).contains(&slope));
                // The truth reaches it twenty logs after the last.
                let limit = 100.0 + slope * (last + 20.0);
                of_reach += usize::from(match line.reach(limit, 0.0) {
                    Reach::In {
                        interval: (from, to),
                        ..
                    } => from <= 20.0 && to.is_none_or(|to| to >= 20.0),
                    Reach::Reached | Reach::Never => false,
                });
            }
            let share = |count: usize| count as f64 / DRAWS as f64;
            println!(
                "{logs} logs, scatter {scatter}: slope {:.4}, reach {:.4}",
                share(of_slope),
                share(of_reach)
            );
            assert!(
                share(of_slope) > inside - chance(inside),
                "{logs} {scatter}"
            );
            assert!(
                share(of_reach) > inside - chance(inside),
                "{logs} {scatter}"
            );
        }
    }
}

#[test]
fn alarms_are_no_more_often_false_than_they_say() {
    for logs in LOGS {
        for scatter in SCATTERS {
            let mut random = Random::new(500 + logs as u64);
            let mut alarms = 0;
            for _ in 0..DRAWS {
                let numbers = (0..4).map(|_| {
                    let estimates = drawn(logs, 0.0, scatter, &mut random);
                    Line::through(&estimates, (logs - 1) as f64)
                        .unwrap()
                        .p_value()
                });
                let p_values: Vec<f64> = numbers.collect();
                alarms += usize::from(holm(&p_values, FALSE_ALARMS).contains(&true));
            }
            let share = alarms as f64 / DRAWS as f64;
            println!("{logs} logs, scatter {scatter}: {share:.4} false");
            assert!(
                share < FALSE_ALARMS + chance(FALSE_ALARMS),
                "{logs} {scatter}: {share}"
            );
        }
    }
}
