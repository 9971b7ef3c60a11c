//! The pin table at the head of `pins.rs`: nothing is there twice, every function is one that the pin has,
//! and what the table has the code takes, no more and no less.

use std::collections::{BTreeMap, BTreeSet};

use host_tests::workspace;

/// Alternate functions of the used pins: data sheet DS8626 revision 9, table 9.
const FUNCTIONS: [(&str, &str); 16] = [
    ("PA0", "TIM2 CH1, AF1"),
    ("PA8", "TIM1 CH1, AF1"),
    ("PA9", "TIM1 CH2, AF1"),
    ("PB6", "USART1 TX, AF7"),
    ("PB7", "USART1 RX, AF7"),
    ("PB8", "TIM4 CH3, AF2"),
    ("PB12", "TIM1 BKIN, AF1"),
    ("PB13", "TIM1 CH1N, AF1"),
    ("PB14", "TIM1 CH2N, AF1"),
    ("PC0", "ADC1 channel 10"),
    ("PC1", "ADC1 channel 11"),
    ("PC2", "ADC1 channel 12"),
    ("PC3", "ADC1 channel 13"),
    ("PC6", "TIM3 CH1, AF2"),
    ("PC7", "TIM3 CH2, AF2"),
    ("PA4", "DAC1"),
];

fn source() -> String {
    let path = workspace::root().join("firmware/src/board/stm32f405/pins.rs");
    std::fs::read_to_string(path).unwrap()
}

/// The table's rows: pins, and their function.
fn table(source: &str) -> Vec<(Vec<String>, String)> {
    let rows = source.lines().filter_map(|line| {
        let cells: Vec<&str> = line.strip_prefix("//! | P")?.split(" | ").collect();
        let pins = format!("P{}", cells[0]);
        let pins = pins.split(", ").map(str::to_owned).collect();
        Some((pins, cells[1].to_owned()))
    });
    rows.collect()
}

/// What the pin does, of a row's function: that of its place where the row has several.
fn function(function: &str, place: usize, pins: usize) -> String {
    let (names, rest) = function.split_once(", AF").unwrap_or((function, ""));
    let names: Vec<&str> = names.split(", ").collect();
    let name = if names.len() == pins {
        let first = names[0].split(' ').next().unwrap();
        let own = names[place];
        if own.contains(' ') || own.starts_with("DAC") {
            own.to_owned()
        } else {
            format!("{first} {own}")
        }
    } else {
        names[0].to_owned()
    };
    let number: String = rest.chars().take_while(char::is_ascii_digit).collect();
    if number.is_empty() {
        name
    } else {
        format!("{name}, AF{number}")
    }
}

#[test]
fn no_pin_is_there_twice_and_each_has_its_function() {
    let table = table(&source());
    let expected = BTreeMap::from(FUNCTIONS);
    let mut found = BTreeSet::new();
    let mut checked = 0;
    for (pins, row) in &table {
        for (place, pin) in pins.iter().enumerate() {
            assert!(found.insert(pin.clone()), "{pin} is there twice");
            if let Some(&expected) = expected.get(pin.as_str()) {
                assert_eq!(function(row, place, pins.len()), expected, "{pin}");
                checked += 1;
            }
        }
    }
    assert_eq!(checked, FUNCTIONS.len());
}

#[test]
fn the_code_takes_the_pins_of_the_table() {
    let source = source();
    let taken: BTreeSet<String> = source
        .split("chip.")
        .skip(1)
        .map(|rest| {
            rest.chars()
                .take_while(char::is_ascii_alphanumeric)
                .collect()
        })
        .filter(|name: &String| {
            name.starts_with('P') && name.as_bytes().get(2).is_some_and(u8::is_ascii_digit)
        })
        .collect();
    let listed: BTreeSet<String> = table(&source)
        .into_iter()
        .flat_map(|(pins, _)| pins)
        // The crystal's and the probe's are nobody's.
        .filter(|pin| !["PH0", "PH1", "PA13", "PA14"].contains(&pin.as_str()))
        .collect();
    assert_eq!(taken, listed);
}

#[test]
fn every_peripheral_has_one_use() {
    let source = source();
    let mut uses = BTreeMap::<String, usize>::new();
    for rest in source.split("chip.").skip(1) {
        let name = rest
            .chars()
            .take_while(|c| c.is_ascii_alphanumeric() || *c == '_');
        *uses.entry(name.collect()).or_default() += 1;
    }
    assert!(uses.values().all(|&uses| uses == 1), "{uses:?}");
    // Embassy's clock has TIM5, which no image may take.
    assert!(!uses.contains_key("TIM5"));
    for timer in [
        "TIM1", "TIM2", "TIM3", "TIM4", "TIM7", "DMA2_CH2", "DMA2_CH7",
    ] {
        assert!(uses.contains_key(timer), "{timer}");
    }
}
