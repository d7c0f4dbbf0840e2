#pragma once
// What summary.json says of the machine: processor, and cores that the ranks of a host may use together (a launcher may
// bind each to its own). No host name.

#include <string>

#include "comm/comm.hpp"

namespace moraine {

/// "Intel(R) Xeon(R) ... (family 6, model 207), 16 cores", of rank 0's host. Collective.
std::string processor_name(const Comm& comm);

}  // namespace moraine
