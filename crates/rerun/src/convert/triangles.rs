//! Triangles of a polygon, by cutting off ears (Meisters 1975).

type Point = [f32; 2];

/// Triangles of a simple polygon, in the direction of positive turn.
pub(super) fn triangles(outline: &[Point]) -> Vec<[Point; 3]> {
    let mut rest = outline.to_vec();
    let next = |i: usize| outline[(i + 1) % outline.len()];
    let area: f32 = outline.iter().enumerate().map(|(i, p)| p[0] * next(i)[1] - next(i)[0] * p[1]).sum();
    if area < 0.0 {
        rest.reverse();
    }
    let mut found = Vec::new();
    while rest.len() > 3 {
        let Some(ear) = (0..rest.len()).find(|i| is_ear(&rest, *i)) else { break };
        found.push(corners(&rest, ear));
        rest.remove(ear);
    }
    found.extend(<[Point; 3]>::try_from(rest).ok());
    found
}

fn corners(polygon: &[Point], i: usize) -> [Point; 3] {
    let count = polygon.len();
    [polygon[(i + count - 1) % count], polygon[i], polygon[(i + 1) % count]]
}

fn turn(a: Point, b: Point, c: Point) -> f32 {
    (b[0] - a[0]) * (c[1] - a[1]) - (b[1] - a[1]) * (c[0] - a[0])
}

/// Whether a corner is convex and has no other corner in its triangle.
fn is_ear(polygon: &[Point], i: usize) -> bool {
    let [a, b, c] = corners(polygon, i);
    let is_outside = |p: &Point| {
        [a, b, c].contains(p) || turn(a, b, *p) < 0.0 || turn(b, c, *p) < 0.0 || turn(c, a, *p) < 0.0
    };
    turn(a, b, c) > 1e-9 && polygon.iter().all(is_outside)
}

#[cfg(test)]
mod tests {
    use super::*;

    fn area(triangles: &[[Point; 3]]) -> f32 {
        triangles.iter().map(|[a, b, c]| turn(*a, *b, *c) / 2.0).sum()
    }

    #[test]
    fn a_corner_of_a_corridor_is_covered_once() {
        let outline = [[0.0, 0.0], [4.0, 0.0], [4.0, 1.0], [1.0, 1.0], [1.0, 3.0], [0.0, 3.0]];
        let reversed: Vec<Point> = outline.iter().rev().copied().collect();
        for outline in [outline.to_vec(), reversed] {
            let found = triangles(&outline);
            assert_eq!(found.len(), 4);
            assert!(found.iter().all(|[a, b, c]| turn(*a, *b, *c) > 0.0));
            assert!((area(&found) - 6.0).abs() < 1e-5);
        }
        assert!(triangles(&[[0.0, 0.0], [1.0, 0.0]]).is_empty());
    }
}
