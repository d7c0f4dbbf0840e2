#pragma once
// One scene for all ranks, whatever their hosts have on their disks.
//
// Rank 0 reads the text and sends it: a stale copy on one host, or a pipe, cannot make a run of two scenes. What every
// rank has of its own must be equal and is compared by hash: the commit of the program, --set, and the particle
// tables, which every rank reads because each seeds its own share of them.

#include <functional>

#include "app/options.hpp"
#include "comm/comm.hpp"
#include "core/scene_spec.hpp"

namespace moraine {

/// `admit` is that of read_scene.hpp. Throws InputError with the same words on all ranks. Collective.
Scene read_agreed(const Comm& comm, const Options& options, const std::function<void(const Scene&)>& admit);

}  // namespace moraine
