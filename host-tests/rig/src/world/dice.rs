//! Draws from the distributions that the worlds use.

use crate::random::Random;

/// Uniform from `low` to `high`.
pub(super) fn between(random: &mut Random, low: f64, high: f64) -> f64 {
    low + (high - low) * random.uniform()
}

/// Uniform in the logarithm, from `low` to `high`, both positive.
pub(super) fn log_between(random: &mut Random, low: f64, high: f64) -> f64 {
    low * (high / low).powf(random.uniform())
}

/// True with this probability.
pub(super) fn chance(random: &mut Random, probability: f64) -> bool {
    random.uniform() <= probability
}

/// −1 or 1.
pub(super) fn sign(random: &mut Random) -> f64 {
    if chance(random, 0.5) { 1.0 } else { -1.0 }
}

/// One of several.
pub(super) fn pick<T: Copy>(random: &mut Random, from: &[T]) -> T {
    let place = (random.uniform() * from.len() as f64) as usize;
    from[place.min(from.len() - 1)]
}

/// A seed that follows from several numbers, each of which changes all of it.
pub(super) fn seed_of(numbers: &[u64]) -> u64 {
    numbers.iter().fold(0x0077_0214_D5EE_D000, |seed, &number| {
        Random::new(seed.rotate_left(17) ^ number).bits()
    })
}

#[cfg(test)]
mod tests {
    use super::{between, log_between, pick, seed_of};
    use crate::random::Random;

    #[test]
    fn draws_stay_within_their_bounds() {
        let mut random = Random::new(1);
        for _ in 0..1000 {
            let value = between(&mut random, -2.0, 3.0);
            assert!((-2.0..=3.0).contains(&value));
            let value = log_between(&mut random, 1e-6, 1e-2);
            assert!((0.999e-6..=1.001e-2).contains(&value));
            assert!([1, 5, 9].contains(&pick(&mut random, &[1, 5, 9])));
        }
    }

    #[test]
    fn neighbouring_seeds_have_nothing_in_common() {
        let seeds: Vec<u64> = (0..100).map(|index| seed_of(&[1, index])).collect();
        for (place, seed) in seeds.iter().enumerate() {
            assert!(!seeds[..place].contains(seed));
        }
        assert_ne!(seed_of(&[1, 2]), seed_of(&[2, 1]));
    }
}
