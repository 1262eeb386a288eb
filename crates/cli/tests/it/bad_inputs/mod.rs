//! Every command that reads something, with everything that may be wrong with it: the table of commands x kinds of inputs x
//! damages. A command that is new, or has a new option that takes a file, does not pass until it stands in the table.

#![cfg(unix)]

mod cell;
mod damages;
mod kinds;
mod run;
mod slots;

use std::{
    collections::BTreeSet,
    sync::{
        Mutex,
        atomic::{AtomicUsize, Ordering},
    },
};

use cell::{Cell, all_cells};
use run::{Fixtures, Options, options_in};
use slots::{OUTPUTS, SLOTS};

use crate::support::Workspace;

/// So many cells there are at least.
const MIN_CELLS: usize = 2700;

#[test]
fn every_bad_input_is_refused_with_a_sentence() {
    // For looking at some of them: CELLS='slam SOURCE' shows what the program says.
    let wanted = std::env::var("CELLS").ok();
    let is_wanted =
        |cell: &Cell| wanted.as_ref().is_none_or(|wanted| cell.to_string().contains(wanted.as_str()));
    let cells: Vec<Cell> = all_cells().into_iter().filter(is_wanted).collect();
    assert!(wanted.is_some() || cells.len() >= MIN_CELLS, "{} cells", cells.len());
    let fixtures = Fixtures::new();
    let options = options_of_commands();
    let next = AtomicUsize::new(0);
    let faults = Mutex::new(Vec::new());
    let work = || {
        while let Some(cell) = cells.get(next.fetch_add(1, Ordering::Relaxed)) {
            let outcome = fixtures.run(cell);
            let fault = outcome.fault(cell, &options);
            if wanted.is_some() || fault.is_some() {
                let fault = fault.as_deref().unwrap_or("as expected");
                faults.lock().unwrap().push((cell.to_string(), format!("{fault}\n    {outcome}")));
            }
        }
    };
    let num_threads = std::thread::available_parallelism().map_or(1, usize::from);
    std::thread::scope(|scope| (0..num_threads).for_each(|_| drop(scope.spawn(work))));
    let mut faults = faults.into_inner().unwrap();
    faults.sort();
    let lines: Vec<String> = faults.iter().map(|(cell, fault)| format!("{cell}: {fault}")).collect();
    assert!(faults.is_empty(), "{} of {} cells:\n{}", faults.len(), cells.len(), lines.join("\n"));
}

/// Value names of arguments that may be files or folders.
const PATHS: [&str; 14] = [
    "FILE",
    "NAME|FILE",
    "DIR",
    "BAG",
    "SOURCE",
    "SCENARIO",
    "TRUTH",
    "ESTIMATE",
    "CAMERA",
    "IMAGE",
    "PHOTO",
    "IN",
    "SEQUENCE",
    "OTHER",
];

#[test]
fn every_argument_that_takes_a_file_is_in_the_table() {
    let workspace = Workspace::new();
    let known: BTreeSet<(&str, &str)> = SLOTS.iter().map(|slot| (slot.command, slot.argument)).collect();
    let mut found = BTreeSet::new();
    for command in commands(&workspace) {
        let help =
            workspace.must(&[&command.split(' ').collect::<Vec<_>>()[..], &["--help"]].concat()).stdout;
        for argument in path_arguments(&help) {
            let is_output = OUTPUTS.contains(&argument.as_str());
            assert!(
                is_output || known.contains(&(command.as_str(), argument.as_str())),
                "visloc {command} {argument}: what it reads belongs into SLOTS, what it writes into OUTPUTS"
            );
            found.insert((command.clone(), argument));
        }
    }
    for (command, argument) in known {
        assert!(
            found.contains(&(command.to_owned(), argument.to_owned())),
            "visloc {command} {argument}: there is no such argument"
        );
    }
}

/// From what each command says of itself.
fn options_of_commands() -> Options {
    let workspace = Workspace::new();
    let help =
        |command: &str| workspace.must(&[&command.split(' ').collect::<Vec<_>>()[..], &["--help"]].concat());
    let options = |command: String| (command.clone(), options_in(&help(&command).stdout));
    commands(&workspace).into_iter().map(options).collect()
}

/// All commands, with those below them.
fn commands(workspace: &Workspace) -> Vec<String> {
    let below = |args: &[&str]| {
        let help = workspace.must(&[args, &["--help"]].concat()).stdout;
        let lines = help.lines().skip_while(|line| *line != "Commands:").skip(1);
        let names = lines.take_while(|line| !line.is_empty()).filter(|line| !line.starts_with("    "));
        let names = names.filter_map(|line| Some(line.split_whitespace().next()?.to_owned()));
        names.filter(|name| name != "help").collect::<Vec<_>>()
    };
    let mut all = Vec::new();
    for name in below(&[]) {
        let parts = below(&[&name]);
        if parts.is_empty() {
            all.push(name);
        } else {
            all.extend(parts.into_iter().map(|part| format!("{name} {part}")));
        }
    }
    all
}

/// Arguments that may be files or folders: `--camera`, or the value's name where there is no option.
fn path_arguments(help: &str) -> BTreeSet<String> {
    let mut arguments = BTreeSet::new();
    for line in help.lines().map(str::trim_start) {
        let Some((before, value)) = line.split_once(['<', '[']) else { continue };
        let Some((value, _)) = value.split_once(['>', ']']) else { continue };
        let is_path = PATHS.contains(&value);
        match before.split_whitespace().last() {
            Some(option) if option.starts_with("--") && is_path => drop(arguments.insert(option.to_owned())),
            None if is_path => drop(arguments.insert(value.to_owned())),
            _ => {}
        }
    }
    arguments
}
