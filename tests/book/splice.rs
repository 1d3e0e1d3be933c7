//! Putting entries into a file: the fields of a fragment in place of those of the same name, new ones beside them.

use polishc::source::FileId;
use polishc::syntax::ast::{Ast, Block, Entry, EntryKind, Expr, ExprKind, ItemKind};
use polishc::syntax::parse;

/// The record at `path` (`workpiece.error`; empty for the job or the first record of the file) with `entries` in it.
pub fn splice(file: &str, path: &str, entries: &str) -> Result<String, String> {
    let ast = parse(FileId(0), file).0;
    let mut block = outermost(&ast).ok_or("the file has neither a job nor a record")?;
    for word in path.split('.').filter(|word| !word.is_empty()) {
        let entry = field(block, word).ok_or_else(|| format!("there is no `{word}` in the file"))?;
        block = match &entry.kind {
            EntryKind::Field { value, .. } => record(value).ok_or_else(|| format!("`{word}` is no record"))?,
            EntryKind::Expr(_) => return Err(format!("`{word}` is no field")),
        };
    }
    // The fragment is read between brackets of its own, so that its places are known.
    const OPEN: &str = "job f {\n";
    let text = format!("{OPEN}{entries}\n}}\n");
    let ast = parse(FileId(0), &text).0;
    let given = outermost(&ast).ok_or("the fragment cannot be read")?;
    let slice = |text: &str, entry: &Entry| text[entry.span.start as usize..entry.span.end as usize].to_string();
    let mut edits: Vec<(usize, usize, String)> = Vec::new();
    let inside = block.span.start as usize + 1;
    for entry in &given.entries {
        let new = slice(&text, entry);
        match &entry.kind {
            EntryKind::Field { name, .. } if field(block, &name.text).is_some() => {
                let old = field(block, &name.text).expect("just found");
                edits.push((old.span.start as usize, old.span.end as usize, new));
            }
            _ => edits.push((inside, inside, format!("\n{new}\n"))),
        }
    }
    edits.sort_by_key(|edit| (edit.0, edit.1));
    let mut out = file.to_string();
    for (from, to, new) in edits.into_iter().rev() {
        out.replace_range(from..to, &new);
    }
    Ok(out)
}

/// The path of the first record, from the outermost inwards, that has a field of this name.
pub fn home_of(file: &str, name: &str) -> Option<String> {
    let ast = parse(FileId(0), file).0;
    let mut todo = vec![(String::new(), outermost(&ast)?)];
    while !todo.is_empty() {
        let mut next = Vec::new();
        for (path, block) in todo {
            if field(block, name).is_some() {
                return Some(path);
            }
            for entry in &block.entries {
                if let EntryKind::Field { name, value } = &entry.kind
                    && let Some(inner) = record(value)
                {
                    let path = if path.is_empty() { name.text.clone() } else { format!("{path}.{}", name.text) };
                    next.push((path, inner));
                }
            }
        }
        todo = next;
    }
    None
}

/// The first field of a fragment.
pub fn first_field(entries: &str) -> Option<String> {
    let ast = parse(FileId(0), &format!("job f {{\n{entries}\n}}\n")).0;
    outermost(&ast)?.entries.iter().find_map(|entry| match &entry.kind {
        EntryKind::Field { name, .. } => Some(name.text.clone()),
        EntryKind::Expr(_) => None,
    })
}

fn outermost(ast: &Ast) -> Option<&Block> {
    let job = ast.items.iter().find_map(|item| match &item.kind {
        ItemKind::Job { body, .. } => Some(body),
        _ => None,
    });
    job.or_else(|| {
        ast.items.iter().find_map(|item| match &item.kind {
            ItemKind::Let { value, .. } => record(value),
            _ => None,
        })
    })
}

fn field<'a>(block: &'a Block, wanted: &str) -> Option<&'a Entry> {
    block.entries.iter().find(|entry| matches!(&entry.kind, EntryKind::Field { name, .. } if name.text == wanted))
}

fn record(value: &Expr) -> Option<&Block> {
    match &value.kind {
        ExprKind::Record { body, .. } | ExprKind::With(_, body) => Some(body),
        _ => None,
    }
}
