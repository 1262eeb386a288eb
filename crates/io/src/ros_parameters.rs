//! Parameters as programs of ROS 2 take them from files (`--params-file`).

use std::collections::BTreeMap;

use toml::{Table, Value};

use crate::text::yaml_reason;

/// Sections that are for every node, then those of one, in the order in which they win.
const EVERYBODY: [&str; 3] = ["/**", "/*", "**"];

/// The parameters of a node, in order of their names: `/**: ros__parameters:`, and what stands for the node itself over it. Names are joined
/// with dots, as ROS does; sections of other nodes are passed over.
///
/// # Errors
/// If the text is no YAML, no section is for the node, or a value is none (ROS has no empty ones). The reason names the place.
pub fn read_ros_parameters(text: &str, node: &str) -> Result<BTreeMap<String, Value>, String> {
    let file: Table = serde_saphyr::from_str(text)
        .map_err(|error| format!("expected parameters of ROS 2 in YAML: {}", yaml_reason(&error)))?;
    let own = [node.to_owned(), format!("/{node}")];
    let mut parameters = BTreeMap::new();
    let mut is_meant = false;
    for section in EVERYBODY.into_iter().chain(own.iter().map(String::as_str)) {
        let Some(content) = file.get(section) else { continue };
        let Some(below) = content.get("ros__parameters").and_then(Value::as_table) else {
            return Err(format!("{section}: expected `ros__parameters:` with parameters below it"));
        };
        is_meant = true;
        flatten(below, "", &mut parameters);
    }
    if !is_meant {
        let found: Vec<&str> = file.keys().map(String::as_str).collect();
        let found = if found.is_empty() { "nothing".to_owned() } else { found.join(", ") };
        return Err(format!("expected a section `/**:` or `{node}:`, found {found}"));
    }
    Ok(parameters)
}

fn flatten(table: &Table, above: &str, parameters: &mut BTreeMap<String, Value>) {
    for (name, value) in table {
        let path = if above.is_empty() { name.clone() } else { format!("{above}.{name}") };
        match value {
            Value::Table(below) => flatten(below, &path, parameters),
            value => {
                parameters.insert(path, value.clone());
            }
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_nodes_own_section_wins_and_others_are_passed_over() {
        let text = "
/**:
  ros__parameters:
    map: robocup-spl-2024
    config: { evidence.per_image: 0.5, explorers: { num_random: 40 } }
    start: [half:negative, 'half:positive']
amcl:
  ros__parameters: { min_particles: 500 }
/visloc:
  ros__parameters:
    config.evidence.per_image: 0.25
    publish_ros: true
";
        let read = read_ros_parameters(text, "visloc").unwrap();
        let names: Vec<&str> = read.keys().map(String::as_str).collect();
        let expected =
            ["config.evidence.per_image", "config.explorers.num_random", "map", "publish_ros", "start"];
        assert_eq!(names, expected);
        assert_eq!(read["config.evidence.per_image"], Value::Float(0.25));
        assert_eq!(read["config.explorers.num_random"], Value::Integer(40));
        assert_eq!(read["publish_ros"], Value::Boolean(true));
        assert_eq!(read["start"].as_array().map(Vec::len), Some(2));
    }

    #[test]
    fn what_is_no_file_of_parameters_says_so() {
        let why = |text: &str| read_ros_parameters(text, "visloc").unwrap_err();
        assert!(why("amcl: { ros__parameters: { a: 1 } }").contains("`/**:` or `visloc:`, found amcl"));
        assert!(why("/**: { map: a }").contains("/**: expected `ros__parameters:`"));
        assert!(why("/**: { ros__parameters: { map: } }").contains("expected parameters of ROS 2"));
        assert!(why("a: [").contains("expected parameters of ROS 2"));
        assert!(why("").contains("expected"));
    }
}
