//! The table of codes. A code is its page: `docs/errors/E0101.md` opens with `# E0101: title`, and says what it means,
//! an example that causes it, and the mend. `polishc explain E0101` prints the page.
//!
//! Ranges: 01 syntax · 02 names · 03 types and dimensions · 04 fields, ranges, values · 05 files and metrology ·
//! 06 workpiece, tool, path · 07 dwell, forecast · 08 motion · 09 target · 10 verify · 11 requirements · 12 command line ·
//! 13 simulate.
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
            #[doc = concat!("Its page is `docs/errors/", stringify!($code), ".md`.")]
            pub const $code: Code = Code(stringify!($code));
        )*
        const PAGES: &[(&str, &str)] = &[
            $((stringify!($code), include_str!(concat!("../../docs/errors/", stringify!($code), ".md")))),*
        ];
    };
}

codes! {
    // syntax
    E0101
    E0102
    E0103
    E0104
    E0105
    E0106
    E0107
    E0108
    E0109
    E0110
    E0111
    E0112
    E0113
    E0114
    E0115
    E0116
    E0118
    E0119
    E0120
    E0121
    E0122
    E0123
    E0124
    E0125
    E0126
    W0101
    W0102
    // names
    E0201
    E0202
    E0203
    E0204
    E0205
    E0206
    E0207
    E0208
    E0209
    E0210
    E0211
    E0213
    E0214
    E0215
    E0216
    E0217
    E0218
    E0219
    E0220
    // types and dimensions
    E0301
    E0302
    E0303
    E0304
    E0305
    E0306
    E0307
    E0308
    E0309
    E0310
    E0311
    E0312
    // fields, ranges, values
    E0401
    E0402
    E0403
    E0404
    E0405
    E0406
    E0407
    E0408
    E0409
    E0410
    E0412
    E0413
    E0414
    E0415
    E0416
    W0401
    // files and metrology
    E0500
    E0501
    E0502
    E0503
    E0504
    E0505
    E0506
    E0507
    E0508
    E0509
    E0510
    E0511
    E0512
    E0513
    E0514
    E0515
    E0516
    E0517
    E0518
    E0519
    E0530
    E0531
    E0532
    E0533
    E0534
    E0535
    E0536
    E0537
    E0538
    E0540
    E0541
    E0542
    E0543
    E0544
    E0545
    E0546
    E0547
    W0500
    W0501
    W0502
    W0503
    W0510
    W0511
    // workpiece, tool, path
    E0600
    E0601
    E0602
    E0603
    E0604
    E0605
    E0620
    E0621
    E0622
    E0623
    E0624
    E0630
    E0631
    E0632
    E0640
    E0641
    E0642
    E0644
    E0645
    E0646
    E0650
    E0651
    E0652
    E0653
    E0654
    E0655
    E0656
    E0657
    E0658
    E0680
    E0681
    E0682
    E0683
    E0684
    E0685
    E0686
    E0687
    E0688
    E0690
    E0691
    E0692
    E0693
    W0600
    W0601
    W0602
    W0603
    W0604
    W0640
    W0641
    W0642
    W0643
    W0645
    // dwell
    E0700
    E0701
    E0702
    E0704
    E0705
    E0706
    E0707
    E0708
    E0709
    E0710
    E0711
    W0700
    W0701
    W0702
    W0704
    W0705
    W0706
    W0710
    // forecast
    E0730
    W0730
    W0731
    W0732
    W0733
    W0734
    W0735
    W0736
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
    E0909
    E0910
    E0911
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
    E1015
    // requirements
    E1101
    E1102
    E1103
    E1104
    // command line
    E1201
    E1202
    E1203
    E1204
    E1205
    E1206
    // simulate
    E1300
    E1301
    E1302
    E1303
    E1304
    E1305
    E1306
    W1300
    W1301
    W1302
    W1303
}
