//! What a person types and sees. A case is a `.trycmd` file, or a `.toml` file with
//! what is printed beside it; it runs in the folder of its name that ends in `.in`, or in a copy of it where there is a
//! folder that ends in `.out`.

#[test]
fn cli() {
    trycmd::TestCases::new().case("tests/cli/*.trycmd").case("tests/cli/*.toml");
}
