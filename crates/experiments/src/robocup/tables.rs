//! The tables.

use super::{
    chi_square::mean_band_95,
    reliability::NEAR_M,
    sets::RobocupSet,
    summary::{Summary, quantile, share},
    timing::AlgorithmTiming,
};
use crate::{Table, mean, number, percent, published, ratio};

/// A contender's label and its runs.
pub(super) type Row<'a> = (String, Summary<'a>);

/// Runs without kidnaps.
pub(super) fn walks(set: RobocupSet, rows: &[Row<'_>]) -> Table {
    let title = format!("{}: errors from the first localization on, published | here", set.title());
    let header = [
        "algorithm",
        "runs",
        "position [m]",
        "worst run",
        "heading [deg]",
        "worst run",
        "localized",
        "after [s]",
    ];
    let mut table = Table::new(set.name(), &title, &header);
    for (label, summary) in rows {
        let (position, heading) = (summary.position_m(), summary.heading_deg());
        table.push([
            label.clone(),
            summary.records.len().to_string(),
            number(position.mean, 3),
            number(position.worst, 3),
            number(heading.mean, 2),
            number(heading.worst, 2),
            percent(mean(&summary.records.iter().filter_map(|r| r.localized_share).collect::<Vec<_>>())),
            number(quantile(summary.records.iter().map(|r| r.time_to_localize_s), 0.5), 1),
        ]);
    }
    published::beside(table, "robocup")
}

/// Runs with kidnaps.
pub(super) fn kidnaps(set: RobocupSet, rows: &[Row<'_>]) -> Table {
    let mirror = if set.is_mirrored() { "; without the half, the mirror image counts as right" } else { "" };
    let title = format!("{}: published | here{mirror}", set.title());
    let mut header = vec![
        "algorithm",
        "kidnaps",
        "right at the end",
        "found",
        "found after [s]",
        "90 %",
        "reliable after [s]",
        "position [m]",
        "heading [deg]",
    ];
    if set.is_mirrored() {
        header.push("both among hypotheses");
    }
    let mut table = Table::new(set.name(), &title, &header);
    for (label, summary) in rows {
        let count = summary.num_kidnaps();
        let of = |holds: fn(&super::record::KidnapScore) -> bool| percent(share(summary.count(holds), count));
        let position: Vec<f64> = summary.kidnaps().filter_map(|kidnap| kidnap.position_error_m).collect();
        let heading: Vec<f64> = summary.kidnaps().filter_map(|kidnap| kidnap.heading_error_deg).collect();
        let reliable = number(quantile(summary.kidnaps().map(|kidnap| kidnap.reliable_s), 0.5), 1);
        let mut row = vec![
            label.clone(),
            count.to_string(),
            of(|kidnap| kidnap.is_right_at_end),
            of(|kidnap| kidnap.recovery_s.is_some()),
            number(quantile(summary.kidnaps().map(|kidnap| kidnap.recovery_s), 0.5), 1),
            number(quantile(summary.kidnaps().map(|kidnap| kidnap.recovery_s), 0.9), 1),
            reliable,
            number(mean(&position), 3),
            number(mean(&heading), 2),
        ];
        if set.is_mirrored() {
            row.push(of(|kidnap| kidnap.has_both));
        }
        table.push(row);
    }
    published::beside(table, "robocup")
}

/// Frames by their reported reliability, all sets together.
pub(super) fn calibration(rows: &[Row<'_>]) -> Table {
    let title =
        format!("Share of the frames within {NEAR_M:.2} m of the truth by their reliability, all sets, in %");
    let bins: Vec<String> = (0..10).map(|bin| format!("{:.1}", f64::from(bin) / 10.0)).collect();
    let mut header = vec!["algorithm", "above 0.6", "frames above 0.6"];
    header.extend(bins.iter().map(String::as_str));
    let mut table = Table::new("calibration", &title, &header);
    for (label, summary) in rows {
        let sum = summary.calibration();
        let mut row = vec![
            label.clone(),
            number(ratio(sum.claimed_near, sum.claimed).map(|s| 100.0 * s), 2),
            sum.claimed.to_string(),
        ];
        row.extend((0..10).map(|bin| number(ratio(sum.near[bin], sum.frames[bin]).map(|s| 100.0 * s), 0)));
        table.push(row);
    }
    table
}

/// Covariance against errors, all sets together.
pub(super) fn consistency(rows: &[Row<'_>]) -> Table {
    let title =
        "Normalized error squared (NEES, 3 if the covariance is honest) in frames that track the robot";
    let header = [
        "algorithm",
        "runs",
        "mean of the runs",
        "95 % of the runs",
        "band of the mean",
        "seconds in band",
        "in ellipsoid of 95 %",
        "position in ellipse of 95 %",
    ];
    let mut table = Table::new("consistency", title, &header);
    for (label, summary) in rows {
        let runs = summary.nees_of_runs();
        let (low, high) = mean_band_95(3, u32::try_from(runs.len()).unwrap_or(u32::MAX));
        let quantiles = [0.025, 0.975].map(|p| number(quantile(runs.iter().map(|v| Some(*v)), p), 1));
        let sum = |value: fn(&super::record::Consistency) -> u64| {
            summary.records.iter().map(|record| value(&record.consistency)).sum::<u64>()
        };
        let frames = sum(|c| c.frames);
        table.push([
            label.clone(),
            runs.len().to_string(),
            number(mean(&runs), 2),
            quantiles.join(" to "),
            format!("{low:.2} to {high:.2}"),
            percent(seconds_in_band(summary)),
            percent(ratio(sum(|c| c.in_ellipsoid), frames)),
            percent(ratio(sum(|c| c.in_position_ellipse), frames)),
        ]);
    }
    table
}

/// Share of the seconds in which the mean over the runs lies in the band for as many independent runs.
pub(super) fn seconds_in_band(summary: &Summary<'_>) -> Option<f64> {
    let seconds: Vec<(f64, u32)> =
        summary.nees_over_time().into_iter().filter(|(_, num_runs)| *num_runs > 0).collect();
    let is_inside = |(nees, num_runs): &&(f64, u32)| {
        let (low, high) = mean_band_95(3, *num_runs);
        (low..=high).contains(nees)
    };
    share(seconds.iter().filter(is_inside).count(), seconds.len())
}

/// Time of an iteration, with the image analysis, and of parts of it.
pub(super) fn timing(timings: &[AlgorithmTiming]) -> Table {
    let title = "Time of an iteration with image analysis [ms]: published on the Nao | here, one thread on this machine";
    let mut table = Table::new("timing", title, &["algorithm", "mean", "median", "99 %", "range"]);
    for timing in timings {
        let summary = &timing.iteration_ms;
        table.push([
            timing.algorithm.clone(),
            number(summary.mean, 3),
            number(summary.median, 3),
            number(summary.p99, 3),
            format!("at most {}", number(summary.max, 3)),
        ]);
    }
    published::beside(table, "robocup")
}
