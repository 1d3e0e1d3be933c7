use polishc::eval::{Options, compile};
use polishc::source::*;
struct Disk;
impl FileProvider for Disk {
    fn read(&self, path: &str, _: u64) -> Result<Vec<u8>, FileError> { std::fs::read(path).map_err(|_| FileError::NotFound) }
    fn resolve(&self, from: &str, path: &str) -> Result<String, FileError> {
        let whole = normalise(from, path).ok_or(FileError::Outside)?;
        let folder = from.rsplit_once('/').map_or("", |(folder, _)| folder);
        if from.is_empty() || whole.starts_with(folder) { Ok(whole) } else { Err(FileError::Outside) }
    }
}
#[test]
fn show_all() {
    for topic in ["names", "types", "fields"] {
        let mut all: Vec<_> = std::fs::read_dir(format!("tests/ui/{topic}")).unwrap().map(|e| e.unwrap().path()).collect();
        all.sort();
        for path in all {
            let path = path.to_str().unwrap();
            let text = std::fs::read_to_string(path).unwrap();
            let sets = text.lines().filter_map(|l| l.strip_prefix("// set: ")).map(|s| { let (a, b) = s.split_once('=').unwrap(); (a.to_string(), b.to_string()) }).collect();
            let c = compile(&Disk, path, &Options { sets, job: None });
            println!("== {path}");
            for line in super::said(&c) { println!("  {line}"); }
        }
    }
}
