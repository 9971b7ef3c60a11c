//! What an import doubts, and the call that it prints to mend it.

use super::*;

/// The call that an answer prints, which stands in a line of its own.
#[track_caller]
fn printed_call(said: &str) -> &str {
    let mut lines = said.lines().map(str::trim);
    let call = lines.find(|line| line.starts_with("cargo hil import "));
    call.unwrap_or_else(|| panic!("no call: {said}"))
}

/// A PWM of a microcontroller that is written as what it is not. Whatever it was taken for, the call that is printed makes
/// volts of it, and leaves every file as it is.
#[test]
fn a_pwm_count_is_mended_by_the_printed_call() {
    let duty = |k: usize| (0.02 * k as f64).sin();
    for (name, full) in [
        ("pwm", 255.0),
        ("m1", 255.0),
        ("ctrl", 1023.0),
        ("u", 4095.0),
    ] {
        let header = format!("t,{name},dir,x");
        let count = move |k: usize| (full * duty(k)).round();
        let raw = rows(&header, 600, |k| {
            let (count, dir) = (count(k), u8::from(count(k) > 0.0));
            format!("{k},{},{dir},{:.4}", count.abs(), 3.0 * duty(k))
        });
        for given in ["", ":V", ":%*12", ":duty*12"] {
            let place = Place::with("raw.csv", &raw);
            let call = format!(
                "import raw.csv --time t:ms --position x:rad --input {name}{given}@dir --out log.csv"
            );
            let output = place.run(&call);
            let said = text(&output.stdout).to_owned();
            let count_of = format!("looks like a PWM count of {} bits", (full + 1.0).log2());
            assert!(said.contains(&count_of), "{given}: {said}");
            assert!(!said.contains("mV"), "{said}");
            if given.contains('*') {
                assert!(said.contains("no duty is more than 100 %"), "{said}");
            }
            let before = fs::read(place.path("log.csv")).unwrap();
            place.follow(printed_call(&said));
            assert_eq!(fs::read(place.path("log.csv")).unwrap(), before);
            let log = Log::read(&place.path("log-corrected.csv")).expect("a log");
            near(&log.input, |k| 12.0 * count(k) / full);
        }
    }
}

/// Per cent are no PWM counts, and what is written with its right size is not doubted.
#[test]
fn a_duty_within_its_whole_is_not_doubted() {
    let raw = rows("t,pwm,x", 600, |k| {
        let duty = (0.02 * k as f64).sin();
        format!("{k},{},{:.4}", (100.0 * duty).round(), 3.0 * duty)
    });
    let place = Place::with("raw.csv", raw);
    for input in ["pwm:%*12", "pwm/100:duty*12", "pwm*0.12:V"] {
        let (_, said) = place.import(&format!(
            "raw.csv --time t:ms --position x:rad --input {input}"
        ));
        assert!(!said.contains("Look again"), "{input}: {said}");
    }
}

/// Several doubts are mended by one call, which keeps the machine file and writes to a name that is free.
#[test]
fn the_printed_call_mends_every_doubt_and_runs_as_it_is() {
    let raw = rows("t,pos [deg],u", 400, |k| {
        let t = k as f64;
        format!(
            "{t},{},{}",
            170.0 * (0.01 * t).sin(),
            90.0 * (0.02 * t).cos()
        )
    });
    let place = Place::with("raw.csv", raw);
    place.write("m.toml", Machine::rotary_ema().to_toml());
    place.write("log-corrected.csv", "somebody's");
    let columns = "--time t --position pos --input u";
    let output = place.run(&format!(
        "import raw.csv {columns} --machine m.toml --out log.csv"
    ));
    let said = text(&output.stdout);
    let call = printed_call(said);
    assert_eq!(
        call,
        "cargo hil import raw.csv --time t:ms --input \"u:%*12\" --position \"pos [deg]:deg\" --machine m.toml \
         --out log-corrected-2.csv"
    );
    place.follow(call);
    let log = Log::read(&place.path("log-corrected-2.csv")).expect("a log");
    near(&log.position, |k| {
        (170.0 * (0.01 * k as f64).sin()).to_radians()
    });
    near(&log.input, |k| 10.8 * (0.02 * k as f64).cos());
    assert_eq!(
        fs::read(place.path("log-corrected.csv")).unwrap(),
        b"somebody's"
    );
}
