//! The table of codes. A code is its page: `docs/errors/E0101.md` opens with `# E0101: title`, and says what it means,
//! an example that causes it, and the mend. `polishc explain E0101` prints the page.
//!
//! Ranges: 01 syntax · 02 names · 03 types and dimensions · 04 fields, ranges, values · 05 files and metrology ·
//! 06 workpiece, tool, path · 07 dwell · 08 motion · 09 target · 10 verify · 11 requirements · 12 command line.
//! Warnings are `W` with the same ranges.

use std::fmt;

/// A stable code, such as `E0301`.
#[derive(Clone, Copy, PartialEq, Eq, PartialOrd, Ord, Hash)]
pub struct Code(&'static str);

impl Code {
    /// The code itself.
    pub fn as_str(self) -> &'static str {
        self.0
    }

    /// The whole page.
    pub fn page(self) -> &'static str {
        PAGES.iter().find(|(code, _)| *code == self.0).map_or("", |(_, page)| page)
    }

    /// The title: the page's first line without the code.
    pub fn title(self) -> &'static str {
        let first = self.page().lines().next().unwrap_or("");
        first.split_once(": ").map_or("", |(_, title)| title)
    }

    /// The code written so, if there is one. Case does not matter.
    pub fn find(text: &str) -> Option<Code> {
        PAGES.iter().find(|(code, _)| code.eq_ignore_ascii_case(text)).map(|(code, _)| Code(code))
    }

    /// All codes, in order.
    pub fn all() -> impl Iterator<Item = Code> {
        PAGES.iter().map(|(code, _)| Code(code))
    }
}

impl fmt::Display for Code {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.write_str(self.0)
    }
}

impl fmt::Debug for Code {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.write_str(self.0)
    }
}

macro_rules! codes {
    ($($code:ident)*) => {
        $(
            #[doc = include_str!(concat!("../../docs/errors/", stringify!($code), ".md"))]
            pub const $code: Code = Code(stringify!($code));
        )*
        const PAGES: &[(&str, &str)] = &[
            $((stringify!($code), include_str!(concat!("../../docs/errors/", stringify!($code), ".md")))),*
        ];
    };
}

codes! {
    // syntax
    E0100
    // motion
    E0800
    E0801
    E0802
    E0803
    E0804
    E0805
    E0806
    E0807
    E0808
    E0809
    E0810
    E0811
    E0812
    // target
    E0900
    E0901
    E0902
    E0903
    E0904
    E0905
    E0906
    E0907
    E0908
    W0906
    // verify
    E1000
    E1001
    E1002
    E1003
    E1004
    E1005
    E1006
    E1007
    E1008
    E1009
    E1010
    E1011
    E1012
    E1013
    E1014
}
