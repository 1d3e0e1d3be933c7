//! Logs: where a machine was, and when, as a controller or a laser tracker wrote it down.
//!
//! In: the bytes of a file. Out: a [`Log`], metres and seconds. Two layouts are read:
//!
//! - **Table**: a line `# frame: part` (or `object`, as controllers call the same frame), a head such as
//!   `t [s], x [mm], y [mm], z [mm]`, one row a sample. Commas, semicolons or tabs part the columns; their order is free,
//!   further columns are passed over. Units are obligatory.
//! - **SpatialAnalyzer text**: three `//` lines (version, frame, axes with their unit), then
//!   `collection, group, index, x, y, z, month/day/year hours:minutes:seconds`. The index is the time base: the clock's whole
//!   seconds only say how long one step of it is.
//!
//! Either holds positions of one point of the tool; which one (contact or tool centre point) shows in its height.

use crate::diagnostics::{Problem, codes};

/// The frame that a log's positions are in.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Frame {
    /// The part frame; the program's object frame is the same.
    Part,
}

impl Frame {
    /// The frame with this name.
    pub fn named(name: &str) -> Option<Frame> {
        matches!(name.trim().to_ascii_lowercase().as_str(), "part" | "object").then_some(Frame::Part)
    }
}

/// How a log is written down.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Layout {
    Table,
    SpatialAnalyzer,
}

/// The layout of a file that begins as a log does; `None` for every other file.
pub fn layout(bytes: &[u8]) -> Option<Layout> {
    let text = std::str::from_utf8(bytes).ok()?.trim_start_matches('\u{feff}');
    let mut lines = text.lines().map(str::trim).filter(|line| !line.is_empty());
    if text.trim_start().starts_with("//") {
        let mut comments = lines.map_while(|line| line.strip_prefix("//"));
        return comments.any(|line| line.trim_start().starts_with("AXES")).then_some(Layout::SpatialAnalyzer);
    }
    let head = lines.find(|line| !line.starts_with('#'))?;
    let heads: Vec<&str> = head.split(separator(head)).collect();
    COLUMNS.iter().all(|wanted| heads.iter().any(|head| is_column(head, wanted))).then_some(Layout::Table)
}

/// What a machine did.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct Log {
    /// The frame that the file states, if it does in words that we know.
    pub frame: Option<Frame>,
    /// What the file calls its frame.
    pub frame_name: Option<String>,
    /// Of SpatialAnalyzer's points.
    pub group: Option<String>,
    /// That the file gives x in.
    pub unit: String,
    /// Seconds from the first sample, strictly increasing.
    pub time: Vec<f64>,
    /// Metres.
    pub position: Vec<[f64; 3]>,
}

/// Largest log that is read. Ten hours at 1 kHz with 80 characters a line are 3 GB; at the usual 20 to 250 Hz a tenth of it.
pub const MOST_BYTES: u64 = 1 << 30;

/// Reads a log.
///
/// # Errors
///
/// E1302 for what cannot be read, E1303 where time does not go forward, E1304 for fewer than two samples.
pub fn read(bytes: &[u8], name: &str) -> Result<Log, Problem> {
    let text = std::str::from_utf8(bytes)
        .map_err(|_| unreadable(name, None, "is no text".into()))?
        .trim_start_matches('\u{feff}');
    let first = text.lines().find(|line| !line.trim().is_empty());
    match first {
        None => Err(too_few(name, 0)),
        Some(line) if line.trim_start().starts_with("//") => spatial_analyzer(text, name),
        Some(_) => table(text, name),
    }
}

fn unreadable(name: &str, line: Option<usize>, what: String) -> Problem {
    let at = line.map_or(String::new(), |line| format!(" line {line}"));
    Problem::error(codes::E1302, "log", format!("the log `{name}`{at}: {what}"))
        .help("a log begins with `# frame: part` and `t [s], x [mm], y [mm], z [mm]`, or is SpatialAnalyzer's text")
}

fn too_few(name: &str, count: usize) -> Problem {
    let samples = match count {
        0 => "no sample".to_string(),
        1 => "one sample".to_string(),
        count => format!("{count} samples"),
    };
    Problem::error(codes::E1304, "log", format!("the log `{name}` has {samples}; a speed needs two at least"))
        .help("give the log of the whole run")
}

fn not_forward(name: &str, line: usize, before: f64, now: f64) -> Problem {
    let message =
        format!("the log `{name}` line {line}: the time goes from {before:.6} s to {now:.6} s; it must go forward");
    Problem::error(codes::E1303, "log", message)
        .help("give the samples of one run, once each, in the order they were taken")
}

/// One number of a log.
fn number(text: &str, name: &str, line: usize) -> Result<f64, Problem> {
    match text.trim().parse::<f64>() {
        Ok(value) if value.is_finite() => Ok(value),
        _ => Err(unreadable(name, Some(line), format!("`{}` is no number", text.trim().escape_default()))),
    }
}

/// Units that a head may name, with their size in metres.
const LENGTHS: &[(&str, f64)] =
    &[("m", 1.0), ("mm", 1e-3), ("um", 1e-6), ("µm", 1e-6), ("inches", 0.0254), ("inch", 0.0254)];

const TIMES: &[(&str, f64)] = &[("s", 1.0), ("ms", 1e-3), ("us", 1e-6), ("µs", 1e-6)];

/// Name and unit of a column: `t [s]`, `x (mm)`, `x_mm`.
fn column(head: &str) -> Option<(String, &str)> {
    let head = head.trim().trim_matches('"').trim();
    let (name, unit) = match head.find(['[', '(']) {
        Some(at) => (&head[..at], head[at + 1..].trim_end_matches([']', ')'])),
        None => head.rsplit_once('_')?,
    };
    Some((name.trim().to_ascii_lowercase(), unit.trim()))
}

/// What a table must have, in the order that they are kept.
const COLUMNS: [&str; 4] = ["t", "x", "y", "z"];

/// Whether a head names this one of [`COLUMNS`]; `time` is another word for `t`.
fn is_column(head: &str, wanted: &str) -> bool {
    let name = column(head).map_or(head.trim().to_ascii_lowercase(), |(name, _)| name);
    name == wanted || (wanted == "t" && name == "time")
}

/// What parts the columns.
fn separator(head: &str) -> char {
    [';', '\t', ','].into_iter().find(|s| head.contains(*s)).unwrap_or(',')
}

fn table(text: &str, name: &str) -> Result<Log, Problem> {
    let mut lines = text.lines().enumerate().map(|(i, line)| (i + 1, line)).filter(|(_, line)| !line.trim().is_empty());
    let mut frame_name = None;
    let (head_line, head) = loop {
        match lines.next() {
            None => return Err(too_few(name, 0)),
            Some((_, line)) if line.trim_start().starts_with('#') => {
                let words = line.trim_start().trim_start_matches('#');
                if let Some((key, value)) = words.split_once(':')
                    && key.trim().eq_ignore_ascii_case("frame")
                {
                    frame_name = Some(value.trim().to_string());
                }
            }
            Some(found) => break found,
        }
    };
    let separator = separator(head);
    let heads: Vec<&str> = head.split(separator).collect();
    // Place in the row and size of the unit, for t, x, y, z.
    let mut columns = [(0usize, 0.0f64); 4];
    let mut unit_of_x = "";
    for (slot, wanted) in COLUMNS.into_iter().enumerate() {
        let mut found = heads.iter().enumerate().filter(|(_, head)| is_column(head, wanted));
        let (place, head) = match (found.next(), found.next()) {
            (Some(one), None) => one,
            (None, _) => return Err(unreadable(name, Some(head_line), format!("the head has no column `{wanted}`"))),
            _ => return Err(unreadable(name, Some(head_line), format!("the head has two columns `{wanted}`"))),
        };
        let units = if wanted == "t" { TIMES } else { LENGTHS };
        let unit = column(head).map(|(_, unit)| unit);
        let size = unit.and_then(|unit| units.iter().find(|(known, _)| *known == unit)).map(|(_, size)| *size);
        if wanted == "x" {
            unit_of_x = unit.unwrap_or_default();
        }
        columns[slot] = match (size, unit) {
            (Some(size), _) => (place, size),
            (None, None) => {
                let what = format!("the column `{wanted}` states no unit");
                return Err(unreadable(name, Some(head_line), what));
            }
            (None, Some(unit)) => {
                let known: Vec<&str> = units.iter().map(|(unit, _)| *unit).collect();
                let unit = unit.escape_default();
                let what = format!("the unit `{unit}` of `{wanted}` is none of {}", known.join(", "));
                return Err(unreadable(name, Some(head_line), what));
            }
        };
    }
    let mut log = Log { frame_name, unit: unit_of_x.to_string(), ..Log::default() };
    let last = columns.iter().map(|(place, _)| *place).max().unwrap_or(0);
    let mut fields: Vec<&str> = Vec::new();
    let mut start = 0.0;
    for (line, row) in lines {
        fields.clear();
        fields.extend(row.split(separator));
        if fields.len() <= last {
            let what = format!("{} values where the head has {}", fields.len(), heads.len());
            return Err(unreadable(name, Some(line), what));
        }
        let mut values = [0.0; 4];
        for (value, (place, size)) in values.iter_mut().zip(columns) {
            *value = number(fields[place], name, line)? * size;
        }
        let [t, x, y, z] = values;
        if log.time.is_empty() {
            start = t;
        }
        if let Some(before) = log.time.last().filter(|before| !(t - start > **before)) {
            return Err(not_forward(name, line, before + start, t));
        }
        log.time.push(t - start);
        log.position.push([x, y, z]);
    }
    finish(log, name)
}

fn finish(mut log: Log, name: &str) -> Result<Log, Problem> {
    if log.time.len() < 2 {
        return Err(too_few(name, log.time.len()));
    }
    log.frame = log.frame_name.as_deref().and_then(Frame::named);
    Ok(log)
}

/// `09:00:00`, with whatever date stands before it, in seconds of the day.
fn clock(text: &str) -> Option<f64> {
    let mut parts = text.split_whitespace().last()?.split(':');
    let mut next = || parts.next()?.parse::<f64>().ok();
    let (hours, minutes, seconds) = (next()?, next()?, next()?);
    let good = (0.0..24.0).contains(&hours) && (0.0..60.0).contains(&minutes) && (0.0..61.0).contains(&seconds);
    good.then_some((hours * 60.0 + minutes) * 60.0 + seconds)
}

/// Seconds of a day.
const DAY: f64 = 86_400.0;

fn spatial_analyzer(text: &str, name: &str) -> Result<Log, Problem> {
    let mut scale = None;
    let mut frame_name = None;
    let (mut index, mut seconds): (Vec<f64>, Vec<f64>) = (Vec::new(), Vec::new());
    let mut group: Option<(String, String)> = None;
    let mut log = Log::default();
    let mut days = 0.0f64;
    for (i, row) in text.lines().enumerate() {
        let line = i + 1;
        let row = row.trim();
        if row.is_empty() {
            continue;
        }
        if let Some(comment) = row.strip_prefix("//") {
            if let Some((_, rest)) = comment.split_once("Coordinate Frame") {
                frame_name = Some(rest.trim().trim_matches(['\'', '"']).to_string());
            } else if let Some((_, rest)) = comment.split_once("AXES") {
                if !rest.to_ascii_uppercase().contains("CARTESIAN") {
                    return Err(unreadable(name, Some(line), "only cartesian axes are read".into()));
                }
                let letters = rest.rsplit_once('(').and_then(|(axes, _)| axes.split_once(':')).map(|(_, axes)| axes);
                let in_order = |axes: &str| axes.split(',').map(str::trim).eq(["X", "Y", "Z"]);
                if !letters.is_some_and(in_order) {
                    return Err(unreadable(name, Some(line), "the axes are not X, Y, Z in this order".into()));
                }
                let unit = rest.rsplit_once('(').map(|(_, unit)| unit.trim_end().trim_end_matches(')').trim());
                let size = unit.and_then(|unit| LENGTHS.iter().find(|(known, _)| known.eq_ignore_ascii_case(unit)));
                log.unit = unit.unwrap_or_default().to_string();
                scale = Some(size.map(|(_, size)| *size).ok_or_else(|| {
                    let unit = unit.unwrap_or("").escape_default().to_string();
                    unreadable(name, Some(line), format!("the axes have the unit `{unit}`, which is not known"))
                })?);
            }
            continue;
        }
        let Some(scale) = scale else {
            return Err(unreadable(name, Some(line), "no `// AXES` line states the unit".into()));
        };
        let fields: Vec<&str> = row.split(',').map(str::trim).collect();
        let &[collection, in_group, count, x, y, z, time] = fields.as_slice() else {
            let what = format!("{} values where SpatialAnalyzer writes seven", fields.len());
            return Err(unreadable(name, Some(line), what));
        };
        let this = (collection.to_string(), in_group.to_string());
        match &group {
            None => group = Some(this),
            Some(first) if *first != this => {
                let what = format!(
                    "the group `{}` follows `{}`: a log is one run",
                    in_group.escape_default(),
                    first.1.escape_default()
                );
                return Err(unreadable(name, Some(line), what));
            }
            Some(_) => {}
        }
        let count = number(count, name, line)?;
        if let Some(before) = index.last().filter(|before| !(count > **before)) {
            return Err(not_forward(name, line, *before, count));
        }
        let now = clock(time)
            .ok_or_else(|| unreadable(name, Some(line), format!("`{}` is no time of day", time.escape_default())))?;
        // Past midnight the clock begins anew.
        if let Some(before) = seconds.last().filter(|before| now + days < **before - DAY / 2.0) {
            days = ((before - now) / DAY).round() * DAY;
        }
        if let Some(before) = seconds.last().filter(|before| now + days < **before) {
            return Err(not_forward(name, line, *before, now + days));
        }
        index.push(count);
        seconds.push(now + days);
        log.position.push([
            number(x, name, line)? * scale,
            number(y, name, line)? * scale,
            number(z, name, line)? * scale,
        ]);
    }
    if index.len() < 2 {
        return Err(too_few(name, index.len()));
    }
    let (step, clock) = time_base(&index, &seconds)
        .ok_or_else(|| unreadable(name, None, "all samples have the same second: their rate is not known".into()))?;
    // More than a second beyond its rounding the clock does not go with the index, and one of them is wrong.
    if clock > 1.0 {
        let what =
            format!("its clock lies up to {clock:.1} s off the even steps of its index: no speed can be read from it");
        return Err(unreadable(name, None, what));
    }
    log.time = index.iter().map(|count| (count - index[0]) * step).collect();
    log.frame_name = frame_name;
    log.group = group.map(|(_, group)| group);
    finish(log, name)
}

/// Seconds a step of the index, by least squares through the whole seconds of the clock, and how far the clock lies off
/// the line at most beyond the half second that its rounding explains.
fn time_base(index: &[f64], seconds: &[f64]) -> Option<(f64, f64)> {
    let n = index.len() as f64;
    let (mean_i, mean_s) = (index.iter().sum::<f64>() / n, seconds.iter().sum::<f64>() / n);
    let (mut above, mut below) = (0.0, 0.0);
    for (i, s) in index.iter().zip(seconds) {
        above += (i - mean_i) * (s - mean_s);
        below += (i - mean_i) * (i - mean_i);
    }
    let step = above / below;
    if !(step > 0.0 && step.is_finite()) {
        return None;
    }
    let off = index.iter().zip(seconds).map(|(i, s)| (s - mean_s - (i - mean_i) * step).abs());
    Some((step, (off.fold(0.0, f64::max) - 0.5).max(0.0)))
}

#[cfg(test)]
mod tests {
    use super::*;

    fn code(text: &str) -> &'static str {
        read(text.as_bytes(), "run.csv").expect_err("a log that is refused").code.as_str()
    }

    #[test]
    fn a_table_says_its_units_and_frame() {
        let text =
            "# frame: object\nTime (ms); y_mm; x [mm]; z [um]; torque\n1000; 2; 1; 3000; 9\n1004; 2.5; 1; 3000; 9\n";
        let log = read(text.as_bytes(), "run.csv").expect("a log");
        assert_eq!(log.frame, Some(Frame::Part));
        assert_eq!(log.time.len(), 2);
        assert!((log.time[1] - 0.004).abs() < 1e-12);
        for (found, wanted) in log.position[1].iter().zip([1e-3, 2.5e-3, 3e-3]) {
            assert!((found - wanted).abs() < 1e-15);
        }
    }

    #[test]
    fn what_is_no_log_is_refused() {
        let head = "t [s], x [mm], y [mm], z [mm]\n";
        for (text, wanted) in [
            ("".to_string(), "E1304"),
            ("\n\n".into(), "E1304"),
            (head.into(), "E1304"),
            (format!("{head}0, 1, 2, 3\n"), "E1304"),
            (format!("{head}0, 1, 2, 3\n1, NaN, 2, 3\n"), "E1302"),
            (format!("{head}0, 1, 2, 3\n1, inf, 2, 3\n"), "E1302"),
            (format!("{head}0, 1, 2, 3\n1, 1, 2\n"), "E1302"),
            (format!("{head}0, 1, 2, 3\n0, 1, 2, 3\n"), "E1303"),
            (format!("{head}0, 1, 2, 3\n2, 1, 2, 3\n1, 1, 2, 3\n"), "E1303"),
            ("t, x [mm], y [mm], z [mm]\n0,1,2,3\n1,1,2,3\n".into(), "E1302"),
            ("t [s], x [furlong], y [mm], z [mm]\n0,1,2,3\n1,1,2,3\n".into(), "E1302"),
            ("t [s], x [mm], y [mm]\n0,1,2\n1,1,2\n".into(), "E1302"),
            ("t [s], x [mm], x [mm], y [mm], z [mm]\n0,1,2,3,4\n1,1,2,3,4\n".into(), "E1302"),
            ("A, B, 0, 1, 2, 3, 03/02/26 09:00:00\n".into(), "E1302"),
        ] {
            assert_eq!(code(&text), wanted, "{text}");
        }
        assert_eq!(read(b"\xff\xfe\x00", "run.csv").expect_err("no text").code, codes::E1302);
    }

    #[test]
    fn a_log_is_known_by_its_beginning() {
        for (text, wanted) in [
            ("\n# frame: part\nt [s], x [mm], y [mm], z [mm]\n", Some(Layout::Table)),
            ("time_ms;z_mm;y_mm;x_mm\n", Some(Layout::Table)),
            ("\u{feff}// SpatialAnalyzer SA\n// AXES = CARTESIAN: X,  Y,  Z (mm)\n", Some(Layout::SpatialAnalyzer)),
            // Heights over places, a remark before a table of heights, and no text.
            ("x [mm], y [mm], z [nm]\n0, 0, 1\n", None),
            ("// AXIAL\n1 2 3\n// AXES\n", None),
            ("", None),
        ] {
            assert_eq!(layout(text.as_bytes()), wanted, "{text}");
        }
        assert_eq!(layout(b"\xff"), None);
    }

    const HEAD: &str = "// SpatialAnalyzer SA 2024.2 ( x64 )\n// Points Relative to Coordinate Frame 'A::OPTIC'\n";

    #[test]
    fn the_index_is_the_time_base_of_spatial_analyzer() {
        // 20 samples a second over midnight, the clock in whole seconds; sample 30 is missing.
        let mut text = format!("{HEAD}// AXES = CARTESIAN: X,  Y,  Z (mm)\n");
        for i in (0..2000).filter(|i| *i != 30) {
            let second = (86_390 + i / 20) % 86_400;
            let (h, m, s) = (second / 3600, second / 60 % 60, second % 60);
            text += &format!("NoLoad,  Run1,  {i},  {}.5,  -2,  0.1,  03/02/26 {h:02}:{m:02}:{s:02}\n", i);
        }
        let log = read(text.as_bytes(), "run.txt").expect("a log");
        assert_eq!((log.frame, log.frame_name.as_deref()), (None, Some("A::OPTIC")));
        assert_eq!((log.group.as_deref(), log.unit.as_str()), (Some("Run1"), "mm"));
        assert_eq!(log.time.len(), 1999);
        // Whole seconds over 100 s fix the step to better than a part in a thousand.
        assert!((log.time[1998] - 1999.0 * 0.05).abs() < 0.1, "{}", log.time[1998]);
        assert!((log.time[30] - log.time[29] - 0.1).abs() < 1e-3, "the missing sample leaves its time");
        assert!((log.position[3][0] - 3.5e-3).abs() < 1e-15);
    }

    #[test]
    fn spatial_analyzer_without_sense_is_refused() {
        let axes = format!("{HEAD}// AXES = CARTESIAN: X,  Y,  Z (mm)\n");
        for (text, wanted) in [
            (format!("{HEAD}A, B, 0, 1, 2, 3, 03/02/26 09:00:00\n"), "E1302"),
            (format!("{HEAD}// AXES = CARTESIAN: X, Y, Z (cubit)\n"), "E1302"),
            (format!("{HEAD}// AXES = CYLINDRICAL: R, T, Z (mm)\n"), "E1302"),
            (axes.clone(), "E1304"),
            (format!("{axes}A, B, 0, 1, 2, 3, 03/02/26 09:00:00\n"), "E1304"),
            (format!("{axes}A, B, 0, 1, 2, 3, 03/02/26 09:00:00\nA, B, 1, 1, 2, 3, 03/02/26 09:00:00\n"), "E1302"),
            (format!("{axes}A, B, 1, 1, 2, 3, 03/02/26 09:00:00\nA, B, 0, 1, 2, 3, 03/02/26 09:00:01\n"), "E1303"),
            (format!("{axes}A, B, 0, 1, 2, 3, 03/02/26 09:00:02\nA, B, 1, 1, 2, 3, 03/02/26 09:00:01\n"), "E1303"),
            (format!("{axes}A, B, 0, 1, 2, 3, 03/02/26 09:00:00\nA, C, 1, 1, 2, 3, 03/02/26 09:00:01\n"), "E1302"),
            (format!("{axes}A, B, 0, 1, 2, 3, noon\n"), "E1302"),
        ] {
            assert_eq!(code(&text), wanted, "{text}");
        }
    }
}
