//! Keyframes and how they lie to each other: what a loop says is spread over the way.

use nalgebra::{DVector, SMatrix, SVector};

use super::Similarity;
use crate::solve::{LEAST_GAIN, STEP, Skyline};

/// How two keyframes lie to each other.
#[derive(Debug, Clone, Copy)]
pub struct PoseGraphEdge {
    /// Index of the first node.
    pub first: usize,
    /// Index of the second node.
    pub second: usize,
    /// From the second camera to the first, each with its own unit of length.
    pub first_from_second: Similarity,
    /// From the first camera to where the error is measured: the camera itself but where both know a frame between them.
    pub at_first: Similarity,
    /// Whitens the error: rotation, translation in units of the graph's length, logarithm of the scale.
    pub weight: SMatrix<f64, DOF, DOF>,
}

impl PoseGraphEdge {
    /// An edge that weighs one.
    #[must_use]
    pub fn new(first: usize, second: usize, first_from_second: Similarity) -> Self {
        let none = Similarity::from_coordinates(&Vector7::zeros(), 1.0);
        Self { first, second, first_from_second, at_first: none, weight: Matrix7::identity() }
    }
}

/// Nodes with similarity transforms (7 degrees of freedom: of one camera alone the scale drifts, too), and edges between them.
///
/// Source: Strasdat, Montiel and Davison, "Scale drift-aware large scale monocular SLAM", 2010, section III.
#[derive(Debug, Clone)]
pub struct PoseGraph {
    /// From the world to each camera.
    pub nodes: Vec<Similarity>,
    /// The first nodes, at least one, which do not move.
    pub num_fixed: usize,
    /// Measured edges.
    pub edges: Vec<PoseGraphEdge>,
    /// A length that weighs as much as a radian: about the depth of the scene.
    pub length: f64,
}

/// Numbers of a node.
const DOF: usize = 7;
/// Least damping of a step, share of the diagonal.
const LEAST_DAMPING: f64 = 1e-6;

type Vector7 = SVector<f64, DOF>;
type Matrix7 = SMatrix<f64, DOF, DOF>;

impl PoseGraph {
    /// Sum of the squared errors of all edges.
    #[must_use]
    pub fn cost(&self) -> f64 {
        self.cost_of(&self.nodes)
    }

    /// The squared error of an edge.
    #[must_use]
    pub fn cost_of_edge(&self, edge: &PoseGraphEdge) -> f64 {
        self.error(edge, &self.nodes[edge.first], &self.nodes[edge.second]).norm_squared()
    }

    fn cost_of(&self, nodes: &[Similarity]) -> f64 {
        let error = |edge: &PoseGraphEdge| self.error(edge, &nodes[edge.first], &nodes[edge.second]);
        self.edges.iter().map(|edge| error(edge).norm_squared()).sum()
    }

    fn error(&self, edge: &PoseGraphEdge, first: &Similarity, second: &Similarity) -> Vector7 {
        let there = edge.first_from_second.after(second);
        edge.weight * there.after(&edge.at_first.after(first).inverse()).coordinates(self.length)
    }

    /// Moves the nodes so that the edges agree, by Levenberg and Marquardt: where they disagree by much, a whole step of Gauss-Newton goes too
    /// far. Returns how many steps helped.
    pub fn solve(&mut self, max_steps: usize) -> usize {
        let (mut cost, mut damping) = (self.cost(), LEAST_DAMPING);
        for step in 0..max_steps {
            let Some((nodes, new_cost)) = self.lower(cost, &mut damping) else { return step };
            self.nodes = nodes;
            let gain = (cost - new_cost) / cost;
            cost = new_cost;
            if gain < LEAST_GAIN {
                return step + 1;
            }
        }
        max_steps
    }

    /// Nodes with a lower cost, after a step with as much damping as that takes; `None` if there is none.
    fn lower(&self, cost: f64, damping: &mut f64) -> Option<(Vec<Similarity>, f64)> {
        let (matrix, right) = self.equations()?;
        while *damping < 1.0 / LEAST_DAMPING {
            let mut damped = matrix.clone();
            for row in 0..right.len() {
                *damped.diagonal_mut(row) *= 1.0 + *damping;
                *damped.diagonal_mut(row) += 1e-12;
            }
            if let Some(moves) = damped.solve(&right) {
                let moved = self.nodes.iter().enumerate().map(|(i, node)| self.moved(i, node, &moves));
                let moved: Vec<Similarity> = moved.collect();
                let new_cost = self.cost_of(&moved);
                if new_cost < cost {
                    *damping = (*damping * 0.5).max(LEAST_DAMPING);
                    return Some((moved, new_cost));
                }
            }
            *damping *= 2.0;
        }
        None
    }

    /// The first nodes stay: unknowns begin with those behind them.
    fn moved(&self, node: usize, at: &Similarity, moves: &DVector<f64>) -> Similarity {
        let Some(free) = node.checked_sub(self.num_fixed) else { return *at };
        let by = Vector7::from_fn(|i, _| moves[DOF * free + i]);
        Similarity::from_coordinates(&by, self.length).after(at)
    }

    /// The normal equations: the lower half of the matrix, and the right side.
    fn equations(&self) -> Option<(Skyline, DVector<f64>)> {
        let fixed = self.num_fixed;
        let num = self.nodes.len().checked_sub(fixed).filter(|num| *num > 0)?;
        let mut first: Vec<usize> = (0..num).collect();
        for edge in &self.edges {
            let (low, high) = (edge.first.min(edge.second), edge.first.max(edge.second));
            if low >= fixed {
                first[high - fixed] = first[high - fixed].min(low - fixed);
            }
        }
        let mut matrix = Skyline::new((0..DOF * num).map(|row| DOF * first[row / DOF]).collect());
        let mut right = DVector::<f64>::zeros(DOF * num);
        for edge in &self.edges {
            let (error, by_first, by_second) = self.linearize(edge);
            for (a, by_a) in [(edge.first, &by_first), (edge.second, &by_second)] {
                if a < fixed {
                    continue;
                }
                let gradient = by_a.transpose() * error;
                for i in 0..DOF {
                    right[DOF * (a - fixed) + i] -= gradient[i];
                }
                for (b, by_b) in [(edge.first, &by_first), (edge.second, &by_second)] {
                    if b >= fixed && b <= a {
                        add_block(&mut matrix, (a - fixed, b - fixed), &(by_a.transpose() * by_b));
                    }
                }
            }
        }
        Some((matrix, right))
    }

    /// The error of an edge and its derivatives by small moves of both nodes.
    fn linearize(&self, edge: &PoseGraphEdge) -> (Vector7, Matrix7, Matrix7) {
        let (first, second) = (&self.nodes[edge.first], &self.nodes[edge.second]);
        let error = self.error(edge, first, second);
        let (mut by_first, mut by_second) = (Matrix7::zeros(), Matrix7::zeros());
        for i in 0..DOF {
            let mut by = Vector7::zeros();
            by[i] = STEP;
            let small = Similarity::from_coordinates(&by, self.length);
            by_first.set_column(i, &((self.error(edge, &small.after(first), second) - error) / STEP));
            by_second.set_column(i, &((self.error(edge, first, &small.after(second)) - error) / STEP));
        }
        (error, by_first, by_second)
    }
}

fn add_block(matrix: &mut Skyline, (row, column): (usize, usize), block: &Matrix7) {
    for i in 0..DOF {
        for j in 0..DOF {
            let (row, column) = (DOF * row + i, DOF * column + j);
            if column <= row {
                matrix.add(row, column, block[(i, j)]);
            }
        }
    }
}

#[cfg(test)]
mod tests {
    use nalgebra::Vector3;

    use super::*;

    /// A camera that goes round in a circle and whose scale drifts by a percent with every step.
    #[test]
    fn a_loop_takes_the_drift_of_the_scale_out() {
        let num = 60;
        let node = |i: usize, length: f64| {
            let angle = std::f64::consts::TAU * i as f64 / num as f64;
            let by = Vector7::from_column_slice(&[0.0, angle, 0.0, 0.0, 0.0, 10.0, 0.0]);
            // From the world to a camera on the circle that looks along it.
            Similarity::from_coordinates(&by, 1.0).enlarged(length)
        };
        let truth: Vec<Similarity> = (0..num).map(|i| node(i, 1.0)).collect();
        let drift = Similarity { scale: 1.01, ..Similarity::from_coordinates(&Vector7::zeros(), 1.0) };
        let mut edges = Vec::new();
        let mut nodes = vec![truth[0]];
        for i in 1..num {
            let next_from_last = drift.after(&truth[i].after(&truth[i - 1].inverse()));
            edges.push(PoseGraphEdge::new(i, i - 1, next_from_last));
            nodes.push(next_from_last.after(&nodes[i - 1]));
        }
        let loop_closes = truth[0].after(&truth[num - 1].inverse());
        edges.push(PoseGraphEdge::new(0, num - 1, loop_closes));
        let mut graph = PoseGraph { nodes, num_fixed: 1, edges, length: 10.0 };
        let shift = |graph: &PoseGraph| {
            let center = |s: &Similarity| *s.to_pose().inverse().translation();
            graph.nodes.iter().zip(&truth).map(|(a, b)| (center(a) - center(b)).norm()).fold(0.0, f64::max)
        };
        let (before, cost) = (shift(&graph), graph.cost());
        assert!(graph.solve(20) > 0);
        assert!(graph.cost() < 0.1 * cost, "{} of {cost}", graph.cost());
        assert!(shift(&graph) < 0.5 * before, "{} of {before}", shift(&graph));
    }

    /// Three edges in a row that say little of the scale, and one between their ends that knows it to be another one.
    #[test]
    fn a_step_that_goes_too_far_is_shortened() {
        let none = Similarity::from_coordinates(&Vector7::zeros(), 1.0);
        let at = |z: f64| Similarity { translation: Vector3::new(0.0, 0.0, z), ..none };
        let nodes: Vec<Similarity> = (0..4).map(|i| at(f64::from(i))).collect();
        let between = |a: usize, b: usize| nodes[a].after(&nodes[b].inverse());
        let mut edges: Vec<PoseGraphEdge> =
            (1..4).map(|i| PoseGraphEdge::new(i - 1, i, between(i - 1, i))).collect();
        edges.push(PoseGraphEdge::new(0, 3, between(0, 3).enlarged(2.6)));
        let mut graph = PoseGraph { nodes: nodes.clone(), num_fixed: 1, edges, length: 0.1 };
        let before = graph.cost();
        let (matrix, right) = graph.equations().unwrap();
        let whole = matrix.solve(&right).unwrap();
        let moved: Vec<Similarity> =
            graph.nodes.iter().enumerate().map(|(i, node)| graph.moved(i, node, &whole)).collect();
        assert!(graph.cost_of(&moved) > before, "{} of {before}", graph.cost_of(&moved));
        assert!(graph.solve(20) > 0);
        assert!(graph.cost() < 0.5 * before, "{} of {before}", graph.cost());
    }
}
