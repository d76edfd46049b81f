//! What a node sees of the others in its domain.

use super::Node;
use crate::subscription::Gid;
use rustdds::RTPSEntity;
use std::collections::BTreeSet;

/// What the names of ROS topics have in front on DDS.
const TOPIC: &str = "rt";

impl Node {
    /// What the publishers of its process share, as [`Gid::process`] tells it.
    #[must_use]
    pub fn identity(&self) -> Gid {
        let mut bytes = [0; 16];
        let prefix = self.core.context.domain_participant().guid_prefix();
        bytes.iter_mut().zip(prefix.as_ref()).for_each(|(to, from): (&mut u8, &u8)| *to = *from);
        Gid(bytes)
    }

    /// Topics that other participants of the domain publish, by their names on the graph. Who has just joined knows a part
    /// of them: discovery takes up to 0.5 s.
    #[must_use]
    pub fn published_topics(&self) -> BTreeSet<String> {
        let participant = self.core.context.domain_participant();
        let own = participant.guid_prefix();
        let others = participant.discovered_writers().into_iter().filter(|writer| {
            // Where multicast comes back, so does what this one has announced.
            writer.writer_proxy.remote_writer_guid.prefix != own
        });
        let named =
            |name: String| name.strip_prefix(TOPIC).filter(|name| name.starts_with('/')).map(str::to_owned);
        others.filter_map(|writer| named(writer.publication_topic_data.topic_name)).collect()
    }
}
