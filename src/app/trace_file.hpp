#pragma once
// The timelines of all ranks as one file of Chrome's trace events (docs/trace.md), which Perfetto and chrome://tracing
// open: a rank is a process, a span a complete event ("ph": "X") with its phase as category. Times are in microseconds
// since all ranks began together [Trace Event Format, Google 2016].

#include <string>

#include "comm/comm.hpp"
#include "comm/timeline.hpp"

namespace moraine {

/// Of one rank, so that the file of all holds a million at most, some 120 MB.
std::size_t spans_of_rank(int ranks);

/// That the file can be written: its folder is there, or is `directory`, which the run makes; no file is, or it may be
/// replaced. Throws InputError, the same on all ranks. Collective.
void check_trace_file(const Comm& comm, const std::string& path, const std::string& directory, bool overwrite);

/// `scene`: its title; `device`: what this rank computes on. Throws MachineError on all ranks. Collective.
void write_trace(const Comm& comm, const std::string& path, Timeline& mine, const std::string& scene,
                 const std::string& device);

}  // namespace moraine
