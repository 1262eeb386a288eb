//! `visloc maps` and `visloc map`.

use std::path::Path;

use anyhow::{Result, anyhow, bail};
use serde::Serialize;
use visloc_plot::{FieldPicture, field_picture};
use visloc_world::{BUILT_IN_MAPS, Hindrance, ImportNote, Map, field::Field, office::Office};

use super::{map_merge, visual_map};
use crate::{
    args::{JsonArg, ListArgs, MapArgs, MapCommand},
    report::{Listed, ground, print_list, save_json},
    run::print_or_write,
    say,
    slam::is_map_of_slam,
};

/// Runs the command.
pub fn execute(args: &MapArgs) -> Result<()> {
    match &args.command {
        MapCommand::Check { map, plots, json } => {
            let (loaded, notes) = Map::load_with_notes(map)?;
            let hindrances = loaded.what_hinders_localization();
            say::line!("{map}: {}", if hindrances.is_empty() { "fine" } else { "can be read, but" });
            for hindrance in &hindrances {
                say::line!("  {hindrance}");
            }
            describe(&loaded);
            for note in &notes {
                say::line!("  note            {note}");
            }
            if let Some(folder) = plots {
                draw(folder, &loaded)?;
            }
            if let Some(path) = &json.json {
                save_json(path, &Findings { map, name: loaded.name(), hindrances, notes })?;
            }
        }
        MapCommand::Import { file, out } => {
            let (loaded, notes) = Map::load_with_notes(file)?;
            print_or_write(&loaded.to_toml()?, out)?;
            // Beside the map, which may go to a file.
            for note in notes.iter().map(ToString::to_string) {
                eprintln!("note: {note}");
            }
            for hindrance in loaded.what_hinders_localization() {
                eprintln!("note: {hindrance}");
            }
        }
        MapCommand::Info { map, plots, json } => visual_map::info(map, plots.as_deref(), json)?,
        MapCommand::Align(args) => visual_map::align(args)?,
        MapCommand::Merge { map, other, out, seed } => map_merge::merge(map, other, out, seed.value())?,
        MapCommand::Trim { map, keyframes, out } => map_merge::trim(map, *keyframes as usize, out)?,
        MapCommand::Export { map, points, colmap, nerfstudio, floor } => {
            let wanted = visual_map::Wanted {
                floor: floor.as_deref(),
                points: points.as_deref(),
                colmap: colmap.as_deref(),
                nerfstudio: nerfstudio.as_deref(),
            };
            visual_map::export(map, &wanted)?;
        }
        MapCommand::Show { map, plots, out } if is_map_of_slam(map) => {
            if out.out.is_some() {
                bail!("--out: expected a drawn map, found one of SLAM, which is no text");
            }
            visual_map::info(Path::new(&**map), plots.as_deref(), &JsonArg { json: None })?;
        }
        MapCommand::Show { map, plots, out } => {
            let known = BUILT_IN_MAPS.iter().find(|(name, _)| *name == &**map);
            let (name, text) = known.ok_or_else(|| {
                anyhow!(
                    "no built-in map \"{map}\"; known: {}; a file is checked by visloc map check, and made TOML by visloc map import",
                    names()
                )
            })?;
            if let Some(folder) = plots {
                draw(folder, &Map::parse(name, text)?)?;
            }
            if plots.is_none() || out.out.is_some() {
                print_or_write(text, out)?;
            }
        }
    }
    Ok(())
}

/// What `--json` writes.
#[derive(Serialize)]
struct Findings<'a> {
    map: &'a str,
    name: &'a str,
    hindrances: Vec<Hindrance>,
    notes: Vec<ImportNote>,
}

/// Draws a map.
fn draw(folder: &Path, map: &Map) -> Result<()> {
    let Some(ground) = ground(map) else { return Ok(()) };
    let picture = FieldPicture { title: map.name().to_owned(), ..FieldPicture::default() };
    field_picture(ground, &picture).save(folder, "map")?;
    say::line!("picture: {}", folder.join("map.png").display());
    Ok(())
}

/// Prints name and size of every built-in map.
pub fn list(args: &ListArgs) -> Result<()> {
    let listed = |(name, text)| {
        let summary = match Map::parse(name, text)? {
            Map::Field(field) => in_one_line(&field),
            Map::Office(office) => office_in_one_line(&office),
            other => other.name().to_owned(),
        };
        Ok(Listed::new(name, summary))
    };
    print_list(&BUILT_IN_MAPS.into_iter().map(listed).collect::<Result<Vec<_>>>()?, args)
}

fn names() -> String {
    BUILT_IN_MAPS.map(|(name, _)| name).join(", ")
}

fn in_one_line(field: &Field) -> String {
    let d = field.dimensions();
    let goals = format!("{:?} and {:?} goal", d.goals.colors[0], d.goals.colors[1]).to_lowercase();
    format!("field of {} x {} m, {goals}", d.length_m, d.width_m)
}

fn office_in_one_line(office: &Office) -> String {
    let num_doors = office.plan().doors.len();
    format!("building with {:.0} m2 of floor and {num_doors} doors", office.free_space().area_m2())
}

fn describe(map: &Map) {
    match map {
        Map::Field(field) => describe_field(field),
        Map::Office(office) => describe_office(office),
        other => say::line!("  {}", other.name()),
    }
}

fn describe_office(office: &Office) {
    let plan = office.plan();
    let [min, max] = office.free_space().bounds_m();
    say::line!("  name            {}", plan.name);
    say::line!(
        "  extent          x {} to {} m, y {} to {} m",
        round(min.x),
        round(max.x),
        round(min.y),
        round(max.y)
    );
    say::line!("  free floor      {:.1} m2", office.free_space().area_m2());
    say::line!(
        "  walls           {}, {:.1} m seen in all, {}",
        office.walls().len(),
        office.wall_length_m(),
        plan.wall_color
    );
    let num_open = plan.doors.iter().filter(|door| door.is_open).count();
    let colors: Vec<String> = office.door_colors().iter().map(ToString::to_string).collect();
    let colors = if colors.is_empty() { String::new() } else { format!("; {}", colors.join(", ")) };
    say::line!("  doors           {}, {num_open} of them open{colors}", plan.doors.len());
    say::line!("  floor           {}", plan.floor_color);
}

/// To a hundredth.
fn round(value_m: f64) -> f64 {
    (value_m * 100.0).round() / 100.0
}

fn describe_field(field: &Field) {
    let d = field.dimensions();
    say::line!("  name            {}", d.name);
    say::line!("  between lines   {} x {} m", d.length_m, d.width_m);
    say::line!("  carpet          {} x {} m", d.length_m + 2.0 * d.border_m, d.width_m + 2.0 * d.border_m);
    say::line!("  lines           {} m wide", d.line_width_m);
    say::line!("  center circle   {} m diameter", d.center_circle_diameter_m);
    say::line!("  penalty marks   {} m from the goal line", d.penalty_mark_from_goal_line_m);
    for area in &d.boxes {
        say::line!("  box at goal     {} m deep, {} m wide", area.depth_m, area.width_m);
    }
    let goals = &d.goals;
    say::line!(
        "  goals           {:?} at +x, {:?} at -x; {} m wide, {} m high, posts of {} m",
        goals.colors[0],
        goals.colors[1],
        goals.inner_width_m,
        goals.inner_height_m,
        goals.post_diameter_m
    );
}
