//! The commands that the pages show: they run, and say what the page says; and no page names a command that is none.

use crate::blocks::{Block, blocks};
use crate::code::{CELL, JOB};
use crate::splice::splice;
use crate::{all_pages, between, keep, pages, read, update};
use std::collections::{BTreeMap, BTreeSet};
use std::path::{Path, PathBuf};
use std::process::Command;

/// A command of a block, and what it is to say.
struct Shown<'a> {
    words: Vec<&'a str>,
    line: &'a str,
    status: i32,
    says: Vec<&'a str>,
}

fn shown(block: &str) -> Vec<Shown<'_>> {
    let mut all: Vec<Shown> = Vec::new();
    for line in block.lines() {
        if let Some(command) = line.strip_prefix("$ ") {
            all.push(Shown { words: command.split_whitespace().collect(), line, status: 0, says: Vec::new() });
        } else if let Some(last) = all.last_mut() {
            match line.strip_prefix("? ") {
                Some(status) if last.says.is_empty() => last.status = status.trim().parse().expect("a number"),
                _ => last.says.push(line),
            }
        }
    }
    for one in &mut all {
        while one.says.last().is_some_and(|line| line.is_empty()) {
            one.says.pop();
        }
    }
    all
}

/// Whether `found` is `wanted`, in which `...` is any number of lines.
fn matches(found: &[&str], wanted: &[&str]) -> bool {
    match wanted.split_first() {
        None => found.is_empty(),
        Some((&"...", rest)) => (0..=found.len()).any(|skip| matches(&found[skip..], rest)),
        Some((first, rest)) => found.first() == Some(first) && matches(&found[1..], rest),
    }
}

fn copy(from: &Path, to: &Path) {
    std::fs::create_dir_all(to).expect("a folder");
    for entry in std::fs::read_dir(from).expect("a readable folder") {
        let path = entry.expect("an entry").path();
        let to = to.join(path.file_name().expect("a name"));
        if path.is_dir() {
            copy(&path, &to);
        } else {
            std::fs::copy(&path, &to).expect("a copy");
        }
    }
}

/// Runs a command in `folder`: how it ended, and what it said, diagnostics first as on a screen.
fn run(folder: &Path, one: &Shown) -> (i32, String) {
    let (&program, arguments) = one.words.split_first().expect("a command");
    assert_eq!(program, "polishc", "`{}`: only `polishc` is run from the book", one.line);
    let done = Command::new(env!("CARGO_BIN_EXE_polishc"))
        .args(expanded(folder, arguments))
        .current_dir(folder)
        .env("NO_COLOR", "1")
        .output()
        .expect("the tool runs");
    let text = [done.stderr, done.stdout].map(|bytes| String::from_utf8(bytes).expect("UTF-8")).concat();
    (done.status.code().unwrap_or(-1), text.replace("\r\n", "\n"))
}

/// Arguments with `*` in their last part replaced by the files that it stands for, as a shell does.
fn expanded(folder: &Path, arguments: &[&str]) -> Vec<String> {
    let mut all = Vec::new();
    for argument in arguments {
        let Some((before, after)) = argument.split_once('*') else {
            all.push(argument.trim_matches(['"', '\'']).to_string());
            continue;
        };
        let (parent, start) = before.rsplit_once('/').unwrap_or((".", before));
        let mut names: Vec<String> = std::fs::read_dir(folder.join(parent))
            .expect("a readable folder")
            .map(|entry| entry.expect("an entry").file_name().to_string_lossy().into_owned())
            .filter(|name| name.starts_with(start) && name.ends_with(after) && name.len() >= start.len() + after.len())
            .collect();
        names.sort();
        all.extend(names.into_iter().map(|name| format!("{parent}/{name}")));
    }
    all
}

/// The files of the page's own copy of the examples, and what is shown of them.
fn sandbox(page: &Path) -> PathBuf {
    let name = page.display().to_string().replace(['/', '\\'], "_");
    let folder = Path::new(env!("CARGO_TARGET_TMPDIR")).join("book").join(name);
    if folder.exists() {
        std::fs::remove_dir_all(&folder).expect("an old folder goes");
    }
    copy(Path::new("examples"), &folder.join("examples"));
    folder
}

/// Puts a `diff` block into the file that it names: the first place that reads as the lines with `-`.
fn patch(folder: &Path, block: &Block) {
    let file = folder.join(block.word("file").expect("a `diff` names its file"));
    let lines = |sign: char| block.text.lines().filter_map(move |line| line.strip_prefix(sign)).collect::<Vec<_>>();
    let (old, new) = (lines('-'), lines('+'));
    let text = read(&file);
    let end = if text.contains("\r\n") { "\r\n" } else { "\n" };
    let (old, new) = (old.join(end), new.join(end));
    assert!(text.contains(&old), "line {}: {} does not read `{old}`", block.line, file.display());
    std::fs::write(&file, text.replacen(&old, &new, 1)).expect("the copy");
}

fn edit(folder: &Path, block: &Block) {
    let place = block.word("fragment").expect("an edit is a fragment");
    let (file, place) = match place.strip_prefix("cell") {
        Some(rest) => (CELL, rest.trim_start_matches('.')),
        None => (JOB, place),
    };
    let path = folder.join(file);
    let text = splice(&read(&path), place, &block.text).unwrap_or_else(|why| panic!("line {}: {why}", block.line));
    std::fs::write(path, text).expect("the copy");
}

#[test]
fn the_commands_say_what_the_pages_show() {
    let (mut commands, mut bad) = (0, Vec::new());
    for page in pages("docs") {
        let text = read(&page);
        let found = blocks(&text);
        if !found.iter().any(|block| block.language == "console") {
            continue;
        }
        let folder = sandbox(&page);
        let mut new = text.clone();
        let mut shift = 0_isize;
        for block in &found {
            if block.language == "polish" && block.word("edit").is_some() {
                edit(&folder, block);
            }
            if block.language == "diff" {
                patch(&folder, block);
            }
            if block.language != "console" {
                continue;
            }
            let mut told = String::new();
            for one in shown(&block.text) {
                commands += 1;
                let (status, says) = run(&folder, &one);
                let lines: Vec<&str> = says.trim_end().lines().collect();
                let good = status == one.status && matches(&lines, &one.says);
                if !good && !update() {
                    bad.push(format!(
                        "{}:{}: `{}` ends with {status} and says\n{says}",
                        page.display(),
                        block.line,
                        one.line
                    ));
                }
                let kept = if good { one.says.join("\n") } else { lines.join("\n") };
                let ended = if status == 0 { String::new() } else { format!("? {status}\n") };
                let blank = if told.is_empty() { "" } else { "\n" };
                told.push_str(&format!("{blank}{}\n{ended}{kept}", one.line));
                if !kept.is_empty() {
                    told.push('\n');
                }
            }
            if update() {
                let range = (block.range.start as isize + shift) as usize..(block.range.end as isize + shift) as usize;
                shift += told.len() as isize - range.len() as isize;
                new.replace_range(range, &told);
            }
        }
        if update() && new != text {
            std::fs::write(&page, new).expect("a page that can be written");
        }
    }
    assert!(bad.is_empty(), "{}", bad.join("\n"));
    assert!(commands > 8, "only {commands} commands were found");
}

/// The subcommands, each with what its help says.
fn subcommands() -> BTreeMap<String, String> {
    let help = |arguments: &[&str]| {
        let done = Command::new(env!("CARGO_BIN_EXE_polishc")).args(arguments).output().expect("the tool runs");
        String::from_utf8(done.stdout).expect("UTF-8")
    };
    let all = help(&["--help"]);
    let list = all.split("Commands:").nth(1).and_then(|rest| rest.split("\n\n").next()).expect("a list of commands");
    let names = list.lines().filter(|line| line.starts_with("  ") && !line.starts_with("   "));
    let names = names.filter_map(|line| line.split_whitespace().next()).filter(|name| *name != "help");
    names.map(|name| (name.to_string(), help(&[name, "--help"]))).collect()
}

/// Options of a help text with what they do, in order; arguments are none.
fn options(help: &str) -> Vec<(String, String)> {
    let mut found: Vec<(String, String)> = Vec::new();
    for line in help.split("\nOptions:\n").nth(1).unwrap_or("").lines() {
        let words = line.trim();
        let indent = line.len() - line.trim_start().len();
        match found.last_mut() {
            _ if words.is_empty() => {}
            // Short ones stand on the line of the option, behind two blanks.
            _ if words.starts_with('-') && indent < 10 => {
                let (option, what) = words.split_once("  ").unwrap_or((words, ""));
                found.push((option.to_string(), what.trim().to_string()));
            }
            Some((_, what)) => {
                let blank = if what.is_empty() { "" } else { " " };
                what.push_str(&format!("{blank}{words}"));
            }
            None => {}
        }
    }
    found
}

/// The commands with their options, then the options of all commands, as Markdown.
fn reference() -> String {
    let help = |arguments: &[&str]| {
        let done = Command::new(env!("CARGO_BIN_EXE_polishc")).args(arguments).output().expect("the tool runs");
        String::from_utf8(done.stdout).expect("UTF-8")
    };
    let table = |options: &[(String, String)]| {
        let rows = options.iter().map(|(option, what)| format!("| `{option}` | {} |\n", what.replace('|', "\\|")));
        format!("\n| option | |\n| --- | --- |\n{}", rows.collect::<String>())
    };
    let common = options(&help(&["-h"]));
    let mut out = String::from("\n");
    for name in subcommands().keys() {
        let text = help(&[name, "-h"]);
        let what = text.lines().next().unwrap_or("");
        let usage = text.lines().find_map(|line| line.strip_prefix("Usage: ")).unwrap_or("");
        let usage = usage.replace(".exe", "").replace("[OPTIONS]", "[options]");
        out.push_str(&format!("## {name}\n\n{what}.\n\n`{usage}`\n"));
        let own: Vec<_> =
            options(&text).into_iter().filter(|(name, _)| !common.iter().any(|(c, _)| c == name)).collect();
        if !own.is_empty() {
            out.push_str(&table(&own));
        }
        out.push('\n');
    }
    format!("{out}## Options of all commands\n{}\n", table(&common))
}

#[test]
fn the_page_of_commands_is_the_help() {
    let path = Path::new("docs/reference/commands.md");
    let page = between(&read(path), "<!-- made from --help -->\n", "<!-- end -->", &reference());
    keep(path, &page, "the list of commands");
}

#[test]
fn every_command_that_is_named_exists() {
    let known = subcommands();
    assert!(known.contains_key("build"), "{known:?}");
    let mut bad = BTreeSet::new();
    // What readers said is kept as they said it.
    for page in all_pages().into_iter().filter(|page| !page.starts_with("docs/dev/transcripts")) {
        let mut block = false;
        for (i, line) in read(&page).lines().enumerate() {
            block ^= line.trim_start().starts_with("```");
            let mut rest = line;
            // In code, at the start of a line of a block, or behind the prompt: prose may say `polishc` as it likes.
            while let Some(at) = rest.find("polishc ") {
                let before = &rest[..at];
                let in_code = (block && before.is_empty()) || before.ends_with('`') || before.ends_with("$ ");
                rest = &rest[at + "polishc ".len()..];
                if !in_code {
                    continue;
                }
                let words: Vec<&str> = rest.split('`').next().unwrap_or("").split_whitespace().collect();
                let Some(name) = words.first() else { continue };
                if *name == "help" || name.starts_with('-') {
                    continue;
                }
                let Some(help) = known.get(*name) else {
                    bad.insert(format!("{}:{}: there is no command `{name}`", page.display(), i + 1));
                    continue;
                };
                for word in words.iter().filter(|word| word.starts_with("--")) {
                    let option = word.trim_matches(['[', ']', ',', '.', ')']).split('=').next().unwrap_or("");
                    if !help.contains(option) {
                        bad.insert(format!("{}:{}: `{name}` has no `{option}`", page.display(), i + 1));
                    }
                }
            }
        }
    }
    assert!(bad.is_empty(), "{}", bad.into_iter().collect::<Vec<_>>().join("\n"));
}
