//! Standard k-means (Lloyd), from starts spread by k-means++.

use model_core::numeric::random::Random;

/// Rounds after which Lloyd's iteration ends, settled or not.
const ROUNDS: usize = 100;

/// A point or a centre in the scaled plane or space; unused coordinates are zero.
pub type Point = [f64; 3];

/// Square of the distance of two points.
fn distance(a: &Point, b: &Point) -> f64 {
    a.iter().zip(b).map(|(a, b)| (a - b) * (a - b)).sum()
}

/// Which centre is nearest, the first of equals.
pub fn nearest(centres: &[Point], point: &Point) -> usize {
    let mut best = (0, f64::INFINITY);
    for (index, centre) in centres.iter().enumerate() {
        let distance = distance(centre, point);
        if distance < best.1 {
            best = (index, distance);
        }
    }
    best.0
}

/// Centres of clusters.
///
/// Arthur and Vassilvitskii, *k-means++: The Advantages of Careful Seeding*, SODA 2007; Lloyd,
/// *Least Squares Quantization in PCM*, IEEE Trans. Inf. Theory 28 (1982). A cluster that loses all
/// its points keeps its centre.
pub fn cluster(points: &[Point], clusters: usize, random: &mut Random) -> Vec<Point> {
    let mut centres = seeds(points, clusters, random);
    for _ in 0..ROUNDS {
        let mut sums = vec![([0.0; 3], 0.0); clusters];
        for point in points {
            let (sum, count) = &mut sums[nearest(&centres, point)];
            for (sum, coordinate) in sum.iter_mut().zip(point) {
                *sum += coordinate;
            }
            *count += 1.0;
        }
        let mut moved = 0.0;
        for (centre, (sum, count)) in centres.iter_mut().zip(sums) {
            if count > 0.0 {
                let mean = sum.map(|sum| sum / count);
                moved += distance(centre, &mean);
                *centre = mean;
            }
        }
        if moved < 1e-12 {
            break;
        }
    }
    centres
}

/// Points far from each other: each drawn with a chance in proportion to the square of its distance
/// from those drawn before.
fn seeds(points: &[Point], clusters: usize, random: &mut Random) -> Vec<Point> {
    let first = (f64::from(random.uniform()) * points.len() as f64) as usize;
    let mut centres = vec![points[first]];
    let mut distances = vec![f64::INFINITY; points.len()];
    while centres.len() < clusters {
        let last = centres[centres.len() - 1];
        let mut sum = 0.0;
        for (nearest, point) in distances.iter_mut().zip(points) {
            *nearest = nearest.min(distance(point, &last));
            sum += *nearest;
        }
        let mut left = f64::from(random.uniform()) * sum;
        let drawn = distances.iter().position(|distance| {
            left -= distance;
            left < 0.0
        });
        centres.push(points[drawn.unwrap_or(points.len() - 1)]);
    }
    centres
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
            let centres = cluster(&points, 4, &mut Random::new(seed, 0));
            let mut names = heaps.map(|heap| nearest(&centres, &heap));
            for (heap, name) in heaps.iter().zip(names) {
                // A hundred points each: four standard errors of the mean.
                let near = heap
                    .iter()
                    .zip(&centres[name])
                    .all(|(a, b)| (a - b).abs() < 0.08);
                assert!(near, "{heap:?} {:?}", centres[name]);
            }
            names.sort_unstable();
            assert_eq!(names, [0, 1, 2, 3], "seed {seed}");
        }
    }

    #[test]
    fn more_clusters_than_points_that_differ_do_no_harm() {
        let points = [[1.0, 2.0, 0.0]; 5];
        assert_eq!(cluster(&points, 3, &mut Random::new(1, 1)), [points[0]; 3]);
    }
}
