//! The tools around the compiler, as people call them: the projects of `new` build, the manual's page is written, the
//! pages and completions know every command.
#![allow(clippy::disallowed_methods, reason = "tests read files and run the tool")]

use std::collections::BTreeSet;
use std::path::{Path, PathBuf};
use std::process::{Command, Output};

fn polishc(folder: &Path, arguments: &[&str]) -> Output {
    Command::new(env!("CARGO_BIN_EXE_polishc")).current_dir(folder).args(arguments).output().expect("the tool runs")
}

/// Standard output of a run that must succeed without a word on standard error.
fn good(folder: &Path, arguments: &[&str]) -> String {
    let run = polishc(folder, arguments);
    let said = String::from_utf8_lossy(&run.stderr);
    assert!(run.status.success() && said.is_empty(), "{arguments:?}:\n{said}");
    String::from_utf8(run.stdout).expect("UTF-8")
}

fn fresh_folder(name: &str) -> PathBuf {
    let folder = Path::new(env!("CARGO_TARGET_TMPDIR")).join("tools").join(name);
    if folder.exists() {
        std::fs::remove_dir_all(&folder).expect("an old folder goes");
    }
    std::fs::create_dir_all(&folder).expect("a folder");
    folder
}

fn names(folder: &Path) -> BTreeSet<String> {
    let entries = std::fs::read_dir(folder).expect("a folder");
    entries.map(|entry| entry.expect("an entry").file_name().to_string_lossy().into_owned()).collect()
}

/// What `new` makes is checked, formatted, built and verified without a warning, and its README names commands that run.
#[test]
fn a_new_project_builds() {
    let folder = fresh_folder("new");
    let told = good(&folder, &["new", "My-Mirror", "--template", "mrf"]);
    assert!(told.contains("the job is called `my_mirror`"), "{told}");
    let project = folder.join("My-Mirror");
    let made = ["my_mirror.polish", "cell.polish", "my_mirror.dat", "polish.toml", "README.md", ".gitignore"];
    assert_eq!(names(&project), made.map(str::to_string).into());
    let readme = std::fs::read_to_string(project.join("README.md")).expect("the README");
    let mut ran = 0;
    for line in readme.lines().filter(|line| line.starts_with("polishc ")) {
        // What a command does stands beside it.
        let command = line.split("  ").next().expect("a command");
        let command = command.strip_suffix(" what the job leaves to defaults, with reasons").unwrap_or(command);
        let words: Vec<&str> = command.split_whitespace().skip(1).collect();
        good(&project, &words);
        ran += 1;
    }
    assert!(ran >= 6, "{ran} commands of the README ran");
    good(&project, &["fmt", "--check", "my_mirror.polish", "cell.polish"]);
    good(&project, &["check", "--deny", "warnings", "my_mirror.polish"]);
    let programs: Vec<String> =
        names(&project.join("out/my_mirror")).into_iter().filter(|n| n.ends_with(".mod")).collect();
    assert!(programs.iter().any(|name| name == "MyMirror.mod"), "{programs:?}");
    let paths: Vec<String> = programs.iter().map(|name| format!("out/my_mirror/{name}")).collect();
    let mut arguments = vec!["verify", "--job", "my_mirror.polish"];
    arguments.extend(paths.iter().map(String::as_str));
    good(&project, &arguments);
    // A second time there is something in the folder.
    let again = polishc(&folder, &["new", "My-Mirror"]);
    assert_eq!(again.status.code(), Some(1));
    good(&folder, &["new", "other", "--quiet"]);
    good(&folder.join("other"), &["check", "other.polish"]);
}

#[test]
fn the_page_of_the_vocabulary_is_written() {
    let folder = fresh_folder("doc");
    assert_eq!(good(&folder, &["doc", "--html"]), "wrote out/doc/index.html\n");
    let page = std::fs::read_to_string(folder.join("out/doc/index.html")).expect("the page");
    assert!(page.contains("id=\"Path.raster\"") && page.ends_with("</html>\n"));
    std::fs::write(folder.join("taken"), "a file").expect("a file");
    let refused = polishc(&folder, &["doc", "--html", "-o", "taken/page"]);
    assert_eq!(refused.status.code(), Some(1));
    assert!(String::from_utf8_lossy(&refused.stderr).contains("[E1201]"));
}

/// `show` tells of every value of the job; `--defaults` of those alone that the job's text does not hold.
#[test]
fn show_parts_what_is_said_from_what_is_not() {
    let here = Path::new(".");
    let job = "examples/flat_340/flat_340.polish";
    let whole = good(here, &["show", job]);
    for line in ["wavelength: 632.8 nm", "line_pitch: 0.5 mm", "range_margin: 1 deg", "payload: 200 kg"] {
        assert!(whole.lines().any(|shown| shown.trim_start().starts_with(line)), "{line}\n{whole}");
    }
    assert!(whole.contains("// default of robot") && whole.contains("// examples/flat_340/cell.polish:"));
    let json = good(here, &["show", job, "--defaults", "--message-format", "json"]);
    let found: serde_json::Value = serde_json::from_str(&json).expect("JSON");
    let fields = found["fields"].as_array().expect("a list");
    assert!(fields.iter().any(|field| field["field"] == "robot.range_margin" && field["value"] == "1 deg"));
    for field in fields {
        assert_ne!(field["from"], "text", "{field}");
        let name = field["field"].as_str().expect("a name");
        assert!(!["wavelength", "path.line_pitch", "robot.payload"].contains(&name), "{name} is said");
    }
}

fn commands() -> Vec<String> {
    let command = polishc::cli::command();
    command.get_subcommands().map(|sub| sub.get_name().to_string()).collect()
}

#[test]
fn completions_and_man_pages_know_every_command() {
    let folder = fresh_folder("man");
    for shell in ["bash", "zsh", "fish", "elvish", "powershell"] {
        let script = good(&folder, &["completions", shell]);
        for name in commands() {
            assert!(script.contains(&name), "{shell}: {name}");
        }
    }
    assert_eq!(polishc(&folder, &["completions", "csh"]).status.code(), Some(2));
    clap_mangen::generate_to(polishc::cli::command(), &folder).expect("man pages");
    let pages = names(&folder);
    for name in commands() {
        assert!(pages.contains(&format!("polishc-{name}.1")), "{name}: {pages:?}");
    }
}

/// Every command and every option says what it does, in a sentence without an end.
#[test]
fn every_help_says_something() {
    let command = polishc::cli::command();
    for sub in command.get_subcommands() {
        let about = sub.get_about().map(ToString::to_string).unwrap_or_default();
        assert!(about.len() > 10 && about.starts_with(char::is_uppercase), "{}: {about}", sub.get_name());
        for argument in sub.get_arguments().filter(|argument| !argument.is_positional()) {
            assert!(argument.get_help().is_some(), "{} --{}", sub.get_name(), argument.get_id());
        }
    }
}
