//! What was found, beside what was published.

use serde_json::{Value, json};
use visloc_locate::markov::{Action, NUM_CASES, Outcomes};

use super::{
    experiment::{MarkovExperiment, MarkovRecord, Reading, Task},
    goalkeeper::{GoalkeeperRecord, Keeper},
    goalless::{Blindness, GoallessCell, GoallessRecord},
    pictures,
    walk::{NUM_STEPS, WalkRecord},
};
use crate::{Experiment, Report, Results, Table, number, published, quantile, sorted};

/// The instant from which on the published run is localized.
const PUBLISHED_LOCALIZED_AT: usize = 4;
/// States of the published parts of the observation tables.
const PUBLISHED_STATES: [usize; 5] = [0, 1, 2, 3, 16];

impl MarkovExperiment {
    /// All tables.
    pub fn tables(&self, results: &Results<MarkovRecord>) -> Vec<Table> {
        let learned = self.learned_tables();
        let tables = [
            self.walk_table(results).0,
            self.keeper_table(results).0,
            self.goalless_table(results).0,
            action_table(),
            case_table("sizes", "size of the goal", |state| learned.size(state)),
            case_table("centroids", "sector of the goal's middle", |state| learned.centroid(state)),
        ];
        tables.into_iter().map(|table| published::beside(table, "markov")).collect()
    }

    /// Tables, numbers and pictures of the runs that are there.
    pub fn report(&self, results: &Results<MarkovRecord>, seed: u64) -> Report {
        let walks_json = self.walk_table(results).1;
        let keepers_json = self.keeper_table(results).1;
        let goalless_json = self.goalless_table(results).1;
        let missing = results.num_missing();
        let runs = results.num_runs() - missing;
        let mut notes = vec![
            "Walks: states 0, 32, ..., 352; localized: one state has more than half of the belief. From column 8 on \
             the goal is out of view of a straight head. Odometry: 6 / 88 / 6 % for no, one and two tiles instead of the \
             published 5 / 80 / 10 / 5 %, which were measured on a robot without odometry. Densities: bearing and size of \
             the goal as the same captures show them, not sorted into nine cases each."
                .to_owned(),
            "Goalkeeper, published: head straight, one goal, whole tiles. Corrected: head turning, both goals, tiles of \
             0.25 m, 32 headings, way corrected by the estimate; this is what visloc offers."
                .to_owned(),
            "Without a goal: observations with the goal in view until the robot is found; 10 stands for not found on the \
             way across the field."
                .to_owned(),
        ];
        notes.extend(self.origin_of_tables().map(str::to_owned));
        if missing > 0 {
            notes.push(format!("{missing} runs are still missing."));
        }
        Report {
            heading: format!("Markov localization on a grid: {runs} runs, seed {seed}"),
            tables: self.tables(results),
            notes,
            json: json!({
                "experiment": self.name(), "seed": seed, "settings": self.settings(),
                "walks": walks_json, "goalkeeper": keepers_json, "without_goal": goalless_json,
            }),
            pictures: pictures::all(self, results),
        }
    }

    /// Records of the cells with a task, with the task's place.
    pub(super) fn walks<'a>(&self, results: &'a Results<MarkovRecord>, task: Task) -> Vec<&'a WalkRecord> {
        let walk = |record: &'a MarkovRecord| match record {
            MarkovRecord::Walk(walk) => Some(walk),
            _ => None,
        };
        let cell = self.tasks.iter().position(|t| *t == task);
        cell.map(|cell| results.cell(cell).filter_map(walk).collect()).unwrap_or_default()
    }

    /// Records of the goalkeepers of one kind.
    pub(super) fn keepers<'a>(
        &self,
        results: &'a Results<MarkovRecord>,
        keeper: Keeper,
    ) -> Vec<&'a GoalkeeperRecord> {
        let of = |record: &'a MarkovRecord| match record {
            MarkovRecord::Goalkeeper(record) => Some(record),
            _ => None,
        };
        let cell = self.tasks.iter().position(|t| *t == Task::Goalkeeper(keeper));
        cell.map(|cell| results.cell(cell).filter_map(of).collect()).unwrap_or_default()
    }

    fn walk_table(&self, results: &Results<MarkovRecord>) -> (Table, Value) {
        let mut table = Table::new(
            "walks",
            "Walk along the right edge: whether the published run is localized | share of runs here in the right state",
            &["instant", "state", "synthetic", "images, as published", "odometry", "densities"],
        );
        let columns = [Reading::Published, Reading::Odometry, Reading::Densities].map(Task::Images);
        let columns =
            [Task::Synthetic, columns[0], columns[1], columns[2]].map(|task| self.walks(results, task));
        let shares = |holds: &dyn Fn(&WalkRecord) -> bool| {
            columns.each_ref().map(|walks| percent(walks.iter().filter(|w| holds(w)).count(), walks.len()))
        };
        let mut rows = Vec::new();
        let mut push = |name: String, state: String, shares: [f64; 4]| {
            let mut row = vec![name.clone(), state];
            row.extend(shares.map(whole));
            table.push(row);
            let [synthetic, as_published, odometry, densities] = shares;
            rows.push(json!({
                "instant": name, "synthetic_percent": synthetic, "images_percent": as_published,
                "images_with_odometry_percent": odometry, "images_with_densities_percent": densities,
            }));
        };
        for t in 0..=NUM_STEPS {
            push(format!("t = {t}"), (32 * t).to_string(), shares(&|w| w.is_right_at(t)));
        }
        let by_four = shares(&|walk| (0..=PUBLISHED_LOCALIZED_AT).any(|t| walk.is_right_at(t)));
        push(format!("found by t = {PUBLISHED_LOCALIZED_AT}"), String::new(), by_four);
        let for_good = shares(&|walk| walk.right_from().is_some_and(|t| t <= PUBLISHED_LOCALIZED_AT));
        push(format!("always from t = {PUBLISHED_LOCALIZED_AT} on"), String::new(), for_good);
        let json = Value::Array(rows);
        (table, json)
    }

    fn keeper_table(&self, results: &Results<MarkovRecord>) -> (Table, Value) {
        let mut table = Table::new(
            "goalkeeper",
            "Goalkeeper from the side line to its goal: final error in mm: published | here",
            &["robot", "runs", "in tile", "arrived", "5 %", "median", "95 %", "heading median", "actions"],
        );
        let mut rows = Vec::new();
        for (name, keeper) in [("published", Keeper::Published), ("corrected", Keeper::Corrected)] {
            let records = self.keepers(results, keeper);
            let of = |value: fn(&GoalkeeperRecord) -> f64| sorted(records.iter().map(|record| value(record)));
            let errors = of(|record| record.error_m * 1000.0);
            let headings = of(|record| record.heading_error_rad.to_degrees());
            let actions = of(|record| record.num_actions as f64);
            let in_tile = percent(records.iter().filter(|r| r.is_in_tile).count(), records.len());
            let arrived = percent(records.iter().filter(|r| r.has_arrived).count(), records.len());
            let [low, middle, high] = [0.05, 0.5, 0.95].map(|share| quantile(&errors, share));
            table.push([
                name.to_owned(),
                format!("{}", records.len()),
                whole(in_tile),
                whole(arrived),
                number(low, 0),
                number(middle, 0),
                number(high, 0),
                format!("{} deg", number(quantile(&headings, 0.5), 0)),
                number(quantile(&actions, 0.5), 0),
            ]);
            rows.push(json!({
                "robot": name, "runs": records.len(), "in_tile_percent": in_tile, "arrived_percent": arrived,
                "error_mm": { "p05": low, "median": middle, "p95": high },
                "heading_error_median_deg": quantile(&headings, 0.5), "errors_mm": errors,
            }));
        }
        (table, Value::Array(rows))
    }

    fn goalless_table(&self, results: &Results<MarkovRecord>) -> (Table, Value) {
        let mut table = Table::new(
            "without-goal",
            "Mean number of observations with a goal until the robot is found, after so many without",
            &["why", "remedy", "0", "5", "20", "60"],
        );
        let mut rows = Vec::new();
        for blindness in [Blindness::LooksAway, Blindness::Hidden, Blindness::Carried] {
            for has_remedy in [false, true] {
                let means = [0, 5, 20, 60].map(|num_without| {
                    self.mean_to_recover(results, GoallessCell { blindness, num_without, has_remedy })
                });
                let mut row = vec![why(blindness).to_owned(), yes_no(has_remedy).to_owned()];
                row.extend(means.iter().map(|mean| format!("{mean:.2}")));
                table.push(row);
                rows.push(json!({ "why": why(blindness), "remedy": has_remedy, "without": [0, 5, 20, 60], "mean": means }));
            }
        }
        (table, Value::Array(rows))
    }

    /// Not found counts as ten observations, one more than the way has.
    pub(super) fn mean_to_recover(&self, results: &Results<MarkovRecord>, cell: GoallessCell) -> f64 {
        const NOT_FOUND: usize = 10;
        let Some(place) = self.tasks.iter().position(|task| *task == Task::Goalless(cell)) else {
            return f64::NAN;
        };
        let counts: Vec<usize> = results
            .cell(place)
            .filter_map(|record| match record {
                MarkovRecord::Goalless(GoallessRecord { num_to_recover }) => {
                    Some(num_to_recover.unwrap_or(NOT_FOUND))
                }
                _ => None,
            })
            .collect();
        counts.iter().sum::<usize>() as f64 / counts.len() as f64
    }
}

fn why(blindness: Blindness) -> &'static str {
    match blindness {
        Blindness::LooksAway => "looks away",
        Blindness::Hidden => "goal hidden",
        Blindness::Carried => "goal hidden, carried",
    }
}

fn yes_no(holds: bool) -> &'static str {
    if holds { "yes" } else { "no" }
}

fn percent(count: usize, of: usize) -> f64 {
    100.0 * count as f64 / of as f64
}

fn whole(percent: f64) -> String {
    if percent.is_nan() { "-".to_owned() } else { format!("{percent:.0} %") }
}

/// The published outcomes of actions, and those of a robot with odometry.
fn action_table() -> Table {
    let title = "What comes of an action [%]: published, without odometry | with odometry";
    let mut table = Table::new("actions", title, &["action", "no effect", "once", "twice", "three times"]);
    let outcomes = Outcomes::of_odometry();
    for (name, action) in
        [("advance", Action::ADVANCE), ("turn right", Action::TURN_RIGHT), ("turn left", Action::TURN_LEFT)]
    {
        let shares = outcomes.of(action).iter().map(|share| number(Some(100.0 * share), 0));
        table.push(std::iter::once(name.to_owned()).chain(shares));
    }
    table
}

/// The states of a published observation table.
fn case_table<'a>(name: &str, what: &str, of: impl Fn(usize) -> &'a [f64; NUM_CASES]) -> Table {
    let title = format!("How often each case of the {what} is seen in a state [%]: published | here");
    let cases: Vec<String> = (0..NUM_CASES).map(|case| case.to_string()).collect();
    let header: Vec<&str> = std::iter::once("state").chain(cases.iter().map(String::as_str)).collect();
    let mut table = Table::new(name, &title, &header);
    for state in PUBLISHED_STATES {
        let shares = of(state).iter().map(|share| number(Some(100.0 * share), 0));
        table.push(std::iter::once(state.to_string()).chain(shares));
    }
    table
}
