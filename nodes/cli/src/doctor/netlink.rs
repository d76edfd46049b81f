//! Interfaces of this process' network namespace, asked of the kernel: `/sys` may belong to another one.

use rustix::net::netlink::SocketAddrNetlink;
use rustix::net::{AddressFamily, RecvFlags, SendFlags, SocketFlags, SocketType, recv, sendto, socket_with};

/// Numbers of `linux/netlink.h` and `linux/rtnetlink.h`.
const DONE: u16 = 3;
const NEW_LINK: u16 = 16;
const GET_LINK: u16 = 18;
const REQUEST_DUMP: u16 = 0x301;
const NAME: u16 = 3;
/// Lengths of the header of a message and of a link in it `[byte]`.
const HEADER: usize = 16;
const LINK: usize = 16;
/// Longest answer that is read at once, as the kernel's own tools do `[byte]`.
const ANSWER: usize = 64 * 1024;

/// Name and flags of each interface.
///
/// # Errors
/// What the kernel says.
pub(super) fn interfaces() -> rustix::io::Result<Vec<(String, u32)>> {
    // Protocol 0 of the family is NETLINK_ROUTE.
    let socket = socket_with(AddressFamily::NETLINK, SocketType::RAW, SocketFlags::CLOEXEC, None)?;
    let mut request = Vec::with_capacity(HEADER + LINK);
    request.extend(32_u32.to_ne_bytes());
    request.extend(GET_LINK.to_ne_bytes());
    request.extend(REQUEST_DUMP.to_ne_bytes());
    request.resize(HEADER + LINK, 0);
    sendto(&socket, &request, SendFlags::empty(), &SocketAddrNetlink::new(0, 0))?;
    let (mut answer, mut found) = (vec![0; ANSWER], Vec::new());
    loop {
        let (_, length) = recv(&socket, &mut answer[..], RecvFlags::empty())?;
        if !take(answer.get(..length).unwrap_or_default(), &mut found) {
            return Ok(found);
        }
    }
}

/// Takes the links of an answer in; `false` where nothing follows.
fn take(mut answer: &[u8], found: &mut Vec<(String, u32)>) -> bool {
    while let Some((length, kind)) = u32_at(answer, 0).zip(u16_at(answer, 4)) {
        let length = length as usize;
        let Some(body) = answer.get(HEADER..length) else { return false };
        match kind {
            NEW_LINK => found.extend(link(body)),
            DONE => return false,
            // An error: what was found counts.
            _ => return false,
        }
        answer = answer.get(length.next_multiple_of(4)..).unwrap_or_default();
    }
    true
}

/// Name and flags of one link.
fn link(body: &[u8]) -> Option<(String, u32)> {
    let flags = u32_at(body, 8)?;
    let mut attributes = body.get(LINK..)?;
    while let Some((length, kind)) = u16_at(attributes, 0).zip(u16_at(attributes, 2)) {
        let value = attributes.get(4..usize::from(length))?;
        if kind == NAME {
            let name = value.split(|byte| *byte == 0).next()?;
            return Some((String::from_utf8_lossy(name).into_owned(), flags));
        }
        attributes = attributes.get(usize::from(length).next_multiple_of(4)..)?;
    }
    None
}

fn u16_at(bytes: &[u8], at: usize) -> Option<u16> {
    bytes.get(at..)?.first_chunk().map(|bytes| u16::from_ne_bytes(*bytes))
}

fn u32_at(bytes: &[u8], at: usize) -> Option<u32> {
    bytes.get(at..)?.first_chunk().map(|bytes| u32::from_ne_bytes(*bytes))
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Every network namespace has a loopback interface.
    #[test]
    fn the_kernel_tells_of_the_loopback() {
        let found = interfaces().unwrap();
        assert!(found.iter().any(|(name, flags)| name == "lo" && flags & 0x8 != 0), "{found:?}");
        let names = std::fs::read_to_string("/proc/self/net/dev").unwrap();
        let names: Vec<&str> =
            names.lines().skip(2).filter_map(|line| line.trim().split(':').next()).collect();
        assert_eq!(found.len(), names.len(), "{found:?} {names:?}");
        assert!(found.iter().all(|(name, _)| names.contains(&name.as_str())), "{found:?} {names:?}");
    }

    #[test]
    fn an_answer_that_breaks_off_ends() {
        let mut found = Vec::new();
        for bytes in [&[0_u8; 16][..], &[40, 0, 0, 0, 16, 0, 0, 0], &[255; 64]] {
            assert!(!take(bytes, &mut found));
        }
        assert!(take(&[], &mut found) && found.is_empty());
    }
}
