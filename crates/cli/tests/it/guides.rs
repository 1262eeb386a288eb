//! The commands of the guides do what the guides say.
//!
//! Every block ```` ```console ```` of every guide is run: lines behind `$ ` are commands, the lines below them are what the commands
//! print. Words must agree, `...` stands for anything, and a number may differ by a quarter or by a unit and a half of its last
//! digit. A block ```` ```toml ```` that begins with a comment `# NAME.toml` is a file. Commands about files that stand for the
//! reader's own must be understood, and then say that there is no such file.

use std::{fs, path::Path, process::Command, thread};

use super::support::Workspace;

/// Files and folders that stand for the reader's own.
const READERS_OWN: [&str; 33] = [
    "photo.jpg",
    "other.vmap",
    "first.mp4",
    "later.mp4",
    "other.mp4",
    "room.vmap",
    "drive.vmap",
    "old.bag",
    "rosbag2_folder",
    "recording.mcap",
    "my-field.toml",
    "my-run",
    "clip.mp4",
    "cut.mp4",
    "cut.mkv",
    "drive.mcap",
    "game.mcap",
    "field.png",
    "plan.dxf",
    "plan.svg",
    "map.yaml",
    "a.toml",
    "second-floor.toml",
    "other-photos",
    "desk",
    "MH_01_easy",
    "kitti/sequences/06",
    "groundtruth.txt",
    "06.txt",
    "O2/O2.mcap",
    "part1",
    "S7",
    "rgbd_dataset_freiburg2_desk",
];

/// Commands that are not run, and why.
const NOT_RUN: [(&str, &str); 17] = [
    ("visloc benchmark", "minutes; tested with fewer runs"),
    ("ros2:", "waits for a robot"),
    ("v4l2:", "waits for a camera"),
    ("loop:", "goes on until it is interrupted"),
    ("part$K", "a long run on many machines"),
    ("experiment symmetry", "minutes; tested with fewer runs"),
    ("experiment office", "minutes; tested with fewer runs"),
    ("experiment robocup", "minutes; tested with fewer runs"),
    ("experiment slam-kidnap", "minutes; tested with fewer runs"),
    ("cargo run", "tests do not build"),
    ("ros2 ", "another program"),
    ("evo_ape", "another program"),
    ("python3", "another program"),
    ("ffmpeg", "another program"),
    ("visloc demo", "tested by itself"),
    ("slam photos", "photos of a board are no sequence"),
    ("localize sim:office ", "a minute"),
];

/// Part of a guide.
struct Block {
    language: String,
    text: String,
    line: usize,
}

fn blocks(text: &str) -> Vec<Block> {
    let mut blocks = Vec::new();
    let mut open: Option<(Block, usize)> = None;
    for (index, line) in text.lines().enumerate() {
        let indent = line.len() - line.trim_start().len();
        let Some((block, margin)) = &mut open else {
            if let Some(language) =
                line.trim_start().strip_prefix("```").filter(|language| !language.is_empty())
            {
                let block =
                    Block { language: language.trim().to_owned(), text: String::new(), line: index + 1 };
                open = Some((block, indent));
            }
            continue;
        };
        if line.trim() == "```" {
            blocks.extend(open.take().map(|(block, _)| block));
        } else {
            block.text += line.get(*margin..).unwrap_or_default();
            block.text += "\n";
        }
    }
    blocks
}

/// Commands and what is printed after them.
#[derive(Default)]
struct Step {
    commands: Vec<String>,
    printed: String,
}

fn steps(text: &str) -> Vec<Step> {
    let mut steps = vec![Step::default()];
    let mut lines = text.lines();
    while let Some(line) = lines.next() {
        let Some(first) = line.strip_prefix("$ ") else {
            let step = steps.last_mut().unwrap();
            step.printed += line;
            step.printed += "\n";
            continue;
        };
        let mut command = first.to_owned();
        let end_of_text = first.split_once("<<").map(|(_, word)| word.trim().to_owned());
        let goes_on = |command: &str, line: &str| {
            let is_for = first.starts_with("for ") && line.trim() != "done";
            line.ends_with('\\')
                || is_for
                || end_of_text.as_ref().is_some_and(|_| !command.ends_with("\nEND"))
        };
        let mut last = first;
        while goes_on(&command, last) {
            last = lines.next().expect("the command ends in its block");
            command = command + "\n" + last;
        }
        if !steps.last().unwrap().printed.is_empty() {
            steps.push(Step::default());
        }
        steps.last_mut().unwrap().commands.push(command);
    }
    steps
}

/// Whether an error speaks of one of the reader's own files.
fn is_about_own_file(command: &str, error: &str) -> bool {
    let is_in = |name: &&&str| command.split_whitespace().any(|word| word == **name);
    READERS_OWN.iter().filter(is_in).any(|name| error.contains(name))
}

fn shell(workspace: &Workspace, command: &str) -> (i32, String) {
    let program = Path::new(env!("CARGO_BIN_EXE_visloc")).parent().unwrap().display();
    let path = format!("{program}:{}", std::env::var("PATH").unwrap_or_default());
    let mut shell = Command::new("sh");
    let output =
        shell.args(["-c", command]).current_dir(workspace.path(".")).env("PATH", path).output().unwrap();
    let text = [output.stdout, output.stderr].concat();
    (output.status.code().expect("not killed"), String::from_utf8(text).unwrap())
}

/// The words of a text; how fast it went is left out.
fn words(text: &str) -> Vec<String> {
    let is_pace = |words: &[&str]| words.get(2..5) == Some(&["frames", "a", "second"]);
    let all: Vec<&str> = text.split_whitespace().collect();
    let mut kept = Vec::new();
    let mut index = 0;
    while index < all.len() {
        if all[index] == "at" && is_pace(&all[index..]) {
            index += 5;
            continue;
        }
        kept.push(all[index].to_owned());
        index += 1;
    }
    kept
}

/// Numbers of a word, and what stands between them.
fn numbers(word: &str) -> (Vec<f64>, Vec<f64>, String) {
    let (mut values, mut units, mut frame) = (Vec::new(), Vec::new(), String::new());
    let mut rest = word;
    while let Some(start) = rest.find(|c: char| c.is_ascii_digit()) {
        let length =
            rest[start..].find(|c: char| !c.is_ascii_digit() && c != '.').unwrap_or(rest.len() - start);
        let number = rest[start..start + length].trim_end_matches('.');
        frame = frame + &rest[..start] + "#";
        let decimals = number.split_once('.').map_or(0, |(_, decimals)| decimals.len());
        values.push(number.parse().unwrap_or(f64::NAN));
        units.push(10_f64.powi(-i32::try_from(decimals).unwrap()));
        rest = &rest[start + number.len()..];
    }
    (values, units, frame + rest)
}

/// Whether a word of the guide stands for what was printed.
fn agrees(said: &str, printed: &str) -> bool {
    let ((said, units, frame), (printed, _, other_frame)) = (numbers(said), numbers(printed));
    // A sign may flip around zero.
    let bare = |frame: &str| frame.replace(['-', '+'], "");
    let near =
        |((a, unit), b): ((&f64, &f64), &f64)| (a - b).abs() <= (0.25 * a.abs().max(b.abs())).max(1.5 * unit);
    bare(&frame) == bare(&other_frame)
        && said.len() == printed.len()
        && said.iter().zip(&units).zip(&printed).all(near)
}

/// The first word of the guide that was not printed where it should be, with its neighborhood.
fn disagreement(said: &str, printed: &str) -> Option<String> {
    let printed = words(printed);
    let mut at = 0;
    let parts: Vec<Vec<String>> = said.split("...").map(words).collect();
    for (index, part) in parts.iter().enumerate() {
        let fits =
            |start: usize| part.iter().zip(&printed[start..]).take_while(|(a, b)| agrees(a, b)).count();
        let starts = if index == 0 { at..=at } else { at..=printed.len().saturating_sub(part.len()).max(at) };
        let best = starts.max_by_key(|start| (fits(*start), usize::MAX - start)).unwrap_or(at);
        let length = fits(best);
        if length < part.len() {
            let found = printed[best..].iter().skip(length.saturating_sub(4)).take(9).cloned();
            let expected = part.iter().skip(length.saturating_sub(4)).take(9).cloned();
            let [expected, found] =
                [expected.collect::<Vec<_>>(), found.collect()].map(|words| words.join(" "));
            return Some(format!("the guide says\n    {expected}\nand the program\n    {found}"));
        }
        at = best + length;
    }
    None
}

/// Runs the guide; what is wrong in it.
fn wrong_in(path: &Path) -> Vec<String> {
    let (name, text) = (path.file_name().unwrap().display(), fs::read_to_string(path).unwrap());
    let workspace = Workspace::new();
    let root = Path::new(env!("CARGO_MANIFEST_DIR")).join("../..").canonicalize().unwrap();
    for folder in ["testdata", "maps", "scenarios"] {
        std::os::unix::fs::symlink(root.join(folder), workspace.path(folder)).unwrap();
    }
    let mut wrong = Vec::new();
    for block in blocks(&text) {
        let place = format!("{name}, line {}", block.line);
        match block.language.as_str() {
            "toml" => {
                let name = block.text.lines().next().and_then(|line| line.strip_prefix("# "));
                if let Some(name) = name.filter(|name| name.ends_with(".toml") && !name.contains(' ')) {
                    workspace.write(name, &block.text);
                }
            }
            "console" if !block.text.contains("$ ") => {
                wrong.push(format!(
                    "{place}: expected a command in a block 'console'; a block 'text' needs none"
                ));
            }
            "console" => steps(&block.text).iter().for_each(|step| run(step, &place, &workspace, &mut wrong)),
            _ => {}
        }
    }
    wrong
}

fn run(step: &Step, place: &str, workspace: &Workspace, wrong: &mut Vec<String>) {
    let mut printed = String::new();
    let mut is_complete = true;
    for command in &step.commands {
        if NOT_RUN.iter().any(|(part, _)| command.contains(part)) {
            is_complete = false;
            continue;
        }
        let (code, text) = shell(workspace, command);
        match code {
            0 => printed += &text,
            1 if is_about_own_file(command, &text) => is_complete = false,
            // Some guides show what the program says to a mistake.
            1 if step.printed.contains("error: ") => printed += &text,
            code => wrong.push(format!("{place}: {command}\n  ends with {code}: {text}")),
        }
    }
    if is_complete && let Some(difference) = disagreement(&step.printed, &printed) {
        wrong.push(format!("{place}: {}\n  {difference}", step.commands.join("; ")));
    }
}

#[test]
fn the_guides_tell_the_truth() {
    let root = Path::new(env!("CARGO_MANIFEST_DIR")).join("../..");
    let mut names: Vec<_> =
        fs::read_dir(root.join("docs")).unwrap().map(|entry| entry.unwrap().path()).collect();
    names.push(root.join("README.md"));
    names.sort();
    names.retain(|path| path.extension().is_some_and(|extension| extension == "md"));
    let wrong: Vec<String> = thread::scope(|scope| {
        let guides: Vec<_> = names.iter().map(|path| scope.spawn(|| wrong_in(path))).collect();
        guides.into_iter().flat_map(|guide| guide.join().unwrap()).collect()
    });
    assert!(wrong.is_empty(), "{} places:\n{}", wrong.len(), wrong.join("\n"));
}

#[test]
fn what_agrees_and_what_does_not() {
    assert!(agrees("0.05", "0.06") && agrees("-0.01", "0.00") && agrees("70", "71") && agrees("fx", "fx"));
    assert!(!agrees("0.05", "0.08") && !agrees("70", "95") && !agrees("fx", "fy") && !agrees("3", "three"));
    assert!(disagreement("a 1 ... d", "a 1 b c d").is_none());
    assert!(disagreement("a 1 ... e", "a 1 b c d").is_some());
    assert!(
        disagreement("R1: 90 frames, at 743 frames a second", "R1: 90 frames, at 20 frames a second")
            .is_none()
    );
}
