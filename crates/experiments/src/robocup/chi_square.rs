//! The chi-square distribution, for bands around what an honest covariance gives.

/// Probability that a chi-square variable of the given degrees of freedom is at most `x`: the regularized lower incomplete
/// gamma function P(k / 2, x / 2) by its power series. Source: Abramowitz and Stegun 1964, 6.5.29 and 26.4.19.
pub fn chi_square_cdf(degrees: u32, x: f64) -> f64 {
    if x <= 0.0 || degrees == 0 {
        return 0.0;
    }
    // Eight standard deviations above the mean nothing is left, and the series would begin below the smallest number.
    if x > f64::from(degrees) + 8.0 * (2.0 * f64::from(degrees)).sqrt() + 60.0 {
        return 1.0;
    }
    let (a, half) = (f64::from(degrees) / 2.0, x / 2.0);
    let mut term = (a * half.ln() - half - ln_gamma_of_half(degrees + 2)).exp();
    let mut sum = term;
    let mut n = 1.0;
    while term > sum * 1e-15 && n < 100_000.0 {
        term *= half / (a + n);
        sum += term;
        n += 1.0;
    }
    sum.min(1.0)
}

/// The value that a chi-square variable exceeds with probability 1 - `probability` (0 to 1), by bisection.
pub fn chi_square_quantile(degrees: u32, probability: f64) -> f64 {
    let (mut low, mut high) = (0.0, 10.0 * f64::from(degrees.max(1)) + 50.0);
    for _ in 0..80 {
        let middle = f64::midpoint(low, high);
        if chi_square_cdf(degrees, middle) < probability { low = middle } else { high = middle }
    }
    f64::midpoint(low, high)
}

/// The band in which the mean of `count` independent chi-square variables of the given degrees of freedom lies with
/// probability 0.95. Source: Bar-Shalom, Li, Kirubarajan 2001, section 5.4.2.
pub fn mean_band_95(degrees: u32, count: u32) -> (f64, f64) {
    let count = count.max(1);
    let of = |probability| chi_square_quantile(degrees * count, probability) / f64::from(count);
    (of(0.025), of(0.975))
}

/// ln Gamma(k / 2) for a whole k from 1 on, by its recurrence.
fn ln_gamma_of_half(twice: u32) -> f64 {
    let first = if twice.is_multiple_of(2) { 2 } else { 1 };
    let start = if first == 2 { 0.0 } else { std::f64::consts::PI.ln() / 2.0 };
    start + (first..twice).step_by(2).map(|k| (f64::from(k) / 2.0).ln()).sum::<f64>()
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn quantiles_of_printed_tables() {
        for (degrees, probability, expected) in
            [(2, 0.95, 5.991), (3, 0.95, 7.815), (3, 0.025, 0.216), (60, 0.025, 40.482), (60, 0.975, 83.298)]
        {
            let found = chi_square_quantile(degrees, probability);
            assert!((found - expected).abs() < 1e-3, "{degrees} {probability}: {found}");
        }
    }

    #[test]
    fn the_band_narrows_with_the_number_of_runs() {
        let (low, high) = mean_band_95(3, 20);
        assert!((low - 2.024).abs() < 1e-3 && (high - 4.165).abs() < 1e-3, "{low} {high}");
        let (low, high) = mean_band_95(3, 2000);
        assert!(low > 2.89 && high < 3.11);
    }
}
