//! The program from outside: arguments in, files, exit codes and lines out.

mod broken_bags;
mod demo;
mod evaluate;
mod help;
mod localize;
mod settings;
mod support;
