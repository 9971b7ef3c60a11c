//! Units, factors, signs.

use super::*;
use rig::{Experiment, Trajectory};

/// Every column of a log at once, each with a unit of its own.
#[test]
fn every_column_becomes_si() {
    let raw = rows("t,pos,duty,i,w,soll,b,l,en", 200, |k| {
        let k = k as f64;
        let on = if k < 100.0 { "on" } else { "off" };
        format!(
            "{k},{},{},{},{},{},{k},{k},{on}",
            0.9 * k,
            k / 2.0,
            10.0 * k,
            3.0 * k,
            k
        )
    });
    let place = Place::with("raw.csv", raw);
    let (log, said) = place.import(
        "raw.csv --time t:ms --position pos:deg --input duty:%*12 --current i:mA --velocity w:rpm \
         --command -soll:rev --brake b:mN·m --load-torque l:Ncm*-1+2 --enabled en",
    );
    assert_eq!((log.samples(), log.period_s, log.start_s), (200, 1e-3, 0.0));
    near(&log.position, |k| 0.9 * k as f64 * PI / 180.0);
    near(&log.input, |k| k as f64 / 200.0 * 12.0);
    near(&log.current.unwrap(), |k| k as f64 / 100.0);
    near(&log.velocity.unwrap(), |k| 3.0 * k as f64 * TAU / 60.0);
    near(&log.command.unwrap(), |k| -TAU * k as f64);
    near(&log.brake.unwrap(), |k| k as f64 * 1e-3);
    near(&log.load_torque.unwrap(), |k| 2.0 - k as f64 * 1e-2);
    near(&log.enabled.unwrap(), |k| f64::from(u8::from(k < 100)));
    assert!(said.contains("200 samples at 1000 Hz"), "{said}");
    assert!(said.contains("none was resampled"), "{said}");
}

#[test]
fn units_of_time_counts_and_strokes_have_their_factors() {
    let raw = rows("t,x,u", 200, |k| format!("{k},{},{}", 8 * k, k % 7));
    let place = Place::with("raw.csv", raw);
    for (unit, period) in [
        ("s", 1.0),
        ("ms", 1e-3),
        ("us", 1e-6),
        ("µs", 1e-6),
        ("ns", 1e-9),
    ] {
        let (log, _) = place.import(&format!("raw.csv --time t:{unit} --position x --input u"));
        assert!(
            (log.period_s / period - 1.0).abs() < 1e-9,
            "{unit}: {}",
            log.period_s
        );
    }
    for (unit, factor) in [
        ("counts/4096", TAU / 4096.0),
        ("counts*0.5", 0.5),
        ("mm", 1e-3),
        ("um", 1e-6),
        ("rev", TAU),
        ("rad", 1.0),
        ("°", PI / 180.0),
    ] {
        let (log, _) = place.import(&format!(
            "raw.csv --time 1:ms --position 2:{unit} --input 3:mV"
        ));
        near(&log.position, |k| 8.0 * k as f64 * factor);
        near(&log.input, |k| (k % 7) as f64 * 1e-3);
    }
    for (unit, factor) in [("rev/s", TAU), ("deg/s", PI / 180.0), ("mm/s", 1e-3)] {
        let words = "raw.csv --time t:ms --position x --input u --velocity x";
        let (log, _) = place.import(&format!("{words}:{unit}"));
        near(&log.velocity.unwrap(), |k| 8.0 * k as f64 * factor);
    }
}

/// Nanoseconds since 1970 are more than a log's time can be.
#[test]
fn a_calendar_becomes_a_time_from_zero() {
    let raw = rows("stamp,u,x", 300, |k| {
        format!(
            "{},{},{}",
            1_790_000_000_000_000_000_u64 + 1_000_000 * k as u64,
            k,
            k * k
        )
    });
    let place = Place::with("raw.csv", raw);
    let (log, said) = place.import("raw.csv --time stamp:ns --input u --position x");
    assert_eq!((log.start_s, log.samples()), (0.0, 300));
    assert!((log.period_s / 1e-3 - 1.0).abs() < 1e-6);
    assert!(said.contains("starts at zero"), "{said}");
}

#[test]
fn a_column_that_looks_like_another_unit_is_pointed_out() {
    let raw = rows("t,pos,u,i,w,T [ms]", 400, |k| {
        let t = k as f64;
        let angle = 170.0 * (0.01 * t).sin();
        // Milliseconds, degrees, per cent, milliamperes, and rpm of the degrees' radians.
        let rpm = 170.0 * 10.0 * (0.01 * t).cos();
        format!(
            "{t},{angle},{},{},{rpm},{t}",
            90.0 * (0.02 * t).cos(),
            900.0 * (0.03 * t).sin()
        )
    });
    let place = Place::with("raw.csv", raw);
    let words = "raw.csv --position pos --input u --current i --velocity w";
    let (_, said) = place.import(&format!("{words} --time t"));
    for hint in [
        "--time \"t:ms\"",
        "--position \"pos:deg\"",
        "--input \"u:%*12\" (put the volts of your supply in place of 12)",
        "--current \"i:mA\"",
    ] {
        assert!(said.contains(hint), "{hint}: {said}");
    }
    let (_, said) = place.import(&format!("{words} --time T~[ms]"));
    assert!(
        said.contains("the file says so: then --time \"T [ms]:ms\""),
        "{said}"
    );
    // In milliseconds the velocity is nine and a half times what the position, in radians, does.
    let rpm = rows("t,pos,u,w", 400, |k| {
        let t = 1e-3 * k as f64;
        format!(
            "{t:.3},{},5,{}",
            (9.0 * t).sin(),
            9.0 * (9.0 * t).cos() * 60.0 / TAU
        )
    });
    place.write("rpm.csv", rpm);
    let given = "rpm.csv --time t --position pos --input u --velocity w";
    let (_, said) = place.import(given);
    assert!(said.contains("--velocity \"w:rpm\""), "{said}");
    assert!(!said.contains("--position \""), "{said}");
    // What was given a unit is not doubted.
    let (_, said) = place.import(&format!("{given}:rpm"));
    assert!(!said.contains("Look again"), "{said}");
}

/// What a file says of a share and of counts is pointed out, and counts of a PWM are seen by their name and size.
#[test]
fn shares_and_counts_are_pointed_out() {
    let raw = rows("t,Winkel [counts],PWM,motor_duty", 300, |k| {
        format!("{k},{},{},0.5", k / 2, (k % 400) as i64 - 200)
    });
    let place = Place::with("raw.csv", raw);
    let (_, said) = place.import("raw.csv --time t:ms --position Winkel --input PWM");
    for hint in [
        "--position \"Winkel [counts]:counts*0.001\" (put the size of a count in place of 0.001)",
        "whole and reach 200: then --input \"PWM/255:duty*12\" (255 being the most; put the volts of your supply in place of 12)",
    ] {
        assert!(said.contains(hint), "{hint}: {said}");
    }
    let (_, said) = place.import("raw.csv --time t:ms --position Winkel:deg --input motor_duty");
    let hint = "the file says so: then --input \"motor_duty:duty*12\" (put the volts of your supply in place of 12)";
    assert!(said.contains(hint), "{said}");
}

/// What the file says of its columns is not passed over because the user says otherwise.
#[test]
fn a_unit_or_a_name_that_contradicts_the_call_is_pointed_out() {
    let numbers = rows(
        "Time\tRef\tU_cmd\tPhi\ttheta_m\n[s]\t[rad]\t[V]\t[rad]\t",
        200,
        |k| {
            let angle = (0.05 * k as f64).sin();
            format!(
                "{}\t{angle}\t{}\t{angle}\t{angle}",
                1e-3 * k as f64,
                9.0 * angle
            )
        },
    );
    let place = Place::with("raw.tsv", numbers);
    for (columns, hint) in [
        (
            "--position Phi:deg --input U_cmd",
            "Look again: `position` was given in deg, and the file says that Phi is in rad: then --position \"Phi:rad\"",
        ),
        (
            "--position U_cmd --input Phi:V",
            "Look again: `position` is read from U_cmd, which the file says is in V: check that it is the right column",
        ),
        (
            "--position Phi --input Phi:V",
            "Look again: `input` was given in V, and the file says that Phi is in rad: check that it is the right column",
        ),
        (
            "--position Ref --input U_cmd",
            "Look again: `position` is read from Ref, which by its name is the position asked for",
        ),
    ] {
        let (_, said) = place.import(&format!("raw.tsv --time Time {columns}"));
        assert!(said.contains(hint), "no {hint:?} in {said}");
        assert!(said.contains("log.csv was written"), "{said}");
    }
    // A letter behind a name is a part of it more often than a unit; and who multiplies knows the unit.
    for columns in [
        "--position theta_m:rad --input U_cmd:V",
        "--position U_cmd*0.5 --input U_cmd",
        "--position -Phi:rad --input U_cmd",
    ] {
        let (_, said) = place.import(&format!("raw.tsv --time Time {columns}"));
        assert!(!said.contains("Look again"), "{said}");
    }
}

/// A name is found without the unit that stands behind it, in brackets or not.
#[test]
fn a_unit_behind_a_name_need_not_be_written() {
    let raw = rows("Zeit ms;Encoder;PWM %;U1 [V]", 200, |k| {
        format!("{k};{};{};{}", 3 * k, k % 60, k % 60)
    });
    let place = Place::with("raw.csv", raw);
    let (log, said) =
        place.import("raw.csv --time Zeit:ms --position Encoder:counts/64/70 --input PWM:%*12");
    assert_eq!((log.samples(), log.period_s), (200, 1e-3));
    near(&log.position, |k| 3.0 * k as f64 * TAU / 64.0 / 70.0);
    near(&log.input, |k| (k % 60) as f64 / 100.0 * 12.0);
    assert!(said.contains("Zeit ms"), "{said}");
}

/// A share of nothing and counts of no size would pass as volts and radians.
#[test]
fn a_share_needs_its_supply_and_counts_need_a_size() {
    let place = Place::with(
        "raw.csv",
        rows("t,x,u", 200, |k| format!("{k},{},{}", 8 * k, k % 7)),
    );
    let call = |position: &str, input: &str| {
        format!("import raw.csv --time t:ms --position {position} --input {input} --out log.csv")
    };
    for input in ["u:%", "u:duty", "-u:%", "u:%+3"] {
        place.refuses(
            &call("x:deg", input),
            &["--input", "voltage is missing", ":", "*12"],
        );
    }
    place.refuses(
        &call("x:counts", "u:V"),
        &["--position", "x:counts/4096", "x:counts*0.001"],
    );
    place.refuses(&call("x:deg", "u:counts"), &["--input", "u:counts*0.001"]);
    for (position, input) in [
        ("x:counts/4096", "u:%*12"),
        ("x:counts*0.5", "u/255:duty*24"),
        ("x", "u:%*1"),
    ] {
        let output = place.run(&call(position, input));
        assert!(output.status.success(), "{}", text(&output.stderr));
        fs::remove_file(place.path("log.csv")).unwrap();
    }
}

/// The log is compared with the machine file that is given.
#[test]
fn a_log_is_checked_against_the_machine() {
    let machine = Machine::rotary_ema();
    let moves = Trajectory::moves(&machine);
    let log = Experiment::tracking(machine.clone(), moves)
        .lasting(4.0)
        .run()
        .to_csv();
    let place = Place::with("raw.csv", &log);
    place.write("m.toml", machine.to_toml());
    let columns = "--time time_s --current current_a --machine m.toml";
    let (_, said) = place.import(&format!(
        "raw.csv --position position --input input {columns}"
    ));
    assert!(
        said.ends_with("Nothing in the log contradicts m.toml.\n"),
        "{said}"
    );
    // Volts for the position and the position for volts is no such log.
    let (_, said) = place.import(&format!(
        "raw.csv --position input:rad --input position:V {columns}"
    ));
    assert!(!said.contains("Nothing in the log contradicts"), "{said}");
    // Where a column may be in another unit, the machine file is not blamed.
    let degrees = log.replacen("position", "position [deg]", 1);
    place.write("degrees.csv", degrees);
    let (_, said) = place.import(&format!(
        "degrees.csv --position position --input input {columns}"
    ));
    assert!(
        said.contains("Look again: `position` may be in deg"),
        "{said}"
    );
    assert!(said.contains("log.csv was written"), "{said}");
    assert!(
        said.ends_with("Not compared with m.toml: first see to what is said above.\n"),
        "{said}"
    );
    // A file that makes volts of per cent takes the per cent as they are.
    let mut lines = log.lines();
    let head = lines.next().unwrap();
    let input = head.split(',').position(|name| name == "input").unwrap();
    let percent = lines.map(|line| {
        let mut fields: Vec<String> = line.split(',').map(str::to_owned).collect();
        let volts: f64 = fields[input].parse().unwrap();
        fields[input] = (volts / 0.24).to_string();
        fields.join(",") + "\n"
    });
    let head = head.replace("input", "duty_pct");
    place.write(
        "percent.csv",
        format!("{head}\n{}", percent.collect::<String>()),
    );
    let own = machine.to_toml().replace("gain = 1.0", "gain = 0.24");
    assert!(own.contains("gain = 0.24"), "{own}");
    place.write("percent.toml", own);
    let (_, said) = place.import(
        "percent.csv --position position --input duty_pct --time time_s --current current_a --machine percent.toml",
    );
    assert!(
        said.ends_with("Nothing in the log contradicts percent.toml.\n"),
        "{said}"
    );
    for (spoilt, what, mended) in [
        (
            "--position position*0.25 --input input",
            "position is 4 times too small",
            "position:rad*4",
        ),
        (
            "--position position*4 --input input",
            "position is 4 times too large",
            "position:rad/4",
        ),
        (
            "--position position --input input*2",
            "input is 2 times too large",
            "input:V/2",
        ),
        (
            "--position position*57.29578 --input input",
            "position is in degrees",
            "position:deg",
        ),
    ] {
        let output = place.run(&format!("import raw.csv {spoilt} {columns} --out a.csv"));
        let said = text(&output.stdout);
        assert!(
            said.contains("a.csv and m.toml do not belong together"),
            "{said}"
        );
        assert!(said.contains(what) && said.contains(mended), "{said}");
        // The call that it prints mends the log.
        let call = said
            .lines()
            .find_map(|line| line.strip_prefix("  Remedy: "))
            .unwrap();
        place.follow(call);
        let words =
            "a-corrected.csv --time time_s --position position --input input --current current_a";
        let (_, said) = place.import(&format!("{words} --machine m.toml"));
        assert!(said.contains("Nothing in the log contradicts"), "{said}");
        for name in ["a.csv", "a-corrected.csv"] {
            fs::remove_file(place.path(name)).unwrap();
        }
    }
}

/// The column that a sign comes from is listed beside the one with the size.
#[test]
fn a_direction_is_in_the_table() {
    let raw = rows("t,x,pwm,dir", 300, |k| {
        let angle = (0.02 * k as f64).sin();
        format!("{},{angle},{},{}", 0.001 * k as f64, k % 60, k / 60 % 2)
    });
    let place = Place::with("raw.csv", raw);
    let (log, said) = place.import("raw.csv --time t:s --position x:rad --input pwm:%*12@dir");
    near(&log.input, |k| {
        let sign = if k / 60 % 2 == 0 { -1.0 } else { 1.0 };
        sign * (k % 60) as f64 * 0.12
    });
    let line = said.lines().find(|line| line.starts_with("input"));
    assert!(line.unwrap().contains("its sign from dir"), "{said}");
    assert!(!said.contains("Columns that were not asked for"), "{said}");
}

/// A name with its unit in brackets may be given without, where it means one column alone; and where a time
/// without its unit makes no log, the unit that the file says is the remedy.
#[test]
fn a_unit_in_a_name_need_not_be_typed() {
    let raw = rows(
        "Zeit [ms],Winkel [°],PWM (%),pos [deg],pos [rad]",
        300,
        |k| {
            let angle = 40.0 * (0.02 * k as f64).sin();
            format!(
                "{},{angle},{},{angle},{}",
                2 * k,
                k % 60,
                angle.to_radians()
            )
        },
    );
    let place = Place::with("raw.csv", raw);
    let columns = "--position Winkel:deg --input PWM:%*24";
    let (log, _) = place.import(&format!("raw.csv --time Zeit:ms {columns}"));
    assert!((log.period_s - 2e-3).abs() < 1e-12);
    near(&log.position, |k| {
        (40.0 * (0.02 * k as f64).sin()).to_radians()
    });
    near(&log.input, |k| (k % 60) as f64 * 0.24);
    place.refuses(
        "import raw.csv --time Zeit:ms --position pos:deg --input PWM --out log.csv",
        &["--position asks for the column \"pos\", and the file has none of that name"],
    );
    // Two seconds from row to row, and a gap of eight in motion.
    let raw = rows("Zeit [ms],Winkel [°],PWM (%)", 300, |k| {
        let time = if k < 150 { 2 * k } else { 2 * k + 6 };
        format!("{time},{},5", 40.0 * (0.02 * time as f64).sin())
    });
    place.write("raw.csv", raw);
    place.refuses(
        "import raw.csv --time Zeit --position Winkel:deg --input PWM --out log.csv",
        &[
            "--time has no unit, and the file says that it is in ms: cargo hil import",
            "--time \"Zeit [ms]:ms\"",
        ],
    );
}
