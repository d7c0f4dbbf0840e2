#pragma once
// How benchmarks name a method: shape TRANSFER UPDATE, or shape FMPM(k), which has one update.

#include <string>

#include "core/scene_spec.hpp"

namespace moraine {

std::string method_name(Shape shape, Transfer transfer, StressUpdate update, int order = 2);

}  // namespace moraine
