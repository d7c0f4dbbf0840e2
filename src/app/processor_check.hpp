#pragma once
// Whether this processor has the instructions that the program was compiled for (MORAINE_MARCH). Asked before anything
// else, static objects included: without it an older processor ends the run by an illegal instruction.
//
// processor_check.cpp is compiled for the baseline of the architecture, processor_needs.cpp, which holds a number and
// no code, as all the rest.

namespace moraine {

/// Bits are places in the list of processor_check.cpp.
extern const unsigned processor_needs;

/// Of this processor.
unsigned processor_features();

/// The first feature that is needed and not there; null: none is missing.
const char* missing_feature(unsigned needs, unsigned has);

}  // namespace moraine
