//! Limits and damages.

use std::time::{Duration, Instant};

use rand::{RngExt, SeedableRng};

use super::{
    load, load_with,
    plan::{GRID, LIST, SVG, binary_dxf, dxf, dxf_pairs, l_shaped, pgm},
};

#[test]
fn large_files_are_refused_or_read_in_time() {
    let svg = |inside: String| format!("<svg viewBox=\"0 0 1 1\">{inside}</svg>");
    let lines = |count: usize, of: &dyn Fn(usize) -> String| (0..count).map(of).collect::<String>();
    let wall = |i: usize| {
        format!("<path id=\"wall\" d=\"M{} {}h1\"/>", (i % 200) as f64 * 2.0, (i / 200) as f64 * 2.0)
    };
    let rules = format!("<style>{}</style>", lines(20_000, &|i| format!(".a{i} g > b {{fill:red}}")));
    let list =
        |count: usize| format!("walls:\n{}", lines(count, &|i| format!(" - [0, {i}.0, 0.1, {i}.0]\n")));
    let cases: [(&str, &str, String, Option<&str>); 8] = [
        (
            "200,000 groups in each other",
            "a.svg",
            svg("<g>".repeat(200_000) + &"</g>".repeat(200_000)),
            Some("at most 200"),
        ),
        ("50,000 walls", "a.svg", svg(lines(50_000, &wall)), Some("at most 40000")),
        ("18,000 walls", "a.svg", svg(lines(18_000, &wall)), None),
        ("many rules", "a.svg", svg(rules + &"<g/>".repeat(10_000)), Some("at most 128 kB")),
        ("walls one upon the other", "a.svg", svg("<path id=\"wall\" d=\"M0 0h9\"/>".repeat(15_000)), None),
        ("30,000 walls in a list", "a.yaml", list(30_000), Some("at most 20000")),
        ("9,000 walls in a list", "a.yaml", list(9_000), None),
        (
            "a huge building",
            "a.yaml",
            "walls:\n - [0, 0, 9000, 0]\n - [9000, 0, 9000, 9000]\n".into(),
            Some("is the unit right?"),
        ),
    ];
    for (what, name, text, expected) in cases {
        let begin = Instant::now();
        match (load(name, &text), expected) {
            (Ok(_), None) => {}
            (Err(error), Some(part)) => assert!(error.to_string().contains(part), "{what}: {error}"),
            (other, _) => panic!("{what}: {:?}", other.map(|_| ())),
        }
        let limit = if cfg!(debug_assertions) { 30 } else { 5 };
        assert!(begin.elapsed() < Duration::from_secs(limit), "{what}: {:?}", begin.elapsed());
    }
}

#[test]
fn damaged_files_are_read_or_refused_with_a_sentence() {
    let picture = pgm(l_shaped);
    let files: [(&str, Vec<u8>); 5] = [
        ("plan.svg", SVG.into()),
        ("plan.dxf", dxf(&dxf_pairs()).into_bytes()),
        ("binary.dxf", binary_dxf(&dxf_pairs())),
        ("plan.yaml", LIST.into()),
        ("grid.yaml", GRID.into()),
    ];
    let mut rng = rand_chacha::ChaCha8Rng::seed_from_u64(1);
    let try_one = |name: &str, bytes: &[u8], picture: &[u8]| {
        let begin = Instant::now();
        let loaded = load_with(name, bytes, picture);
        assert!(begin.elapsed() < Duration::from_secs(1), "{name}: {:?}", begin.elapsed());
        match loaded {
            Ok((map, _)) => drop(map.what_hinders_localization()),
            Err(error) => {
                let text = error.to_string();
                assert!(text.starts_with("map ") && text.len() < 2000, "{text}");
            }
        }
    };
    for (name, bytes) in &files {
        for part in 0..20 {
            try_one(name, &bytes[..bytes.len() * part / 20], &picture);
        }
        for _ in 0..100 {
            let mut damaged = bytes.clone();
            for _ in 0..rng.random_range(1..6) {
                let at = rng.random_range(0..damaged.len());
                damaged[at] = if rng.random_bool(0.5) {
                    rng.random()
                } else {
                    b"0123456789-.eE <>/\n"[rng.random_range(0..19)]
                };
            }
            try_one(name, &damaged, &picture);
        }
    }
    for _ in 0..300 {
        let letter = |_| char::from(b".#*{}:;,>@/[]()\"'ab 0-!+~|=\\"[rng.random_range(0..28)]);
        let sheet: String = (0..40).map(letter).collect();
        try_one(
            "plan.svg",
            format!("<svg><style><![CDATA[{sheet}]]></style><g/></svg>").as_bytes(),
            &picture,
        );
    }
    for part in 0..20 {
        try_one("grid.yaml", GRID.as_bytes(), &picture[..picture.len() * part / 20]);
    }
    for _ in 0..50 {
        let mut damaged = picture.clone();
        let at = rng.random_range(0..40);
        damaged[at] = rng.random();
        try_one("grid.yaml", GRID.as_bytes(), &damaged);
    }
}
