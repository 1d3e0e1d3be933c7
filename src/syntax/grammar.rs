//! The grammar of one entry, and what its expectations are called in plain words.

use pest::Parser;
use pest::error::{Error, ErrorVariant, InputLocation};
use pest::iterators::Pairs;
use std::collections::BTreeSet;
use std::num::NonZeroUsize;

#[derive(pest_derive::Parser)]
#[grammar = "grammar/polish.pest"]
struct Polish;

/// Calls of rules that one entry may cost. The longest entry allowed (4096 lexemes) costs about 60 for each lexeme;
/// this is eight times as much, and stops a grammar that has become exponential by mistake.
const CALL_LIMIT: NonZeroUsize = NonZeroUsize::new(2_000_000).expect("not zero");

/// Where the grammar stopped, and what it would have taken there. Nothing was expected if a limit stopped it.
pub struct Stopped {
    pub at: usize,
    pub expected: BTreeSet<&'static str>,
    pub limit: bool,
}

/// Runs the grammar on one entry.
pub fn parse(rule: Rule, text: &str) -> Result<Pairs<'_, Rule>, Stopped> {
    // The setting is the process's and the same for all, so setting it again changes nothing.
    pest::set_call_limit(Some(CALL_LIMIT));
    Polish::parse(rule, text).map_err(stopped)
}

fn stopped(error: Error<Rule>) -> Stopped {
    let at = match error.location {
        InputLocation::Pos(at) | InputLocation::Span((at, _)) => at,
    };
    match error.variant {
        ErrorVariant::ParsingError { positives, .. } => {
            let mut expected: BTreeSet<&'static str> = positives.into_iter().filter_map(plain_words).collect();
            // The general word covers the ways in which a value can begin or go on.
            if expected.contains("a value") {
                expected.retain(|word| !matches!(*word, "a name" | "`(`" | "`{`"));
            }
            if expected.contains("an operator") {
                expected.retain(|word| !matches!(*word, "`(`" | "`{`"));
            }
            Stopped { at, expected, limit: false }
        }
        ErrorVariant::CustomError { .. } => Stopped { at, expected: BTreeSet::new(), limit: true },
    }
}

/// What a rule is called in a message. `None`: it may stand there, but saying so helps nobody.
fn plain_words(rule: Rule) -> Option<&'static str> {
    use Rule as R;
    Some(match rule {
        R::expression | R::arithmetic | R::literal | R::number | R::text | R::list_value | R::list | R::named => {
            "a value"
        }
        R::parenthesised | R::minus | R::not | R::interval | R::branch => "a value",
        R::or | R::and | R::comparison | R::range | R::add | R::subtract | R::multiply | R::divide | R::power => {
            "an operator"
        }
        R::bounds => "a comparison or a range",
        R::EOI => "the end of the entry",
        R::name | R::family_name | R::symbol | R::field_name | R::path_word | R::parameter => "a name",
        R::count | R::exponent_number | R::type_exponent => "a whole number",
        R::unit | R::unit_factor | R::unit_word => "a unit",
        R::unit_power => "a power",
        R::type_whole | R::type_range | R::type_product | R::type_power | R::type_name | R::symbols => "a type",
        R::block => "`{`",
        R::open => "`(`",
        R::close => "`)`",
        R::colon => "`:`",
        R::equals => "`=`",
        R::arrow => "`->`",
        R::comma => "`,`",
        R::bar => "`|`",
        R::where_word | R::where_clause => "`where`",
        R::usual_word | R::usual_clause => "`usual`",
        R::check_word | R::check_line => "`check`",
        R::then_word => "`then`",
        R::else_word => "`else`",
        R::in_word => "`in`",
        R::because_word | R::reason => "`because`",
        R::code => "the code of a warning",
        R::field | R::schema_field => "a field",
        R::module_path => "a name or a file",
        R::language_word | R::language_line => "`language`",
        R::use_word | R::use_item | R::let_word | R::let_item | R::param_word | R::param_item => "an item",
        R::family_word | R::family_item | R::schema_word | R::schema_item | R::job_word | R::job_item => "an item",
        R::dimension_word | R::dimension_item | R::unit_item_word | R::unit_item | R::public => "an item",
        R::fn_word | R::fn_item | R::assert_word | R::assert_item | R::allow_word => "an item",
        R::if_word | R::for_word | R::for_clause => return None,
        R::member | R::dot | R::call | R::with | R::with_word | R::optional | R::semicolon | R::per => return None,
        R::WHITESPACE | R::word | R::word_char | R::plain_word | R::keyword => return None,
        R::start_item | R::start_entry | R::start_schema | R::start_element | R::start_type | R::start_allow => {
            return None;
        }
        R::item
        | R::row
        | R::conditional
        | R::term
        | R::arithmetic_term
        | R::operand
        | R::postfix
        | R::infix
        | R::arithmetic_infix => {
            return None;
        }
        R::type_atom => return None,
    })
}
