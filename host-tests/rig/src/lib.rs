//! f64 plants that play the measured actuator in the tests.
