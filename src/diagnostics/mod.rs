//! Diagnostics: what the compiler says, apart from how it is shown.
//!
//! In: a code from the table in [`codes`], one sentence that stands alone, a place, the mend. Out: [`Diagnostic`],
//! which [`render`] turns into terminal text or JSON lines. Passes below `eval` know no text: they say a [`Problem`],
//! which names a field of the job, and [`Origins`](crate::job::Origins) finds the line.

pub mod codes;
pub mod render;

use crate::source::Span;
pub use codes::Code;

/// How grave it is.
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord)]
pub enum Severity {
    Warning,
    Error,
}

/// A place with what is to be seen there.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct Label {
    pub span: Span,
    pub text: String,
}

/// Text that would mend the mistake if it stood in place of `span`.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct Suggestion {
    pub span: Span,
    pub replacement: String,
}

/// One thing the compiler says about text.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct Diagnostic {
    pub code: Code,
    pub severity: Severity,
    /// One sentence that makes sense alone: lower case, no full stop, names in backticks.
    pub message: String,
    /// The smallest place that is wrong. `None` only for what has no place in any file.
    pub primary: Option<Label>,
    pub secondary: Vec<Label>,
    /// Facts that explain.
    pub notes: Vec<String>,
    /// What to do.
    pub help: Option<String>,
    pub suggestions: Vec<Suggestion>,
}

impl Diagnostic {
    /// An error at `span`, with no words at the place itself.
    pub fn error(code: Code, span: Span, message: impl Into<String>) -> Diagnostic {
        Diagnostic {
            code,
            severity: Severity::Error,
            message: message.into(),
            primary: Some(Label { span, text: String::new() }),
            secondary: Vec::new(),
            notes: Vec::new(),
            help: None,
            suggestions: Vec::new(),
        }
    }

    /// A warning at `span`.
    pub fn warning(code: Code, span: Span, message: impl Into<String>) -> Diagnostic {
        Diagnostic { severity: Severity::Warning, ..Diagnostic::error(code, span, message) }
    }

    /// An error that has no place in any file (a bad option, say).
    pub fn placeless(code: Code, message: impl Into<String>) -> Diagnostic {
        let nowhere = Span::new(crate::source::FileId(0), 0, 0);
        Diagnostic { primary: None, ..Diagnostic::error(code, nowhere, message) }
    }

    /// Words shown at the primary place.
    pub fn label(mut self, text: impl Into<String>) -> Diagnostic {
        if let Some(primary) = &mut self.primary {
            primary.text = text.into();
        }
        self
    }

    /// A second place that explains.
    pub fn also(mut self, span: Span, text: impl Into<String>) -> Diagnostic {
        self.secondary.push(Label { span, text: text.into() });
        self
    }

    /// A fact that explains.
    pub fn note(mut self, text: impl Into<String>) -> Diagnostic {
        self.notes.push(text.into());
        self
    }

    /// What to do.
    pub fn help(mut self, text: impl Into<String>) -> Diagnostic {
        self.help = Some(text.into());
        self
    }

    /// Replacement text that mends it.
    pub fn suggest(mut self, span: Span, replacement: impl Into<String>) -> Diagnostic {
        self.suggestions.push(Suggestion { span, replacement: replacement.into() });
        self
    }
}

/// What a pass that knows no text says: the place is a field of the job, by its path (`workpiece.error.file`,
/// `path.line_pitch`).
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct Problem {
    pub code: Code,
    pub severity: Severity,
    pub message: String,
    pub field: Option<String>,
    pub notes: Vec<String>,
    pub help: Option<String>,
}

impl Problem {
    /// An error about the field at `field`.
    pub fn error(code: Code, field: impl Into<String>, message: impl Into<String>) -> Problem {
        Problem {
            code,
            severity: Severity::Error,
            message: message.into(),
            field: Some(field.into()),
            notes: Vec::new(),
            help: None,
        }
    }

    /// A warning about the field at `field`.
    pub fn warning(code: Code, field: impl Into<String>, message: impl Into<String>) -> Problem {
        Problem { severity: Severity::Warning, ..Problem::error(code, field, message) }
    }

    /// A fact that explains.
    pub fn note(mut self, text: impl Into<String>) -> Problem {
        self.notes.push(text.into());
        self
    }

    /// What to do.
    pub fn help(mut self, text: impl Into<String>) -> Problem {
        self.help = Some(text.into());
        self
    }

    /// The same problem with `prefix.` put before its field (a reader says `file`, its caller knows `workpiece.error`).
    pub fn within(mut self, prefix: &str) -> Problem {
        self.field = Some(match self.field {
            Some(field) if !field.is_empty() => format!("{prefix}.{field}"),
            _ => prefix.to_string(),
        });
        self
    }
}
