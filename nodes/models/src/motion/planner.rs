//! Look-ahead: speeds at the junctions of a bounded queue, by one backward and one forward pass.
//!
//! Until the next move is known the queue's last one ends at rest, so a released plan can always be kept: moves
//! that come later only raise speeds further back. Passes run once a batch, so the work per move is constant.

use super::block::Block;
use super::junction::{Corner, Direction, along, corner_m_s, standstill_m_s};
use super::params::{Limits, axis};
use super::segment::{Action, MoveKind, Role, Step};
use std::collections::VecDeque;

/// Queue length over look-ahead at which a batch is planned: the passes cost `1 + 1/(BATCH - 1)` visits a move.
const BATCH: usize = 4;

/// A move before it has a speed.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Waypoint {
    /// Line of the file, from 1.
    pub line: u64,
    /// Layer from 0.
    pub layer: Option<u32>,
    /// Start in machine coordinates `[m]`.
    pub start_m: [f64; 3],
    /// End in machine coordinates `[m]`.
    pub end_m: [f64; 3],
    /// Filament to push `[m]`, signed.
    pub filament_m: f64,
    /// Wished path speed `[m/s]`.
    pub feed_m_s: f64,
    /// What the move does.
    pub kind: MoveKind,
    /// What the road is for.
    pub role: Role,
    /// Chord of an arc or a spline.
    pub arc: bool,
    /// See [`Segment::target_width_m`].
    pub target_width_m: Option<f64>,
    /// Width as stated `[m]`.
    pub stated_width_m: Option<f64>,
    /// Height of the road `[m]`.
    pub layer_height_m: Option<f64>,
}

#[allow(
    clippy::large_enum_variant,
    reason = "nearly all are blocks; a box each costs more than the room saved"
)]
enum Item {
    Block(Block),
    Action(Action, u64),
}

/// What the next corner needs of the newest move.
struct Last {
    direction: Direction,
    cruise_m_s: f64,
    acceleration_m_s2: f64,
    path_m: f64,
}

/// Streaming planner with a bounded queue.
pub struct Planner {
    limits: Limits,
    lookahead_moves: usize,
    /// Open moves at which a batch is planned.
    batch_moves: usize,
    queue: VecDeque<Item>,
    /// Items at the queue's front whose speeds are final.
    released: usize,
    /// Moves behind them.
    open_moves: usize,
    /// Entry speed that the newest released move promises to the first open one; `None` from rest.
    promised_entry_m_s: Option<f64>,
    last: Option<Last>,
}

impl Planner {
    /// Plans under `limits`, knowing at least `lookahead_moves` moves ahead of a released one.
    #[must_use]
    pub fn new(limits: Limits, lookahead_moves: usize) -> Self {
        Self {
            limits,
            lookahead_moves,
            batch_moves: BATCH * lookahead_moves,
            queue: VecDeque::new(),
            released: 0,
            open_moves: 0,
            promised_entry_m_s: None,
            last: None,
        }
    }

    /// The same with no move beyond the look-ahead known when one is released.
    #[must_use]
    pub fn starved(self) -> Self {
        Self { batch_moves: self.lookahead_moves + 1, ..self }
    }

    /// Limits in force for moves pushed from now on.
    pub fn limits_mut(&mut self) -> &mut Limits {
        &mut self.limits
    }

    /// Takes a move; one without way and filament is nothing and vanishes.
    pub fn push_move(&mut self, waypoint: Waypoint) {
        let Some(block) = self.block(waypoint) else { return };
        self.last = Some(Last {
            direction: block.direction,
            cruise_m_s: block.cruise_m_s,
            acceleration_m_s2: block.acceleration_m_s2,
            path_m: block.path_m,
        });
        self.open_moves += 1;
        self.queue.push_back(Item::Block(block));
        if self.open_moves >= self.batch_moves {
            self.plan();
            self.release(self.items_before_last(self.lookahead_moves));
        }
    }

    /// Takes an action; one that stops the machine ends the look-ahead.
    pub fn push_action(&mut self, action: Action, line: u64) {
        if action.stops() {
            self.rest();
        }
        self.queue.push_back(Item::Action(action, line));
        if action.stops() || self.open_moves == 0 {
            self.release_all();
        } else if self.queue.len() - self.released > BATCH * BATCH * self.lookahead_moves {
            self.rest();
            self.release_all();
        }
    }

    /// No more moves follow: the last one ends at rest.
    pub fn finish(&mut self) {
        self.rest();
        self.release_all();
    }

    /// Next step whose speeds are final.
    pub fn pop(&mut self) -> Option<Step> {
        if self.released == 0 {
            return None;
        }
        self.released -= 1;
        match self.queue.pop_front()? {
            Item::Action(action, line) => Some(Step::Action(action, line)),
            Item::Block(block) => Some(Step::Move(block.segment())),
        }
    }

    fn rest(&mut self) {
        self.last = None;
        let last = self.queue.iter_mut().rev().find_map(|item| match item {
            Item::Block(block) => Some(block),
            Item::Action(..) => None,
        });
        if let Some(block) = last {
            block.then_rest = true;
        }
    }

    fn release_all(&mut self) {
        self.plan();
        self.release(self.queue.len());
    }

    /// Makes the speeds of the first `until` items final.
    fn release(&mut self, until: usize) {
        for item in self.queue.range(self.released..until) {
            if let Item::Block(block) = item {
                self.open_moves -= 1;
                self.promised_entry_m_s = (!block.then_rest).then_some(block.exit_m_s);
            }
        }
        self.released = until;
    }

    /// Items in front of the last `keep` moves.
    fn items_before_last(&self, keep: usize) -> usize {
        let mut moves = 0;
        for (index, item) in self.queue.iter().enumerate().rev() {
            if matches!(item, Item::Block(_)) {
                moves += 1;
                if moves == keep {
                    return index;
                }
            }
        }
        0
    }

    fn block(&self, waypoint: Waypoint) -> Option<Block> {
        let delta_m: [f64; 3] = std::array::from_fn(|axis| waypoint.end_m[axis] - waypoint.start_m[axis]);
        let length_m = delta_m.iter().map(|delta| delta * delta).sum::<f64>().sqrt();
        let path_m = if length_m > 0.0 { length_m } else { waypoint.filament_m.abs() };
        if path_m <= 0.0 {
            return None;
        }
        let [x, y, z] = delta_m.map(|delta| delta / path_m);
        let direction = [x, y, z, waypoint.filament_m / path_m];
        let wished_m_s2 = if direction[axis::E] == 0.0 {
            self.limits.travel_m_s2
        } else if length_m > 0.0 {
            self.limits.extruding_m_s2
        } else {
            self.limits.retract_m_s2
        };
        let acceleration_m_s2 = wished_m_s2.min(along(&direction, &self.limits.acceleration_m_s2));
        let cruise_m_s = waypoint.feed_m_s.min(along(&direction, &self.limits.feedrate_m_s));
        let standstill_m_s = standstill_m_s(&direction, &self.limits).min(cruise_m_s);
        let entry_max_m_s = match &self.last {
            Some(last) => {
                let corner = Corner {
                    before: last.direction,
                    after: direction,
                    acceleration_m_s2: acceleration_m_s2.min(last.acceleration_m_s2),
                    path_m: path_m.min(last.path_m),
                };
                corner_m_s(&corner, &self.limits).min(last.cruise_m_s).min(cruise_m_s)
            }
            None => standstill_m_s,
        };
        Some(Block {
            waypoint,
            length_m,
            path_m,
            direction,
            cruise_m_s,
            acceleration_m_s2,
            standstill_m_s,
            entry_max_m_s,
            entry_m_s: 0.0,
            exit_m_s: 0.0,
            then_rest: false,
        })
    }

    fn plan(&mut self) {
        let mut following_m_s = 0.0;
        for item in self.queue.range_mut(self.released..).rev() {
            let Item::Block(block) = item else { continue };
            block.exit_m_s = if block.then_rest { block.standstill_m_s } else { following_m_s };
            block.entry_m_s = block.entry_max_m_s.min(block.reachable_m_s(block.exit_m_s));
            following_m_s = block.entry_m_s;
        }
        let mut promised_m_s = self.promised_entry_m_s;
        for item in self.queue.range_mut(self.released..) {
            let Item::Block(block) = item else { continue };
            if let Some(promised_m_s) = promised_m_s {
                block.entry_m_s = promised_m_s;
            }
            block.exit_m_s = block.exit_m_s.min(block.reachable_m_s(block.entry_m_s));
            promised_m_s = (!block.then_rest).then_some(block.exit_m_s);
        }
    }
}
