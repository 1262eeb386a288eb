//! Why a run localized or tracked nothing, or almost nothing, in words: what was counted, and the option that helps.

use serde::Serialize;
use visloc_locate::{LOCALIZED_RELIABILITY, StartPrior, diagnosis as locating};
use visloc_slam::diagnosis as tracking;

/// One reason.
#[derive(Debug, Clone, Serialize)]
pub struct FindingReport {
    /// Name of the reason for programs.
    pub code: &'static str,
    /// When the judged images begin, seconds after the first one.
    pub from_s: f64,
    /// Share of the judged images, 0 to 1.
    pub share: f64,
    /// What was found.
    pub sentence: String,
    /// What helps.
    pub advice: &'static str,
}

/// Reasons for few localized images; none if there are enough. What was said of the `start` is not asked for.
pub fn explain_localization(diagnosis: &locating::Diagnosis, start: &StartPrior) -> Vec<FindingReport> {
    let report = |finding: &locating::Finding| {
        let (sentence, advice) = of_localization(finding.cause, &diagnosis.facts);
        let advice = with_start(finding.cause, start).unwrap_or(advice);
        let from_s = diagnosis.facts.judged_from_secs;
        FindingReport { code: finding.cause.code(), from_s, share: finding.share, sentence, advice }
    };
    diagnosis.findings.iter().map(report).collect()
}

/// The reason why a photo shows no place.
pub fn explain_photo(cause: locating::Cause) -> FindingReport {
    let (sentence, advice) = of_localization(cause, &locating::RunFacts::default());
    // A photo has no topics.
    let advice = if cause == locating::Cause::Gray { "give it a photo in color" } else { advice };
    FindingReport { code: cause.code(), from_s: 0.0, share: 1.0, sentence, advice }
}

/// What helps where the start that would help was given.
fn with_start(cause: locating::Cause, start: &StartPrior) -> Option<&'static str> {
    match (cause, start) {
        (locating::Cause::PointSymmetric, StartPrior::Uniform) => None,
        (locating::Cause::PointSymmetric, _) => Some(
            "the start that was given does not decide it: did the robot begin elsewhere, or is this the map of another field? Goals of two colors \
             tell the half if the map has them (colors in [goals])",
        ),
        (locating::Cause::LookAlikes, StartPrior::Poses(_)) => Some(
            "the start that was given does not decide it: is it right in the map's frame (visloc map check shows the map)? Or let the robot drive on until \
             it sees a difference",
        ),
        _ => None,
    }
}

/// Reasons for few tracked images; none if there are enough.
pub fn explain_tracking(diagnosis: &tracking::Diagnosis) -> Vec<FindingReport> {
    let report = |finding: &tracking::Finding| {
        let (sentence, advice) = of_tracking(finding.cause, &diagnosis.facts);
        FindingReport { code: finding.cause.code(), from_s: 0.0, share: finding.share, sentence, advice }
    };
    diagnosis.findings.iter().map(report).collect()
}

/// For people. `what` is what was not reached, for instance `localized`.
pub fn diagnosis_lines(what: &str, findings: &[FindingReport]) -> Vec<String> {
    let mut lines = match findings.first() {
        None => return Vec::new(),
        Some(first) if first.from_s > 0.0 => {
            vec![format!(
                "Why so little was {what} after the first {} s, by share of those images:",
                first.from_s
            )]
        }
        Some(_) => vec![format!("Why so little was {what}, by share of the images:")],
    };
    for FindingReport { share, sentence, advice, .. } in findings {
        lines.push(format!("  {:3.0} %  {sentence}", 100.0 * share));
        lines.push(format!("         -> {advice}"));
    }
    lines
}

fn of_localization(cause: locating::Cause, facts: &locating::RunFacts) -> (String, &'static str) {
    use locating::Cause;
    match cause {
        Cause::Unusable
        | Cause::Black
        | Cause::White
        | Cause::Calibration
        | Cause::CameraOnGround
        | Cause::CameraUp
        | Cause::CameraDown
        | Cause::Gray => of_camera(cause, facts),
        Cause::Lifted => (
            "the feet carry nothing, so the robot counts as lifted".to_owned(),
            "if it stands: leave the foot sensors out with foot_pressure = \"\" and foot_contact = \"\" in --topics FILE",
        ),
        Cause::MapWithoutDoors => (
            "the map has no doors, and bare walls alone confirm no place".to_owned(),
            "add the doors to the map ([[doors]], docs/own-map.md); visloc map check shows what it has",
        ),
        Cause::FieldImage => (
            "the image shows the green carpet of a field, but the map is a building".to_owned(),
            "name the field: --map robocup-spl-2010, robocup-spl-2024 or your own (visloc maps)",
        ),
        Cause::NoCarpet => (
            "no carpet in the image: a field's lines are looked for on green only".to_owned(),
            "in a building: --map office or your own; on a field: teach its colors with visloc colors, then --pipeline FILE",
        ),
        Cause::FewBorders => (
            "there is carpet, but hardly a border of a line or a goal".to_owned(),
            "raise or turn the camera; do the goals have the map's colors (colors in [goals])? --plots DIR draws what is dropped (analysis.png)",
        ),
        Cause::NoDoors => (
            "no edge of a door is in the image, in the map's colors of doors".to_owned(),
            "compare the colors of the map's doors with --plots DIR (analysis.png); turn or raise the camera",
        ),
        Cause::PointSymmetric => (
            "the place is known up to the half: the field looks the same turned by 180 degrees".to_owned(),
            "say in which half (of x) the robot starts: --start half:negative or --start half:positive; goals of two \
             colors tell it if the map has them (colors in [goals]); if it is said, this may be the map of another field",
        ),
        Cause::LookAlikes => (
            "several places of the map fit as well".to_owned(),
            "say where the robot starts: --start pose:X,Y,HEADING; or let it drive on until it sees a difference",
        ),
        Cause::Unexplained => (
            format!("borders are seen, but no place of the map explains them; {}", camera_words(facts)),
            "compare these with the real camera: --camera FILE, --camera-height, --camera-tilt; and the map's sizes and goal colors",
        ),
        Cause::Unconfirmed => (
            format!("a place fits, but was not confirmed: {}; {}", best_words(facts), camera_words(facts)),
            "more different views help: let the robot move and look around; a wrong --map, --camera, --camera-height or --camera-tilt, and \
             stamps of tf that are not those of the images, fit nowhere for long; --plots DIR draws the reliability (errors.png)",
        ),
        Cause::ShortRun => (
            format!("the run is short ({:.1} s): {}", facts.duration_secs, best_words(facts)),
            "most runs need one to three seconds and some views; give it more images",
        ),
        Cause::SameView => (
            "the camera saw the same all the time: the robot stood, and did not look around".to_owned(),
            "turn the head or drive; or say where it stands: --start pose:X,Y,HEADING",
        ),
        Cause::NoOdometry => (
            "there is no odometry, so what is seen in one place does not help at the next".to_owned(),
            "a recording's odometry is named with --odometry-topic TOPIC",
        ),
    }
}

/// What is wrong with images and camera.
fn of_camera(cause: locating::Cause, facts: &locating::RunFacts) -> (String, &'static str) {
    use locating::Cause;
    match cause {
        Cause::Black => ("the image is black".to_owned(), BLACK_ADVICE),
        Cause::White => ("the image is overexposed".to_owned(), WHITE_ADVICE),
        Cause::Calibration => (
            format!("the calibration is that of no usual lens: {:.1} degrees wide", facts.view_deg),
            "give the calibration of this camera for this size of image: --camera FILE (visloc calibrate makes one)",
        ),
        Cause::CameraOnGround => (
            format!("the camera is said to be {:.2} m above the ground", facts.height_m),
            "--camera-height M says how high it is; in a recording --base-frame has to name a frame on the ground",
        ),
        Cause::CameraUp => (
            format!("the camera is said to look {} and sees no ground", tilt_words(facts.tilt_deg)),
            "--camera-tilt DEG is positive down; in a recording --camera-frame has to name the optical frame (z ahead)",
        ),
        Cause::CameraDown => (
            format!(
                "the camera is said to look {} from {:.2} m, and sees only the ground at its feet",
                tilt_words(facts.tilt_deg),
                facts.height_m
            ),
            "correct --camera-tilt DEG and --camera-height M, or raise the camera: lines and doors are farther away",
        ),
        Cause::Gray => (
            "the image has no colors, and carpet, goals and doors are told by color".to_owned(),
            "give it color images; of a recording with several topics name the one that has them: --image-topic TOPIC",
        ),
        _ => (
            "the image has not the size of its calibration".to_owned(),
            "give the calibration of this camera for this size of image: --camera FILE",
        ),
    }
}

/// That a camera is in none of the places of a map of SLAM, and what helps.
pub const NOT_RECOGNIZED: (&str, &str) = (
    "the place is not recognized: the image looks like no place of the map",
    "is it the map of this place? Then teach it from here and in this light too: visloc slam SOURCE --load MAP --save MAP",
);

const BLACK_ADVICE: &str = "look at the lens cap, the light and the camera's exposure";
const WHITE_ADVICE: &str = "give the camera less exposure or gain";

fn camera_words(facts: &locating::RunFacts) -> String {
    format!(
        "the camera is said to see {:.0} degrees, {:.2} m above the ground, looking {}",
        facts.view_deg,
        facts.height_m,
        tilt_words(facts.tilt_deg)
    )
}

fn tilt_words(tilt_deg: f64) -> String {
    let side = if tilt_deg < 0.0 { "up" } else { "down" };
    format!("{:.0} degrees {side}", tilt_deg.abs())
}

fn best_words(facts: &locating::RunFacts) -> String {
    let (reliability, secs) = facts.best_reliability;
    if reliability < 0.005 {
        return format!("the reliability stayed at 0.00, {LOCALIZED_RELIABILITY} is needed");
    }
    let how_long = if reliability > LOCALIZED_RELIABILITY { "for moments only" } else { "at most" };
    format!(
        "the reliability was {reliability:.2} {how_long} (at {secs:.1} s), {LOCALIZED_RELIABILITY} is needed"
    )
}

fn of_tracking(cause: tracking::Cause, facts: &tracking::RunFacts) -> (String, &'static str) {
    use tracking::Cause;
    match cause {
        Cause::Unusable => (
            "the image has not the size of its calibration, or is not later than the one before".to_owned(),
            "give the calibration of this camera for this size of image: --camera FILE",
        ),
        Cause::Black => ("the image is black".to_owned(), BLACK_ADVICE),
        Cause::White => ("the image is overexposed".to_owned(), WHITE_ADVICE),
        Cause::NoTexture => (
            format!(
                "there is little texture: {:.0} corners an image where starts were tried",
                facts.num_corners
            ),
            "things with patterns have to be in view, in larger images; --set start.min_points=N starts with fewer corners",
        ),
        Cause::StandingStill => (
            "the camera stands still: depth comes from motion".to_owned(),
            "move it to the side, by a tenth of the distance to what it sees; of a fast video --stride N",
        ),
        Cause::OnlyTurned => (
            "the camera only turns: without parallax there is no depth".to_owned(),
            "move it to the side while it turns",
        ),
        Cause::FewImages => (
            format!(
                "the images are {:.2} s apart, too much to follow corners from one to the next",
                facts.step_secs
            ),
            "more images a second, or a slower camera; a smaller --stride",
        ),
        Cause::TooFast => (
            format!(
                "from one image to the next ({:.2} s) most corners are lost: fast turns, motion blur or cuts",
                facts.step_secs
            ),
            "turn slower, expose shorter, or record more images a second",
        ),
        Cause::NoCommonMotion => (
            "the corners do not move together as those of one rigid scene".to_owned(),
            "look at the calibration (visloc check-camera), at people and things that move, and at video stabilization",
        ),
        Cause::NotRecognized => (NOT_RECOGNIZED.0.to_owned(), NOT_RECOGNIZED.1),
        Cause::Lost => (
            match facts.lost_at_secs {
                Some(secs) => format!("the camera was lost for good {secs:.1} s after the first image"),
                None => "the camera was lost and not found again for long".to_owned(),
            },
            "it is found where it has been before: go back there, turn slower; or begin anew behind it: --from 4.5s",
        ),
        Cause::ShortRun => (
            match facts.num_images {
                1 => "there is only one image".to_owned(),
                num => format!("there are only {num} images"),
            },
            "a start needs a second or two of a camera that moves to the side",
        ),
    }
}

#[cfg(test)]
mod tests {
    use clap::CommandFactory;

    use super::*;
    use crate::args::Cli;

    /// Options that an advice names.
    fn options(advice: &str) -> Vec<String> {
        let words = advice.split(|c: char| !(c.is_ascii_alphanumeric() || c == '-'));
        words.filter_map(|word| word.strip_prefix("--")).map(str::to_owned).collect()
    }

    fn known_options(command: &str) -> Vec<String> {
        let cli = Cli::command();
        let command = cli.find_subcommand(command).unwrap();
        command.get_arguments().filter_map(|argument| argument.get_long()).map(str::to_owned).collect()
    }

    #[test]
    fn every_cause_has_a_sentence_and_an_advice_with_options_that_exist() {
        let facts = locating::RunFacts::default();
        let localized = locating::Cause::ALL.map(|cause| of_localization(cause, &facts));
        let facts = tracking::RunFacts::default();
        let tracked = tracking::Cause::ALL.map(|cause| of_tracking(cause, &facts));
        for (command, words) in [("localize", localized.to_vec()), ("slam", tracked.to_vec())] {
            let known = known_options(command);
            let mut sentences = Vec::new();
            for (sentence, advice) in words {
                for option in options(advice) {
                    assert!(known.contains(&option), "{command} has no --{option}: {advice}");
                }
                assert!(
                    sentence.len() > 15 && advice.len() > 20 && !sentences.contains(&sentence),
                    "{sentence}"
                );
                sentences.push(sentence);
            }
        }
    }

    #[test]
    fn advice_for_photos_names_options_of_locate() {
        use locating::Cause;
        let known = known_options("locate");
        for cause in [
            Cause::Black,
            Cause::White,
            Cause::Gray,
            Cause::NoCarpet,
            Cause::MapWithoutDoors,
            Cause::FieldImage,
        ] {
            let advice = explain_photo(cause).advice;
            assert!(options(advice).iter().all(|option| known.contains(option)), "{advice}");
        }
    }

    #[test]
    fn lines_tell_share_sentence_and_advice() {
        let finding = locating::Finding { cause: locating::Cause::Gray, share: 0.97 };
        let diagnosis = locating::Diagnosis { findings: vec![finding], ..locating::Diagnosis::default() };
        let lines = diagnosis_lines("localized", &explain_localization(&diagnosis, &StartPrior::Uniform));
        assert_eq!(lines.len(), 3);
        assert!(lines[1].starts_with("   97 %  the image has no colors"), "{lines:?}");
        assert!(lines[2].contains("--image-topic"));
        assert!(diagnosis_lines("localized", &[]).is_empty());
    }

    #[test]
    fn a_start_that_was_given_is_not_asked_for() {
        let advice = |cause, start: &StartPrior| {
            let findings = vec![locating::Finding { cause, share: 1.0 }];
            let diagnosis = locating::Diagnosis { findings, ..locating::Diagnosis::default() };
            explain_localization(&diagnosis, start)[0].advice
        };
        let pose = StartPrior::Poses(Vec::new());
        for cause in [locating::Cause::PointSymmetric, locating::Cause::LookAlikes] {
            assert!(advice(cause, &StartPrior::Uniform).contains("--start"));
            assert!(!advice(cause, &pose).contains("--start"));
        }
        assert_eq!(advice(locating::Cause::Gray, &pose), advice(locating::Cause::Gray, &StartPrior::Uniform));
    }
}
