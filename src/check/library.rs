//! stdlib: the vocabulary in the language itself, embedded, seen as virtual files `<std>/…`.

/// A file of stdlib.
#[derive(Clone, Copy, Debug)]
pub struct LibraryFile {
    /// Its words after `std` in a `use`, joined by dots: `robots.abb.irb6700_200_260`.
    pub module: &'static str,
    /// As shown to people: `<std>/robots/abb/irb6700_200_260.polish`.
    pub path: &'static str,
    pub text: &'static str,
    /// Whether it is visible without `use`.
    pub core: bool,
}

macro_rules! library {
    ($($core:literal $module:literal $path:literal)*) => {
        /// All files. Core files come first, in the order they are read.
        pub const FILES: &[LibraryFile] = &[
            $(LibraryFile {
                module: $module,
                path: concat!("<std>/", $path),
                text: include_str!(concat!("../../stdlib/", $path)),
                core: $core,
            }),*
        ];
    };
}

library! {
    true "dimensions" "dimensions.polish"
    true "units" "units.polish"
    true "functions" "functions.polish"
    true "geometry" "geometry.polish"
    true "workpiece" "workpiece.polish"
    true "metrology" "metrology.polish"
    true "tool" "tool.polish"
    true "influence" "influence.polish"
    true "path" "path.polish"
    true "dwell" "dwell.polish"
    true "robot" "robot.polish"
    true "cell" "cell.polish"
    true "target" "target.polish"
    true "controller" "controller.polish"
    true "result" "result.polish"
    true "job" "job.polish"
    false "materials.fused_silica" "materials/fused_silica.polish"
    false "materials.k9" "materials/k9.polish"
    false "materials.n_bk7" "materials/n_bk7.polish"
    false "materials.silicon_carbide" "materials/silicon_carbide.polish"
    false "materials.ule" "materials/ule.polish"
    false "materials.zerodur" "materials/zerodur.polish"
    false "robots.abb.irb6700_200_260" "robots/abb/irb6700_200_260.polish"
    false "robots.abb.irb6620_150_220" "robots/abb/irb6620_150_220.polish"
    false "robots.kuka.kr210_r2700_extra" "robots/kuka/kr210_r2700_extra.polish"
    false "robots.kuka.kr210_r2700_2" "robots/kuka/kr210_r2700_2.polish"
    false "controllers.irc5" "controllers/irc5.polish"
    false "controllers.krc4" "controllers/krc4.polish"
}

/// Prefix of the names of stdlib's files.
pub const PREFIX: &str = "<std>/";
