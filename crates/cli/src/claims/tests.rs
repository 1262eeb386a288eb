//! Over all commands, as clap knows them: a new command or option enters by itself.

use std::{
    any::TypeId,
    fs,
    path::{Path, PathBuf},
};

use clap::{Arg, Command, CommandFactory};
use tempfile::TempDir;

use super::Claims;
use crate::args::{
    Cli, InputMap, InputName, InputPath, OutputFile, OutputFolder, OutputMap, OutputRecording,
};

/// Names of values that are texts without a path in them.
const OTHER_TEXTS: [&str; 6] = ["NAME", "TOPIC", "FRAME", "TOKEN", "HOST:PORT", "KEY=VALUE"];

fn is<T: 'static>(arg: &Arg) -> bool {
    arg.get_value_parser().type_id() == TypeId::of::<T>()
}

fn is_input(arg: &Arg) -> bool {
    is::<InputPath>(arg) || is::<InputName>(arg) || is::<InputMap>(arg)
}

fn is_output(arg: &Arg) -> bool {
    is::<OutputFile>(arg) || is::<OutputFolder>(arg) || is::<OutputMap>(arg) || is::<OutputRecording>(arg)
}

/// All commands that have no further ones, with the words that call them.
fn leaves(command: &Command, words: &[String]) -> Vec<(Vec<String>, Command)> {
    if command.get_subcommands().next().is_none() {
        return vec![(words.to_vec(), command.clone())];
    }
    let below = |sub: &Command| leaves(sub, &[words, &[sub.get_name().to_owned()]].concat());
    command.get_subcommands().flat_map(below).collect()
}

fn all_leaves() -> Vec<(Vec<String>, Command)> {
    leaves(&Cli::command(), &["visloc".to_owned()])
}

#[test]
fn every_argument_with_a_path_says_whether_it_is_read_or_written() {
    for (words, command) in all_leaves() {
        for arg in command.get_arguments() {
            let value_name = arg.get_value_names().map(|names| names.join(" ")).unwrap_or_default();
            let is_other = (is::<String>(arg) && OTHER_TEXTS.contains(&&*value_name))
                || !(is::<String>(arg) || is::<PathBuf>(arg) || is::<std::ffi::OsString>(arg));
            assert!(is_other, "{words:?} {}: InputPath, InputName or one of the outputs?", arg.get_id());
        }
        if command.get_arguments().any(is::<OutputRecording>) {
            assert!(command.get_arguments().any(|arg| arg.get_id() == "overwrite"), "{words:?} --overwrite");
        }
    }
}

/// Ways to name something that is read.
#[derive(Debug, Clone, Copy, PartialEq)]
enum Way {
    Same,
    Detour,
    /// By a folder that is not there yet.
    DetourByNothing,
    SymbolicLink,
    HardLink,
    InsideFolder,
    /// A new file with the name of an image.
    NewImageInFolder,
    /// A link in the folder that is read leads to it.
    LinkInFolder,
    /// A list in the folder that is read names it.
    ListInFolder,
}

/// An input, and another name for it.
struct Place {
    _folder: TempDir,
    input: PathBuf,
    file: PathBuf,
    output: PathBuf,
}

fn place(way: Way, is_folder_written: bool) -> Place {
    let folder = tempfile::tempdir().unwrap();
    let path = |name: &str| folder.path().join(name);
    fs::create_dir_all(path("data/images")).unwrap();
    let file = path("data/images/0001.png");
    fs::write(&file, "precious").unwrap();
    let (input, output) = match (way, is_folder_written) {
        (Way::Same, _) => (file.clone(), file.clone()),
        (Way::Detour, _) => (file.clone(), path("data/./images/../images/0001.png")),
        (Way::DetourByNothing, _) => (file.clone(), path("nothing/below/../../data/images/0001.png")),
        (Way::SymbolicLink | Way::HardLink, _) => (file.clone(), path("link")),
        (Way::InsideFolder, false) => (path("data"), file.clone()),
        (Way::NewImageInFolder, false) => (path("data"), path("data/images/0002.png")),
        (Way::InsideFolder | Way::NewImageInFolder, true) => (path("data"), path("data/images")),
        (Way::LinkInFolder | Way::ListInFolder, false) => (path("other"), file.clone()),
        (Way::LinkInFolder | Way::ListInFolder, true) => (path("other"), path("data/images")),
    };
    fs::create_dir(path("other")).unwrap();
    if way == Way::ListInFolder {
        fs::write(path("other/rgb.txt"), "# images\n0.0 ../data/images/0001.png\n").unwrap();
    }
    #[cfg(unix)]
    match way {
        Way::SymbolicLink => std::os::unix::fs::symlink(&file, &output).unwrap(),
        Way::HardLink => fs::hard_link(&file, &output).unwrap(),
        Way::LinkInFolder => std::os::unix::fs::symlink(&file, path("other/0001.png")).unwrap(),
        _ => {}
    }
    Place { _folder: folder, input, file, output }
}

/// What is typed for some arguments. Positions before them are filled.
fn typed(words: &[String], command: &Command, values: &[(&Arg, &Path)]) -> Vec<String> {
    let value = |arg: &Arg| values.iter().find(|(with, _)| with.get_id() == arg.get_id());
    let text = |path: &Path| path.to_str().unwrap().to_owned();
    let last = values.iter().filter_map(|(arg, _)| arg.get_index()).max().unwrap_or(0);
    let positions = command.get_positionals().filter(|arg| arg.get_index().unwrap_or(0) <= last);
    let positions =
        positions.map(|arg| value(arg).map_or("nothing-there".to_owned(), |(_, path)| text(path)));
    let options =
        values.iter().filter_map(|(arg, path)| Some(format!("--{}={}", arg.get_long()?, text(path))));
    words.iter().cloned().chain(options).chain(positions).collect()
}

fn check(line: &[String]) -> anyhow::Result<()> {
    // What else is missing in the line is of no interest here.
    let mut command = Cli::command().ignore_errors(true);
    command.build();
    let matches = command.clone().try_get_matches_from(line)?;
    Claims::of(&command, &matches).check()
}

#[test]
fn no_output_of_any_command_may_be_one_of_its_inputs() {
    let ways = [
        Way::Same,
        Way::Detour,
        Way::DetourByNothing,
        Way::SymbolicLink,
        Way::HardLink,
        Way::InsideFolder,
        Way::NewImageInFolder,
        Way::LinkInFolder,
        Way::ListInFolder,
    ];
    let of_links = [Way::SymbolicLink, Way::HardLink, Way::LinkInFolder];
    let mut num_checked = 0;
    for (words, mut command) in all_leaves() {
        command.build();
        let inputs: Vec<&Arg> = command.get_arguments().filter(|arg| is_input(arg)).collect();
        let outputs: Vec<&Arg> = command.get_arguments().filter(|arg| is_output(arg)).collect();
        for (input, output) in
            inputs.iter().flat_map(|input| outputs.iter().map(move |output| (*input, *output)))
        {
            if is::<InputMap>(input) && is::<OutputMap>(output) {
                // A map may become another one; it is kept.
                continue;
            }
            for way in ways.into_iter().filter(|way| cfg!(unix) || !of_links.contains(way)) {
                if way == Way::ListInFolder && is::<InputMap>(input) {
                    continue; // a map is one file
                }
                let place = place(way, is::<OutputFolder>(output));
                let line = typed(&words, &command, &[(input, &place.input), (output, &place.output)]);
                let error = check(&line).expect_err(&format!("{way:?}: {line:?}"));
                let message = format!("{error:#}");
                assert!(message.contains(place.output.to_str().unwrap()), "{way:?}: {line:?}: {message}");
                assert!(message.contains("which is read"), "{way:?}: {line:?}: {message}");
                assert_eq!(fs::read_to_string(&place.file).unwrap(), "precious");
                num_checked += 1;
            }
        }
    }
    assert!(num_checked > 400, "{num_checked}");
}

#[test]
fn outputs_that_cannot_be_written_are_refused_at_once() {
    let folder = tempfile::tempdir().unwrap();
    let file = folder.path().join("file");
    fs::write(&file, "precious").unwrap();
    for (words, mut command) in all_leaves() {
        command.build();
        for output in command.get_arguments().filter(|arg| is_output(arg)) {
            let bad = if is::<OutputFile>(output) { folder.path().to_path_buf() } else { file.join("below") };
            let line = typed(&words, &command, &[(output, &bad)]);
            let error = check(&line).expect_err(&format!("{line:?}"));
            assert!(format!("{error:#}").contains("cannot write there"), "{line:?}: {error:#}");
        }
    }
    assert_eq!(fs::read_dir(folder.path()).unwrap().count(), 1, "nothing is left behind");
}

#[test]
fn folders_that_nobody_named_are_outputs_as_well() {
    for (kind, folder) in [("field", "out/demo"), ("slam", "out/demo-slam")] {
        let error = check(&line(&["visloc", "demo", kind, "--json", folder])).unwrap_err().to_string();
        assert_eq!(error, format!("--json {folder}: expected another file than --out {folder}"));
    }
}

#[test]
fn no_output_may_have_or_be_below_a_name_that_another_one_takes() {
    let folder = tempfile::tempdir().unwrap();
    let mut num_checked = 0;
    for (words, mut command) in all_leaves() {
        command.build();
        let outputs: Vec<&Arg> = command.get_arguments().filter(|arg| is_output(arg)).collect();
        for (output, other) in outputs.iter().flat_map(|a| outputs.iter().map(move |b| (*a, *b))) {
            if output.get_id() == other.get_id() {
                continue;
            }
            let is_refused = |of_output: &str, of_other: &str| {
                let [of_output, of_other] = [of_output, of_other].map(|name| folder.path().join(name));
                let line = typed(&words, &command, &[(output, &of_output), (other, &of_other)]);
                let said = check(&line).err().map(|error| format!("{error:#}")).unwrap_or_default();
                said.contains(of_output.to_str().unwrap()) && !said.contains("cannot write there")
            };
            let ways =
                ["out/x", "out/x/y.svg", "nothing/../out/x", "out~", "out~/x", "out.part", "out.part/x"];
            for way in ways {
                let is_apart = is::<OutputFolder>(other);
                assert!(is_refused(way, "out") != is_apart, "{words:?}: {output} {way} beside {other} out");
                num_checked += 1;
            }
            assert!(!is_refused("other/x", "out"), "{words:?} {output} {other}");
        }
    }
    assert!(num_checked > 700, "{num_checked}");
    assert_eq!(fs::read_dir(folder.path()).unwrap().count(), 0, "nothing is made");
}

fn line(words: &[&str]) -> Vec<String> {
    words.iter().map(|word| (*word).to_owned()).collect()
}

#[test]
fn recordings_are_replaced_on_demand_only() {
    let folder = tempfile::tempdir().unwrap();
    let path = |name: &str| folder.path().join(name).to_str().unwrap().to_owned();
    fs::write(path("old.mcap"), "a recording by its name").unwrap();
    fs::write(path("old.dat"), b"\x89MCAP0\r\n").unwrap();
    fs::create_dir(path("empty")).unwrap();
    fs::create_dir(path("bag")).unwrap();
    fs::write(path("bag/metadata.yaml"), "").unwrap();
    for (out, is_there) in
        [("old.mcap", true), ("old.dat", true), ("bag", true), ("empty", false), ("new.mcap", false)]
    {
        let record = |more: &[&str]| {
            check(&line(&[&["visloc", "record", "sim:tour", "--out", &path(out)], more].concat()))
        };
        assert_eq!(record(&[]).is_err(), is_there, "{out}");
        record(&["--overwrite"]).unwrap();
        let by_nothing = format!("nothing/../{out}");
        let by_nothing = ["visloc", "record", "sim:tour", "--out", &path(&by_nothing)];
        assert_eq!(check(&line(&by_nothing)).is_err(), is_there, "{by_nothing:?}");
    }
    for name in ["old.mcap", "old.dat"] {
        let error = check(&line(&["visloc", "localize", "sim:tour", "--json", &path(name)])).unwrap_err();
        assert!(error.to_string().contains("--overwrite"), "{error}");
        let error = check(&line(&["visloc", "evaluate", "a", "b", "--json", &path(name)])).unwrap_err();
        assert!(error.to_string().contains("choose another name"), "{error}");
        // Maps are kept as NAME~, where the next one would take the recording's place.
        let error = check(&line(&["visloc", "slam", "sim:room", "--save", &path(name)])).unwrap_err();
        assert!(error.to_string().contains("--overwrite"), "{error}");
        let trim = ["visloc", "map", "trim", "a.vmap", "--keyframes", "3", "--out", &path(name)];
        let error = check(&line(&trim)).unwrap_err();
        assert!(error.to_string().contains("choose another name"), "{error}");
    }
}

#[test]
fn outputs_keep_apart_and_folders_may_be_shared() {
    let folder = tempfile::tempdir().unwrap();
    let path = |name: &str| folder.path().join(name).to_str().unwrap().to_owned();
    let localize = |more: &[&str]| check(&line(&[&["visloc", "localize", "sim:tour"], more].concat()));
    let error = localize(&["--json", &path("a"), "--trajectory", &path("./a")]).unwrap_err().to_string();
    assert!(error.contains("--json") && error.contains("--trajectory"), "{error}");
    let by_nothing = ["--json", &path("a"), "--trajectory", &path("nothing/../a")];
    assert!(localize(&by_nothing).is_err());
    #[cfg(unix)]
    {
        // Nothing is there yet for the link to lead to.
        std::os::unix::fs::symlink(path("a"), path("link")).unwrap();
        assert!(localize(&["--json", &path("a"), "--trajectory", &path("link")]).is_err());
        fs::remove_file(path("link")).unwrap();
    }
    let error = localize(&["--trajectory", &path("a"), "--json", &path("a~")]).unwrap_err().to_string();
    assert!(error.contains("--json") && error.contains("kept under that name"), "{error}");
    localize(&["--plots", &path("out"), "--json", &path("out/numbers.json")]).unwrap();
    localize(&["--json", "/dev/null", "--trajectory", "/dev/null"]).unwrap();
    // Truth and estimate of a run, and the pictures beside them.
    fs::write(path("truth.tum"), "").unwrap();
    let all = folder.path().to_str().unwrap();
    check(&line(&["visloc", "evaluate", &path("truth.tum"), "robot.csv", "--plots", all])).unwrap();
    // A plan that a picture of it would replace, directly or by the map that names it.
    fs::write(path("map.svg"), "").unwrap();
    assert!(check(&line(&["visloc", "map", "check", &path("map.svg"), "--plots", all])).is_err());
    fs::rename(path("map.svg"), path("map.png")).unwrap();
    fs::write(path("grid.yaml"), "image: map.png\nresolution: 0.05\n").unwrap();
    let error = check(&line(&["visloc", "map", "check", &path("grid.yaml"), "--plots", all])).unwrap_err();
    assert!(error.to_string().contains("map.png") && error.to_string().contains("grid.yaml"), "{error}");
}

#[test]
fn a_map_may_become_another_one_but_what_is_kept_of_it_may_not_be_lost() {
    let folder = tempfile::tempdir().unwrap();
    let path = |name: &str| folder.path().join(name);
    for name in ["a.vmap", "a.vmap~"] {
        fs::write(path(name), "precious").unwrap();
    }
    let line = |load: &str, save: &str| {
        let [load, save] = [load, save].map(|name| path(name).to_str().unwrap().to_owned());
        ["visloc", "slam", "sim:room", "--load", &load, "--save", &save].map(str::to_owned)
    };
    check(&line("a.vmap", "a.vmap")).unwrap();
    check(&line("a.vmap", "b.vmap")).unwrap();
    let error = check(&line("a.vmap~", "a.vmap")).unwrap_err().to_string();
    assert!(error.contains("a.vmap~, which is read"), "{error}");
}

#[test]
fn numbers_are_asked_for_in_words() {
    let mut num_checked = 0;
    for (words, mut command) in all_leaves() {
        command.build();
        for arg in command.get_arguments().filter(|arg| !arg.is_positional()) {
            let is_number = is::<f64>(arg)
                || is::<u64>(arg)
                || is::<u32>(arg)
                || is::<u16>(arg)
                || is::<u8>(arg)
                || is::<usize>(arg);
            let Some(long) = arg.get_long().filter(|_| is_number) else { continue };
            for typed in ["many", "1e400", "nan", "99999999999999999999999x"] {
                let num_values = arg.get_num_args().map_or(1, |range| range.min_values());
                let option = std::iter::once(format!("--{long}")).chain(vec![typed.to_owned(); num_values]);
                let line: Vec<String> = words.iter().cloned().chain(option).collect();
                let error = Cli::command().try_get_matches_from(&line).unwrap_err();
                let message = error.to_string();
                let is_worded =
                    message.contains(": expected a number") || message.contains(": expected a whole number");
                assert!(is_worded, "{line:?}: {message}");
                num_checked += 1;
            }
        }
    }
    assert!(num_checked > 200, "{num_checked}");
}
