//! What resembles an effect of the catalogue and leaves most of what the model misses: it is not said to be that effect.

use host_tests::gap_benchmark::worlds::traced::judge_world;
use rig::world::World;

/// Worlds outside the catalogue, by seed and index: nothing is proven of them.
fn nothing_is_proven(worlds: &[(u64, u64)]) {
    for &(seed, index) in worlds {
        let (world, records) = World::draw(seed, index);
        let (judged, _) = judge_world(&world, &records);
        let case = format!("world {index} of {seed}: {}", judged.said());
        assert!(judged.answer.nothing_proven, "{case}");
        assert!(judged.answer.named.is_empty(), "{case}");
    }
}

/// Friction that is high within a narrow band of speeds. A drag with the square of the speed lowers the error to a half, surely, and
/// leaves forty times what the true law does.
#[test]
fn a_narrow_band_of_speeds_is_no_drag() {
    nothing_is_proven(&[(20_270_204, 32)]);
}

/// The inertia of a crank, of which a law over the current takes less than half of the error.
#[test]
#[ignore = "other cases"]
fn the_inertia_of_a_crank_is_no_law_over_the_current() {
    nothing_is_proven(&[(20_270_114, 58)]);
}
