mod lexer;
mod reader;
mod syntax;
