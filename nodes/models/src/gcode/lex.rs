//! One line into a command and its words.

use super::number::number;
use super::oddity::{Oddities, Oddity};
use super::words::Words;

/// What a line asks for.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Head<'a> {
    /// Nothing to execute: blank, comment, skipped or refused.
    None,
    /// `G1`, `M862.3`, `T0`: letter, number, number after the dot.
    Code(u8, u32, u32),
    /// A Klipper command or macro: its name.
    Macro(&'a [u8]),
}

/// A line taken apart; the words stand in the caller's [`Words`].
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub struct Lexed<'a> {
    /// The command.
    pub head: Head<'a>,
    /// Raw text after the head, for commands with free text and macros.
    pub text: &'a [u8],
    /// Text after `;`.
    pub comment: Option<&'a [u8]>,
}

/// `M` codes followed by free text: messages, file names, stop notes, quoted printer names, object names.
const FREE_TEXT: [u32; 15] = [0, 1, 16, 23, 28, 30, 32, 33, 36, 37, 117, 118, 486, 862, 928];

/// Takes one line without its end apart; `words` is emptied first.
pub fn lex<'a>(line: &'a [u8], words: &mut Words, odd: &mut Oddities) -> Lexed<'a> {
    words.clear();
    let line = line.trim_ascii();
    let nothing = |comment| Lexed { head: Head::None, text: &[], comment };
    match line.first() {
        None => return nothing(None),
        Some(b';') => return nothing(Some(&line[1..])),
        Some(b'/') => {
            odd.push(Oddity::BlockDelete);
            return nothing(None);
        }
        Some(b'%') => {
            odd.push(Oddity::ProgramMark);
            return nothing(None);
        }
        Some(b'@') => {
            odd.push(Oddity::HostCommand(shown(line)));
            return nothing(None);
        }
        Some(_) => {}
    }
    let Some(body) = line_number_and_checksum(line, odd) else { return nothing(None) };
    if body.is_empty() {
        return nothing(None);
    }
    let Some((head, text)) = head(body, odd) else { return nothing(None) };
    let free = match head {
        Head::Code(b'M', code, _) => FREE_TEXT.contains(&code),
        Head::Macro(_) => true,
        _ => false,
    };
    if free {
        return Lexed { head, text: text.trim_ascii(), comment: None };
    }
    let mut scan = Scan { bytes: text, at: 0, spaced: true, refused: false, comment: None };
    scan.words(words, odd);
    let head = if scan.refused { Head::None } else { head };
    Lexed { head, text, comment: scan.comment }
}

/// Strips `N<line>` and `*<checksum>`; `None` where the checksum refuses the line.
fn line_number_and_checksum<'a>(line: &'a [u8], odd: &mut Oddities) -> Option<&'a [u8]> {
    let numbered = matches!(line, [b'N' | b'n', b'0'..=b'9', ..]);
    if !numbered && line[0] != b'*' {
        return Some(line);
    }
    let code_end = line.iter().position(|byte| *byte == b';').unwrap_or(line.len());
    let star = line[..code_end].iter().rposition(|byte| *byte == b'*');
    let digits = if numbered { line[1..].iter().take_while(|byte| byte.is_ascii_digit()).count() } else { 0 };
    if line[0] == b'n' {
        odd.push(Oddity::LowerCase);
    }
    let body_start = if numbered { 1 + digits } else { 0 };
    let Some(star) = star else { return Some(line[body_start..].trim_ascii()) };
    let stated = number(line[star + 1..code_end].trim_ascii());
    let Some((stated, _)) = stated else {
        odd.push(Oddity::ChecksumMissing);
        return None;
    };
    let computed = line[..star].iter().fold(0, |sum, byte| sum ^ byte);
    if (stated - f64::from(computed)).abs() > 0.0 {
        odd.push(Oddity::Checksum { stated, computed });
        return None;
    }
    Some(line[body_start..star].trim_ascii())
}

fn head<'a>(body: &'a [u8], odd: &mut Oddities) -> Option<(Head<'a>, &'a [u8])> {
    let first = body[0];
    if first == b'(' {
        let mut scan = Scan { bytes: body, at: 0, spaced: true, refused: false, comment: None };
        scan.parenthesis(odd);
        let rest = body[scan.at..].trim_ascii();
        return if rest.is_empty() || rest[0] == b';' { None } else { head(rest, odd) };
    }
    if !first.is_ascii_alphabetic() {
        odd.push(Oddity::StrangeByte { byte: first });
        return None;
    }
    let letter = first.to_ascii_uppercase();
    let is_code = matches!(letter, b'G' | b'M' | b'T');
    let name_len = body.iter().take_while(|byte| byte.is_ascii_alphanumeric() || **byte == b'_').count();
    let second = body.get(1).copied().unwrap_or(b' ');
    if (second.is_ascii_alphabetic() || second == b'_') && !(letter == b'T' && name_len == 2) {
        return Some((Head::Macro(&body[..name_len]), &body[name_len..]));
    }
    if !is_code {
        odd.push(Oddity::NoCommand);
        return None;
    }
    let digits = body[1..].iter().take_while(|byte| byte.is_ascii_digit()).count();
    let Some(code) = integer(&body[1..=digits]) else {
        odd.push(Oddity::BadCode(shown(body)));
        return None;
    };
    if first != letter {
        odd.push(Oddity::LowerCase);
    }
    let mut rest = &body[1 + digits..];
    let mut sub = 0;
    if rest.first() == Some(&b'.') {
        let digits = rest[1..].iter().take_while(|byte| byte.is_ascii_digit()).count();
        sub = integer(&rest[1..=digits]).unwrap_or(0);
        rest = &rest[1 + digits..];
    }
    Some((Head::Code(letter, code, sub), rest))
}

fn integer(digits: &[u8]) -> Option<u32> {
    if digits.is_empty() || digits.len() > 6 {
        return None;
    }
    Some(digits.iter().fold(0, |value, digit| value * 10 + u32::from(digit - b'0')))
}

/// The start of odd text, printable.
pub(super) fn shown(bytes: &[u8]) -> String {
    const SHOWN: usize = 32;
    bytes.iter().take(SHOWN).flat_map(|byte| std::ascii::escape_default(*byte)).map(char::from).collect()
}

struct Scan<'a> {
    bytes: &'a [u8],
    at: usize,
    /// White space stood before the newest letter.
    spaced: bool,
    refused: bool,
    comment: Option<&'a [u8]>,
}

impl<'a> Scan<'a> {
    fn words(&mut self, words: &mut Words, odd: &mut Oddities) {
        let mut blank = false;
        while let Some(&byte) = self.bytes.get(self.at) {
            match byte {
                b' ' | b'\t' => {
                    self.at += 1;
                    blank = true;
                    continue;
                }
                b';' => {
                    self.comment = Some(&self.bytes[self.at + 1..]);
                    return;
                }
                b'(' => self.parenthesis(odd),
                b'"' => self.quoted(),
                _ if byte.is_ascii_alphabetic() => {
                    self.spaced = blank;
                    self.word(byte, words, odd);
                }
                _ => {
                    odd.push(Oddity::StrangeByte { byte });
                    self.refused = true;
                    self.at += 1;
                }
            }
            blank = false;
        }
    }

    fn word(&mut self, byte: u8, words: &mut Words, odd: &mut Oddities) {
        let letter = byte.to_ascii_uppercase();
        if byte != letter {
            odd.push(Oddity::LowerCase);
        }
        self.at += 1;
        let value_at = self.skip_blanks(self.at);
        let found = number(&self.bytes[value_at..]);
        if words.has(letter) {
            odd.push(Oddity::Repeated { letter: char::from(letter) });
            self.refused = true;
        }
        let Some((value, length)) = found else {
            self.without_number(letter, words, odd);
            return;
        };
        if !self.spaced {
            odd.push(Oddity::NoSpace);
        }
        if value_at > self.at {
            odd.push(Oddity::SpaceBeforeValue { letter: char::from(letter) });
        }
        let start = self.at;
        self.at = value_at + length;
        words.set(letter, value);
        if self.spaced {
            self.glued(letter, start, odd);
        }
    }

    /// `X1e2` and `Y0x10` after a blank: glued letters that look like another notation of the number.
    fn glued(&self, letter: u8, start: usize, odd: &mut Oddities) {
        let next = |offset: usize| self.bytes.get(self.at + offset).copied().unwrap_or(b' ');
        if !next(1).is_ascii_hexdigit() && !matches!(next(1), b'+' | b'-') {
            return;
        }
        let end = self.bytes[self.at..].iter().position(|byte| !byte.is_ascii_graphic());
        let text = || shown(&self.bytes[start..end.map_or(self.bytes.len(), |end| self.at + end)]);
        let letter = char::from(letter);
        match next(0) {
            b'e' | b'E' => odd.push(Oddity::Exponent { letter, text: text() }),
            b'x' | b'X' if &self.bytes[start..self.at] == b"0" => {
                odd.push(Oddity::Hexadecimal { letter, text: text() });
            }
            _ => {}
        }
    }

    fn without_number(&mut self, letter: u8, words: &mut Words, odd: &mut Oddities) {
        let rest = &self.bytes[self.at..];
        let length =
            rest.iter().position(|byte| matches!(byte, b' ' | b'\t' | b';' | b'(')).unwrap_or(rest.len());
        let token = &rest[..length];
        let flags =
            token.iter().all(|byte| byte.is_ascii_alphanumeric() || matches!(byte, b'.' | b'+' | b'-'));
        let named = [&b"nan"[..], b"inf", b"infinity"];
        let unsigned = token.strip_prefix(b"-").or(token.strip_prefix(b"+")).unwrap_or(token);
        let no_number = named.iter().any(|name| unsigned.eq_ignore_ascii_case(name));
        if token.first() == Some(&b'"') {
            words.set_bare(letter);
        } else if no_number || !flags || token.first().is_some_and(|byte| !byte.is_ascii_alphabetic()) {
            odd.push(Oddity::NotANumber { letter: char::from(letter), text: shown(token) });
            self.refused = true;
            self.at += length;
        } else {
            words.set_bare(letter);
        }
    }

    fn skip_blanks(&self, from: usize) -> usize {
        let blanks = self.bytes[from..].iter().take_while(|byte| matches!(byte, b' ' | b'\t')).count();
        from + blanks
    }

    fn quoted(&mut self) {
        let close = self.bytes[self.at + 1..].iter().position(|byte| *byte == b'"');
        self.at = close.map_or(self.bytes.len(), |close| self.at + close + 2);
    }

    fn parenthesis(&mut self, odd: &mut Oddities) {
        odd.push(Oddity::Parentheses);
        let mut depth = 0_u32;
        while let Some(&byte) = self.bytes.get(self.at) {
            self.at += 1;
            match byte {
                b'(' => {
                    depth += 1;
                    if depth == 2 {
                        odd.push(Oddity::NestedParentheses);
                    }
                }
                b')' => {
                    depth -= 1;
                    if depth == 0 {
                        return;
                    }
                }
                _ => {}
            }
        }
        odd.push(Oddity::OpenParenthesis);
    }
}
