#pragma once
// Activity of blocks (core/sleep/sleep.hpp) between ranks, at sleep checks: of the host's engine and of a device's.

#include <vector>

#include "blocks/epoch.hpp"
#include "comm/point_to_point.hpp"

namespace moraine {

/// Sends the activity of the boundary's blocks to the peers that have them as ghosts; activity: of own blocks, then
/// ghosts. Collective over peers.
template <int Dim>
void exchange_activity(PointToPoint& messages, const EpochTables<Dim>& tables, std::vector<double>& activity);

}  // namespace moraine
