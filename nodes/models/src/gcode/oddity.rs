//! What is odd in a file, as a value: named by line and reason, counted, never repaired in silence.

use serde::Serialize;

/// One odd thing in one line. "Refused" means that the line is not executed.
#[derive(Debug, Clone, PartialEq, thiserror::Error)]
#[non_exhaustive]
pub enum Oddity {
    /// Byte order mark.
    #[error("byte order mark skipped")]
    ByteOrderMark,
    /// Bytes of another encoding.
    #[error("comment is not UTF-8")]
    CommentNotUtf8,
    /// CR without LF.
    #[error("lone carriage return taken as the end of a command")]
    LoneCarriageReturn,
    /// Line beyond the limit.
    #[error("line longer than {limit} bytes: a command is refused, a comment is cut")]
    LongLine {
        /// Bytes that are read.
        limit: usize,
    },
    /// Command longer than firmware takes.
    #[error("command longer than {limit} bytes: firmware may cut it, executed as written")]
    LongCommand {
        /// Usual command buffer.
        limit: usize,
    },
    /// The file ends inside a line.
    #[error("no line end at the end of the file: it may have been cut")]
    NoLineEnd,
    /// `G28(comment)X0`.
    #[error("comment in parentheses skipped")]
    Parentheses,
    /// `G1X10Y10`.
    #[error("words without a space between them")]
    NoSpace,
    /// Nested parentheses.
    #[error("nested parentheses in a comment")]
    NestedParentheses,
    /// No closing parenthesis.
    #[error("comment parenthesis is not closed")]
    OpenParenthesis,
    /// Checksum does not fit.
    #[error("checksum {stated} does not fit {computed}: refused")]
    Checksum {
        /// As written.
        stated: f64,
        /// Exclusive-or of the bytes.
        computed: u8,
    },
    /// `*` without a number.
    #[error("checksum without a number: refused")]
    ChecksumMissing,
    /// Lower-case letters.
    #[error("lower-case letters read as upper case")]
    LowerCase,
    /// `Y 10`.
    #[error("space between {letter} and its value")]
    SpaceBeforeValue {
        /// The letter.
        letter: char,
    },
    /// `X1e2`.
    #[error("{letter}{text} read as {letter} and an E word: E is an axis, exponents do not exist")]
    Exponent {
        /// The letter before the number.
        letter: char,
        /// What follows.
        text: String,
    },
    /// `Y0x10`.
    #[error("{letter}{text} read as {letter}0 and an X word: hexadecimal numbers do not exist")]
    Hexadecimal {
        /// The letter before the number.
        letter: char,
        /// What follows.
        text: String,
    },
    /// A value that is no number.
    #[error("{letter} = {text}: not a number: refused")]
    NotANumber {
        /// The letter.
        letter: char,
        /// What stands there.
        text: String,
    },
    /// A letter that needs a value.
    #[error("{letter} has no value: refused")]
    NoValue {
        /// The letter.
        letter: char,
    },
    /// A word twice.
    #[error("{letter} is given twice: refused")]
    Repeated {
        /// The letter.
        letter: char,
    },
    /// A byte that is not part of a command.
    #[error("byte 0x{byte:02x} in a command: refused")]
    StrangeByte {
        /// The byte.
        byte: u8,
    },
    /// A value outside of what is believed.
    #[error("{field} = {value}: must be {rule}: refused")]
    OutOfRange {
        /// Field.
        field: char,
        /// Value as written.
        value: f64,
        /// Allowed range.
        rule: String,
    },
    /// A width or a height in a comment that no road has.
    #[error("{name} = {value} mm: must be in [{low}, {high}] mm: not used")]
    Comment {
        /// Name in the comment.
        name: &'static str,
        /// Value as written `[mm]`.
        value: f64,
        /// Least that is believed `[mm]`.
        low: f64,
        /// Largest `[mm]`.
        high: f64,
    },
    /// `G4 S100000000`.
    #[error("the print waits {time_s} s, longer than an hour: executed as written")]
    LongDwell {
        /// As written `[s]`.
        time_s: f64,
    },
    /// `/`.
    #[error("block delete: line skipped")]
    BlockDelete,
    /// `%`.
    #[error("program mark skipped")]
    ProgramMark,
    /// `@`.
    #[error("host command {0} skipped")]
    HostCommand(String),
    /// A command without a number.
    #[error("{0} is not a command number: refused")]
    BadCode(String),
    /// Words without a command.
    #[error("words without a command: refused")]
    NoCommand,
    /// Not known.
    #[error("{0} is not known: skipped")]
    Unknown(String),
    /// Known but not modelled.
    #[error("{0}")]
    Note(&'static str),
    /// An arc that cannot be drawn.
    #[error("arc refused: {0}")]
    Arc(&'static str),
}

/// An oddity and its line.
#[derive(Debug, Clone, PartialEq, Eq, Serialize)]
pub struct Warning {
    /// Line of the file, from 1.
    pub line: u64,
    /// What is odd.
    pub reason: String,
}

/// Bounded collection: the first ones are kept, all are counted.
#[derive(Debug, Clone, Default)]
pub struct Oddities {
    kept: Vec<Warning>,
    limit: usize,
    total: u64,
    line: u64,
    part: usize,
}

impl Oddities {
    /// Keeps at most `limit`.
    #[must_use]
    pub fn new(limit: usize) -> Self {
        Self { kept: Vec::new(), limit, total: 0, line: 0, part: 0 }
    }

    /// Those kept.
    #[must_use]
    pub fn kept(&self) -> &[Warning] {
        &self.kept
    }

    /// All, kept or not.
    #[must_use]
    pub fn total(&self) -> u64 {
        self.total
    }

    pub(crate) fn at_line(&mut self, line: u64) {
        self.line = line;
        self.part = self.kept.len();
    }

    /// Adds one at the current line; the same reason twice in a line counts once.
    #[allow(clippy::needless_pass_by_value, reason = "built at the call, used up here")]
    pub(crate) fn push(&mut self, oddity: Oddity) {
        let room = self.kept.len() < self.limit;
        if room {
            let reason = oddity.to_string();
            if self.kept[self.part..].iter().any(|warning| warning.reason == reason) {
                return;
            }
            self.kept.push(Warning { line: self.line, reason });
        }
        self.total += 1;
    }
}
