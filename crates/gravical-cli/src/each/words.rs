//! The options of a run in words: for the record of each result, and to know whether a result
//! was computed with the same ones.

use std::path::Path;

use clap::parser::ValueSource;
use clap::{ArgMatches, Command};
use gravical::escape::{path_word, shell_word};

/// Options that say where to write and how to run, and not what to compute.
const OF_THE_RUN: [&str; 11] = [
    "each", "summary", "resume", "shard", "retries", "threads", "output", "force", "quiet", "json",
    "verbose",
];

/// The options of a command, as they were given, in the order of its help.
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct Words {
    /// Name of the command.
    pub verb: String,
    /// `--name=value`.
    pub options: Vec<String>,
}

impl Words {
    /// Those of `matches`, of a command that was parsed.
    pub fn of(command: &Command, matches: &ArgMatches) -> Self {
        let mut options = Vec::new();
        for arg in command.get_arguments() {
            let id = arg.get_id().as_str();
            let given = matches.value_source(id) == Some(ValueSource::CommandLine);
            let (Some(name), true) = (arg.get_long(), given) else {
                continue;
            };
            if OF_THE_RUN.contains(&id) {
                continue;
            }
            if !arg.get_action().takes_values() {
                options.push(format!("--{name}"));
                continue;
            }
            let values = matches.get_raw(id).into_iter().flatten();
            options.extend(values.map(|v| format!("--{name}={}", v.to_string_lossy())));
        }
        Words {
            verb: command.get_name().to_owned(),
            options,
        }
    }

    /// The command that makes the same result alone.
    pub fn command(&self, input: &Path, output: Option<&Path>) -> String {
        let mut words = vec!["gravical".to_owned(), self.verb.clone(), path_word(input)];
        words.extend(self.options.iter().map(|o| shell_word(o)));
        if let Some(output) = output {
            words.extend(["-o".to_owned(), path_word(output)]);
        }
        words.join(" ")
    }
}

#[cfg(test)]
mod tests {
    use clap::{Arg, ArgAction};

    use super::*;

    #[test]
    fn only_what_was_given_and_decides_is_there() {
        let command = || {
            Command::new("weigh")
                .arg(Arg::new("inputs").num_args(1..))
                .arg(Arg::new("each").long("each").action(ArgAction::SetTrue))
                .arg(Arg::new("output").short('o').long("output"))
                .arg(Arg::new("unit").long("unit").default_value("g"))
                .arg(Arg::new("axes").long("axes").allow_hyphen_values(true))
                .arg(Arg::new("pose").long("pose").action(ArgAction::Append))
                .arg(Arg::new("raw").long("raw").action(ArgAction::SetTrue))
        };
        let words = |line: &str| {
            let matches = command().get_matches_from(line.split(' '));
            Words::of(&command(), &matches)
        };
        let one = words("weigh --pose a b.csv --each -o out --axes -x,y,z --raw --pose=c");
        let options = ["--axes=-x,y,z", "--pose=a", "--pose=c", "--raw"];
        assert_eq!(one.options, options);
        assert_eq!(
            one,
            words("weigh --raw --axes=-x,y,z c.csv --pose a --pose c")
        );
        assert_eq!(
            one.command(Path::new("my file.csv"), Some(Path::new("a.json"))),
            "gravical weigh \"my file.csv\" --axes=-x,y,z --pose=a --pose=c --raw -o a.json"
        );
    }
}
