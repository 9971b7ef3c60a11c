//! Standard k-means: Lloyd's iteration from the starts of k-means++ (D. Arthur and S. Vassilvitskii,
//! *k-means++: The Advantages of Careful Seeding*, SODA 2007).

use model_core::numeric::random::Random;

use super::reading::DIMENSIONS;

/// A place in the clustered space.
pub(super) type Point = [f64; DIMENSIONS];

/// More iterations than a start takes; it ends when no centre moves.
const ITERATIONS: usize = 100;

/// Centres of `count` clusters, at least one, of points, at least one.
pub(super) fn centres(points: &[Point], count: usize, random: &mut Random) -> Vec<Point> {
    let mut centres = spread(points, count, random);
    for _ in 0..ITERATIONS {
        let next = means(points, &centres);
        if next == centres {
            break;
        }
        centres = next;
    }
    centres
}

/// The mean of the points nearest to each centre; a centre without any stays.
fn means(points: &[Point], centres: &[Point]) -> Vec<Point> {
    let mut sums = vec![([0.0; DIMENSIONS], 0.0); centres.len()];
    for point in points {
        let (sum, count) = &mut sums[nearest(centres, point)];
        for (sum, value) in sum.iter_mut().zip(point) {
            *sum += value;
        }
        *count += 1.0;
    }
    sums.iter()
        .zip(centres)
        .map(|(&(sum, count), &centre)| {
            if count > 0.0 {
                sum.map(|sum| sum / count)
            } else {
                centre
            }
        })
        .collect()
}

/// The number of the nearest centre, of equally near ones the first.
pub(super) fn nearest(centres: &[Point], point: &Point) -> usize {
    let mut best = (0, f64::INFINITY);
    for (number, centre) in centres.iter().enumerate() {
        let distance = squared_distance(centre, point);
        if distance < best.1 {
            best = (number, distance);
        }
    }
    best.0
}

/// k-means++: each further centre is a point drawn with a probability as its squared distance from
/// the nearest centre so far.
fn spread(points: &[Point], count: usize, random: &mut Random) -> Vec<Point> {
    let first = (f64::from(random.uniform()) * points.len() as f64) as usize;
    let mut centres = vec![points[first]];
    let mut distances = vec![f64::INFINITY; points.len()];
    while centres.len() < count {
        let last = centres[centres.len() - 1];
        for (distance, point) in distances.iter_mut().zip(points) {
            *distance = distance.min(squared_distance(&last, point));
        }
        let mut left = f64::from(random.uniform()) * distances.iter().sum::<f64>();
        let drawn = distances.iter().position(|distance| {
            left -= distance;
            left < 0.0
        });
        // None where all points are centres, or by rounding.
        centres.push(points[drawn.unwrap_or(points.len() - 1)]);
    }
    centres
}

fn squared_distance(a: &Point, b: &Point) -> f64 {
    a.iter().zip(b).map(|(a, b)| (a - b) * (a - b)).sum()
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn separate_heaps_are_the_clusters() {
        let heaps = [
            [0.0, 0.0, 0.0],
            [5.0, 0.0, 1.0],
            [0.0, 6.0, -1.0],
            [4.0, 5.0, 2.0],
        ];
        let mut noise = Random::new(7, 0);
        let points: Vec<Point> = (0..400)
            .map(|number| heaps[number % 4].map(|value| value + 0.2 * f64::from(noise.normal())))
            .collect();
        for seed in 0..10 {
            let centres = centres(&points, 4, &mut Random::new(seed, 0));
            let names: Vec<usize> = heaps.iter().map(|heap| nearest(&centres, heap)).collect();
            let mut distinct = names.clone();
            distinct.sort_unstable();
            assert_eq!(distinct, [0, 1, 2, 3], "seed {seed}");
            for (heap, name) in heaps.iter().zip(names) {
                // A hundred points each: four standard errors of the mean.
                let near = heap
                    .iter()
                    .zip(&centres[name])
                    .all(|(a, b)| (a - b).abs() < 0.08);
                assert!(near, "{heap:?} {:?}", centres[name]);
            }
        }
    }

    #[test]
    fn more_clusters_than_distinct_points_do_no_harm() {
        let points = [[1.0, 2.0, 0.0]; 5];
        assert_eq!(centres(&points, 3, &mut Random::new(1, 1)), [points[0]; 3]);
    }
}
