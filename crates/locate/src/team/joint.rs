//! Which hypotheses of all robots together explain what they see.

/// The logarithm of how much less one combination explains the sightings than another is not counted beyond this: there is always some way
/// in which a detector may have gone wrong.
pub(super) const MAX_DIFFERENCE: f64 = 25.0;
/// Most combinations; robots with many hypotheses are taken with fewer before there are more.
pub(super) const MAX_COMBINATIONS: usize = 1024;

/// A robot with its options: elsewhere, and its hypotheses by name.
#[derive(Debug, Clone, Default, PartialEq)]
pub(super) struct Variable {
    pub number: u8,
    pub session: u32,
    pub ids: Vec<u16>,
}

impl Variable {
    pub fn num_options(&self) -> usize {
        self.ids.len() + 1
    }
}

/// How well one sighting fits each pair of options of the robot that saw it and another one.
#[derive(Debug, Clone, Default)]
pub(super) struct Factor {
    /// Density of what fits to nobody and was not seen before.
    pub base: f64,
    /// Probability that it is of what was seen a moment ago, if it fits to nobody.
    pub again: f64,
    /// Density if the robot makes up what it sees, and the probability of that.
    pub invented: f64,
    pub doubt: f64,
    /// What was seen has not counted yet, or it has.
    pub cases: [Case; 2],
    /// For each robot the density for its option and that of the observer, `[observer * options + option]`; empty for who has no part in it.
    pub tables: Vec<Vec<f64>>,
}

/// What a sighting says if something is so.
#[derive(Debug, Clone, Copy, Default)]
pub(super) struct Case {
    /// Probability that it is so.
    pub share: f64,
    /// How much the sighting counts then, 0 to 1.
    pub weight: f64,
    /// Density of what stays where it was, whatever it is.
    pub same: f64,
}

impl Factor {
    /// Density for a combination of options, if the sighting is of anything.
    fn density(&self, observer: usize, options: &[usize], variables: &[Variable]) -> f64 {
        let from = options[observer];
        let (mut anywhere, mut somewhere) = (0.0, 0.0_f64);
        for ((table, option), variable) in self.tables.iter().zip(options).zip(variables) {
            let Some(density) = table.get(from * variable.num_options() + option) else { continue };
            if from == 0 || *option == 0 {
                anywhere += density;
            } else {
                // Two are not in the same place.
                somewhere = somewhere.max(*density);
            }
        }
        self.base + anywhere + somewhere
    }
}

/// For every combination of options what the sightings of late have said.
#[derive(Debug, Clone, Default)]
pub(super) struct Joint {
    variables: Vec<Variable>,
    /// Logarithms of likelihoods; the option of the first robot changes fastest.
    log_likelihoods: Vec<f64>,
    scratch: Vec<f64>,
    options: Vec<usize>,
}

impl Joint {
    pub fn variables(&self) -> &[Variable] {
        &self.variables
    }

    pub fn find(&self, number: u8) -> Option<usize> {
        self.variables.iter().position(|variable| variable.number == number)
    }

    /// Takes a robot with its options. Of options that stay the same everything is kept; new ones begin with the mean of the old ones, by
    /// the probabilities that these had.
    pub fn set(&mut self, wanted: &Variable, old_priors: &[f64]) {
        if self.log_likelihoods.is_empty() {
            self.log_likelihoods.push(0.0);
        }
        let Some(axis) = self.find(wanted.number) else {
            self.variables.push(wanted.clone());
            self.scratch.clear();
            for _ in 0..wanted.num_options() {
                self.scratch.extend_from_slice(&self.log_likelihoods);
            }
            std::mem::swap(&mut self.scratch, &mut self.log_likelihoods);
            return;
        };
        let known = &self.variables[axis];
        if known == wanted {
            return;
        }
        let is_same_robot = known.session == wanted.session;
        let old_option = |id: &u16| known.ids.iter().position(|old| old == id).map(|i| i + 1);
        let sources: Vec<Option<usize>> = std::iter::once(is_same_robot.then_some(0))
            .chain(wanted.ids.iter().map(|id| old_option(id).filter(|_| is_same_robot)))
            .collect();
        self.replace(axis, &sources, old_priors);
        self.variables[axis] = wanted.clone();
    }

    /// Forgets a robot.
    pub fn remove(&mut self, number: u8, priors: &[f64]) {
        if let Some(axis) = self.find(number) {
            self.replace(axis, &[None], priors);
            self.variables.remove(axis);
        }
    }

    /// New options of a robot: an old one, or the mean of all.
    fn replace(&mut self, axis: usize, sources: &[Option<usize>], priors: &[f64]) {
        let stride: usize = self.variables[..axis].iter().map(Variable::num_options).product();
        let num_old = self.variables[axis].num_options();
        self.scratch.clear();
        for block in self.log_likelihoods.chunks_exact(stride * num_old) {
            for source in sources {
                for i in 0..stride {
                    let old = |option: usize| block[option * stride + i];
                    self.scratch.push(match source {
                        Some(option) => old(*option),
                        None => {
                            log_mean((0..num_old).map(|option| (old(option), priors.get(option).copied())))
                        }
                    });
                }
            }
        }
        std::mem::swap(&mut self.scratch, &mut self.log_likelihoods);
    }

    /// What was said longer ago counts less: `kept` is 0 to 1.
    pub fn forget(&mut self, kept: f64) {
        self.log_likelihoods.iter_mut().for_each(|value| *value *= kept);
    }

    /// Takes in a sighting by a robot in one of its cases. Returns the density that it had by what was known before, given the probabilities of
    /// all options, if it is of anything.
    pub fn weigh(&mut self, observer: usize, factor: &Factor, case: &Case, priors: &[&[f64]]) -> f64 {
        let (weight, invented) = (case.share * case.weight, factor.invented + case.same);
        self.options.clear();
        self.options.resize(self.variables.len(), 0);
        let (mut most, mut expected, mut total) = (f64::NEG_INFINITY, 0.0, 0.0);
        for value in &mut self.log_likelihoods {
            let density = case.same + factor.density(observer, &self.options, &self.variables);
            if self.options[observer] != 0 {
                let probability = product(&self.options, priors) * value.exp();
                expected += probability * density;
                total += probability;
            }
            *value += weight * ((1.0 - factor.doubt) * density + factor.doubt * invented).ln();
            most = most.max(*value);
            advance(&mut self.options, &self.variables);
        }
        self.log_likelihoods.iter_mut().for_each(|value| *value = (*value - most).max(-MAX_DIFFERENCE));
        if total > 0.0 { expected / total } else { factor.base + case.same }
    }

    /// Calls `visit` with the options of every combination and its weight, which is the product of the probabilities of all options and of
    /// what the sightings say.
    pub fn for_each(&mut self, priors: &[&[f64]], mut visit: impl FnMut(&[usize], f64)) {
        self.options.clear();
        self.options.resize(self.variables.len(), 0);
        for value in &self.log_likelihoods {
            visit(&self.options, product(&self.options, priors) * value.exp());
            advance(&mut self.options, &self.variables);
        }
    }
}

/// Probability of a combination if the options of the robots have nothing to do with each other.
fn product(options: &[usize], priors: &[&[f64]]) -> f64 {
    options.iter().zip(priors).map(|(option, prior)| prior[*option]).product()
}

/// The next combination.
fn advance(options: &mut [usize], variables: &[Variable]) {
    for (option, variable) in options.iter_mut().zip(variables) {
        *option += 1;
        if *option < variable.num_options() {
            return;
        }
        *option = 0;
    }
}

/// Logarithm of the mean of likelihoods, given as logarithms with their weights; without weights all count the same.
fn log_mean(values: impl Iterator<Item = (f64, Option<f64>)> + Clone) -> f64 {
    let most = values.clone().map(|(value, _)| value).fold(f64::NEG_INFINITY, f64::max);
    let (mut sum, mut total) = (0.0, 0.0);
    for (value, weight) in values {
        let weight = weight.unwrap_or(1.0);
        sum += weight * (value - most).exp();
        total += weight;
    }
    if sum > 0.0 { most + (sum / total).ln() } else { most - MAX_DIFFERENCE }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn variable(number: u8, ids: &[u16]) -> Variable {
        Variable { number, session: 1, ids: ids.to_vec() }
    }

    /// Two robots of two sides that see each other: only equal sides explain it.
    fn tied() -> Joint {
        let mut joint = Joint::default();
        joint.set(&variable(1, &[0, 1]), &[]);
        joint.set(&variable(2, &[6, 7]), &[]);
        let table = vec![0.1, 0.1, 0.1, 0.1, 9.0, 0.0, 0.1, 0.0, 9.0];
        let factor = Factor { base: 0.1, tables: vec![Vec::new(), table], ..Factor::default() };
        let even = [1.0 / 3.0; 3];
        let case = Case { share: 1.0, weight: 1.0, same: 0.0 };
        let expected = joint.weigh(0, &factor, &case, &[&even, &even]);
        assert!((expected - (0.1 + (2.0 * 0.1 + 2.0 * 9.0) / 6.0)).abs() < 1e-12);
        joint
    }

    fn shares(joint: &mut Joint, priors: &[Vec<f64>], axis: usize) -> Vec<f64> {
        let mut sums = vec![0.0; priors[axis].len()];
        let slices: Vec<&[f64]> = priors.iter().map(Vec::as_slice).collect();
        joint.for_each(&slices, |options, weight| sums[options[axis]] += weight);
        let total: f64 = sums.iter().sum();
        sums.iter().map(|sum| sum / total).collect()
    }

    #[test]
    fn a_sighting_is_of_one_robot() {
        let variables = [variable(1, &[0]), variable(2, &[0]), variable(3, &[0])];
        let table = vec![0.1, 0.1, 0.1, 9.0];
        let factor =
            Factor { base: 0.5, tables: vec![Vec::new(), table.clone(), table], ..Factor::default() };
        let density = |options: [usize; 3]| factor.density(0, &options, &variables);
        assert_eq!(density([1, 1, 1]), 9.5, "two are not in the same place");
        assert_eq!(density([1, 1, 0]), 9.6);
        assert_eq!(density([1, 0, 0]), 0.7, "but either may be anywhere");
    }

    #[test]
    fn one_that_knows_decides_for_the_other() {
        let mut joint = tied();
        let priors = [vec![0.05, 0.475, 0.475], vec![0.05, 0.9, 0.05]];
        let sides = shares(&mut joint, &priors, 0);
        assert!(sides[1] > 0.9 && sides[2] < 0.08, "{sides:?}");
    }

    #[test]
    fn who_begins_anew_keeps_nothing_and_others_keep_their_ties() {
        let mut joint = tied();
        let old = [0.05, 0.475, 0.475];
        joint.set(&variable(1, &[2, 3]), &old);
        let sides = shares(&mut joint, &[old.to_vec(), vec![0.05, 0.9, 0.05]], 0);
        assert!((sides[1] - sides[2]).abs() < 1e-12, "{sides:?}");
        // With one old option and one new track the old one keeps what it had.
        let mut joint = tied();
        joint.set(&variable(1, &[0, 1, 4, 5]), &old);
        let priors = [vec![0.1, 0.3, 0.3, 0.15, 0.15], vec![0.05, 0.9, 0.05]];
        let sides = shares(&mut joint, &priors, 0);
        assert!(sides[1] > 10.0 * sides[2] && (sides[3] - sides[4]).abs() < 1e-12, "{sides:?}");
        joint.remove(2, &[0.05, 0.9, 0.05]);
        assert_eq!((joint.variables().len(), joint.log_likelihoods.len()), (1, 5));
    }
}
