//! The manual as one page of HTML: no script, no other file, every word with an anchor of its own.

use super::text::{facts, title};
use super::{Entry, FieldPage, Kind, Manual, Module};
use std::fmt::Write;

/// The whole page. `version` is the compiler's.
pub fn page(manual: &Manual, version: &str) -> String {
    let mut out = String::new();
    write!(
        out,
        "<!doctype html>\n<html lang=\"en\">\n<head>\n<meta charset=\"utf-8\">\n\
         <meta name=\"viewport\" content=\"width=device-width, initial-scale=1\">\n\
         <title>The vocabulary of polishc {version}</title>\n<style>{STYLE}</style>\n</head>\n<body>\n"
    )
    .ok();
    contents(&mut out, manual);
    writeln!(out, "<main>\n<h1>The vocabulary of polishc {version}</h1>").ok();
    out.push_str(
        "<p>Every word that a job can use, made from the comments of the standard library. A field without a default \
         must be written; a value outside the usual range is a warning, outside the limits an error.</p>\n",
    );
    for module in &manual.modules {
        writeln!(out, "<section id=\"module-{0}\">\n<h2>{0}</h2>", module.name).ok();
        out.push_str(&prose(manual, &module.doc));
        if !module.core {
            writeln!(out, "<pre>use std.{}</pre>", module.name).ok();
        }
        if module.entries.iter().all(|entry| matches!(entry.kind, Kind::Unit { .. } | Kind::Dimension { .. })) {
            table(&mut out, manual, module);
        } else {
            module.entries.iter().for_each(|entry| article(&mut out, manual, entry));
        }
        out.push_str("</section>\n");
    }
    out.push_str("</main>\n</body>\n</html>\n");
    out
}

fn contents(out: &mut String, manual: &Manual) {
    out.push_str("<nav>\n");
    for module in &manual.modules {
        writeln!(out, "<h2><a href=\"#module-{0}\">{0}</a></h2>", module.name).ok();
        if module.entries.iter().any(|entry| matches!(entry.kind, Kind::Unit { .. } | Kind::Dimension { .. })) {
            continue;
        }
        out.push_str("<ul>\n");
        for entry in &module.entries {
            let class = entry.kind.word();
            writeln!(out, "<li class=\"{class}\"><a href=\"#{}\">{}</a></li>", anchor(entry), escaped(&entry.name))
                .ok();
        }
        out.push_str("</ul>\n");
    }
    out.push_str("</nav>\n");
}

/// Units and dimensions: a line each.
fn table(out: &mut String, manual: &Manual, module: &Module) {
    out.push_str("<table>\n");
    for entry in &module.entries {
        let (is, of) = match &entry.kind {
            Kind::Unit { worth, dimension } => {
                (worth.clone().unwrap_or_else(|| "SI unit".into()), words(manual, dimension))
            }
            Kind::Dimension { product, units } => {
                (product.clone().unwrap_or_else(|| "base".into()), escaped(&units.join(", ")))
            }
            _ => continue,
        };
        writeln!(
            out,
            "<tr id=\"{}\"><td><code>{}</code></td><td>{}</td><td>{of}</td><td>{}</td></tr>",
            anchor(entry),
            escaped(&entry.name),
            escaped(&is),
            inline(manual, &entry.doc),
        )
        .ok();
    }
    out.push_str("</table>\n");
}

fn article(out: &mut String, manual: &Manual, entry: &Entry) {
    let id = anchor(entry);
    let (name, rest) = {
        let whole = title(entry);
        let rest = whole.strip_prefix(&entry.name).unwrap_or_default().to_string();
        (escaped(&entry.name), words(manual, &rest))
    };
    writeln!(
        out,
        "<article id=\"{id}\">\n<h3><a href=\"#{id}\">{name}</a><span class=\"rest\">{rest}</span> \
         <small>{}</small></h3>",
        entry.kind.word()
    )
    .ok();
    out.push_str(&prose(manual, &entry.doc));
    match &entry.kind {
        Kind::Family { members, used } => {
            out.push_str("<dl>\n");
            for member in members {
                let found = manual.entries().map(|(_, e)| e).find(|e| {
                    e.name == *member && matches!(&e.kind, Kind::Schema { family: Some(f), .. } if *f == entry.name)
                });
                let Some(found) = found else { continue };
                writeln!(
                    out,
                    "<dt><a href=\"#{}\"><code>{member}</code></a></dt><dd>{}</dd>",
                    anchor(found),
                    inline(manual, found.brief())
                )
                .ok();
            }
            out.push_str("</dl>\n");
            stands_in(out, manual, used);
        }
        Kind::Schema { fields, checks, used, .. } => {
            if !fields.is_empty() {
                out.push_str("<dl>\n");
                fields.iter().for_each(|page| field(out, manual, &id, page));
                out.push_str("</dl>\n");
            }
            for check in checks {
                writeln!(out, "<p>Must hold: <code>{}</code>.</p>", escaped(check)).ok();
            }
            stands_in(out, manual, used);
        }
        Kind::Value { text, .. } => drop(writeln!(out, "<pre>{}</pre>", escaped(text))),
        Kind::Unit { worth, dimension } => {
            let worth = worth.as_deref().unwrap_or("the SI unit");
            writeln!(out, "<p>{}, {}</p>", escaped(worth), words(manual, dimension)).ok();
        }
        Kind::Dimension { product, .. } => {
            writeln!(out, "<p>{}</p>", words(manual, product.as_deref().unwrap_or("A base."))).ok();
        }
        Kind::Function { .. } => {}
    }
    out.push_str("</article>\n");
}

fn field(out: &mut String, manual: &Manual, schema: &str, page: &FieldPage) {
    let id = format!("{schema}.{}", page.name);
    write!(
        out,
        "<dt id=\"{id}\"><a href=\"#{id}\"><code>{}</code></a>: <code>{}</code>",
        escaped(&page.name),
        words(manual, &page.ty)
    )
    .ok();
    if let Some(default) = &page.default {
        write!(out, " = <code>{}</code>", words(manual, default)).ok();
    }
    out.push_str("</dt>\n<dd>");
    let facts = facts(page);
    if !facts.is_empty() {
        writeln!(out, "<p class=\"facts\">{}</p>", escaped(&facts.join("; "))).ok();
    }
    out.push_str(&prose(manual, &page.doc));
    let said: Vec<_> = page.symbols.iter().filter(|(_, doc)| !doc.is_empty()).collect();
    if !said.is_empty() {
        out.push_str("<dl>\n");
        for (symbol, doc) in said {
            writeln!(out, "<dt><code>{}</code></dt><dd>{}</dd>", escaped(symbol), inline(manual, doc)).ok();
        }
        out.push_str("</dl>\n");
    }
    out.push_str("</dd>\n");
}

fn stands_in(out: &mut String, manual: &Manual, used: &[String]) {
    let links: Vec<String> = used
        .iter()
        .map(|path| {
            let (schema, field) = path.split_once('.').unwrap_or((path, ""));
            let holds = |e: &Entry| e.name == schema && e.fields().iter().any(|page| page.name == field);
            match manual.entries().map(|(_, e)| e).find(|e| holds(e)) {
                Some(found) => format!("<a href=\"#{}.{field}\"><code>{path}</code></a>", anchor(found)),
                None => format!("<code>{path}</code>"),
            }
        })
        .collect();
    if !links.is_empty() {
        writeln!(out, "<p class=\"facts\">Stands in {}.</p>", links.join(", ")).ok();
    }
}

/// The name of a word's place. Members of two families may share a name.
fn anchor(entry: &Entry) -> String {
    let name = entry.name.replace('%', "percent");
    match &entry.kind {
        Kind::Schema { family: Some(family), .. } => format!("{family}.{name}"),
        kind => format!("{}.{name}", kind.word()),
    }
}

/// Text with the words of the vocabulary as links.
fn words(manual: &Manual, text: &str) -> String {
    let mut out = String::new();
    let is_word = |c: char| c == '_' || c.is_alphanumeric();
    let mut rest = text;
    while !rest.is_empty() {
        let end = rest.find(|c| !is_word(c)).unwrap_or(rest.len());
        let (word, after) = rest.split_at(end);
        let kinds = ["family", "schema", "dimension"];
        let found = manual.entries().map(|(_, e)| e).find(|e| e.name == word && kinds.contains(&e.kind.word()));
        match found {
            Some(entry) => write!(out, "<a href=\"#{}\">{}</a>", anchor(entry), escaped(word)).unwrap_or_default(),
            None => out.push_str(&escaped(word)),
        }
        let other = after.find(is_word).unwrap_or(after.len());
        out.push_str(&escaped(&after[..other]));
        rest = &after[other..];
    }
    out
}

/// A comment cut into paragraphs and code: whether it is code, and its text.
pub(super) fn blocks(doc: &str) -> Vec<(bool, String)> {
    let mut blocks: Vec<(bool, String)> = Vec::new();
    let mut code = false;
    let mut fresh = true;
    for line in doc.lines() {
        if line.trim_start().starts_with("```") {
            (code, fresh) = (!code, true);
        } else if line.trim().is_empty() && !code {
            blocks.push((false, String::new()));
            fresh = true;
        } else if let (false, Some((_, text))) = (fresh, blocks.last_mut()) {
            text.push('\n');
            text.push_str(line);
        } else {
            blocks.push((code, line.to_string()));
            fresh = false;
        }
    }
    blocks
}

fn prose(manual: &Manual, doc: &str) -> String {
    let blocks = blocks(doc);
    let shown = blocks.iter().filter(|(_, text)| !text.is_empty()).map(|(code, text)| match code {
        true => format!("<pre>{}</pre>\n", escaped(text)),
        false => format!("<p>{}</p>\n", inline(manual, text)),
    });
    shown.collect()
}

/// A sentence: what stands between backticks is code.
fn inline(manual: &Manual, text: &str) -> String {
    let pieces = text.split('`').enumerate().map(|(i, piece)| match i % 2 {
        1 => format!("<code>{}</code>", words(manual, piece)),
        _ => escaped(piece),
    });
    pieces.collect()
}

fn escaped(text: &str) -> String {
    text.replace('&', "&amp;").replace('<', "&lt;").replace('>', "&gt;").replace('"', "&quot;")
}

const STYLE: &str = "
:root { --ink: #1c1e21; --soft: #5d646d; --line: #e2e5e9; --link: #0b5c99; --paper: #fff; --code: #f4f5f7 }
@media (prefers-color-scheme: dark) {
  :root { --ink: #e4e6e9; --soft: #9aa2ac; --line: #33383f; --link: #7db8e8; --paper: #16181b; --code: #202327 }
}
* { box-sizing: border-box }
body { margin: 0; color: var(--ink); background: var(--paper); display: grid; grid-template-columns: 15rem minmax(0, 46rem);
  gap: 3rem; font: 16px/1.55 system-ui, -apple-system, 'Segoe UI', 'Liberation Sans', sans-serif }
nav { position: sticky; top: 0; height: 100vh; overflow-y: auto; padding: 2rem 1rem 2rem 1.5rem; font-size: .875rem;
  border-right: 1px solid var(--line) }
nav h2 { font-size: .875rem; margin: 1.1rem 0 .2rem; overflow-wrap: anywhere }
nav ul { list-style: none; margin: 0; padding: 0 }
nav li { padding-left: .8rem } nav li.family { font-weight: 600; padding-left: 0 }
main { padding: 2rem 1.5rem 6rem 0 }
h1 { font-size: 1.7rem; line-height: 1.25; margin: 0 0 1rem }
section { margin-top: 3.5rem } section > h2 { font-size: 1.35rem; padding-bottom: .3rem; border-bottom: 2px solid var(--line) }
article { margin-top: 2.4rem } h3 { font: 600 1.1rem/1.4 ui-monospace, 'Liberation Mono', monospace; margin: 0 0 .5rem }
h3 small { font: .8rem/1 system-ui, sans-serif; color: var(--soft); margin-left: .4rem } h3 .rest { font-weight: 400 }
p { margin: .4rem 0 } dl { margin: .6rem 0 } dt { margin-top: .9rem } dd { margin: 0 0 0 1.5rem }
dd dl { margin: .2rem 0 } dd dt { margin-top: .3rem }
code, pre { font: .875em/1.5 ui-monospace, 'Liberation Mono', monospace } pre { background: var(--code); padding: .7rem 1rem;
  overflow-x: auto; border-radius: 4px }
a { color: var(--link); text-decoration: none } a:hover { text-decoration: underline } h3 a, dt > a { color: inherit }
:target { background: var(--code); outline: .5rem solid var(--code) }
.facts { color: var(--soft); font-size: .9rem }
table { border-collapse: collapse } td { padding: .25rem 1.2rem .25rem 0; border-bottom: 1px solid var(--line);
  vertical-align: top }
@media (max-width: 60rem) { body { display: block } nav { position: static; height: auto; border: 0 } main { padding: 1.5rem } }
@media print { nav { display: none } body { display: block } }
";
