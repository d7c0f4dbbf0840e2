#pragma once
// What summary.json says of the machine: processor and cores that this process may use. No host name.

#include <string>

namespace moraine {

/// "Intel(R) Xeon(R) ... (family 6, model 207), 16 cores". Not collective.
std::string processor_name();

}  // namespace moraine
