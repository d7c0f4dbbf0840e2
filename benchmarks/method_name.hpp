#pragma once
// How benchmarks name a method: shape TRANSFER UPDATE.

#include <string>

#include "core/scene.hpp"

namespace moraine {

std::string method_name(Shape shape, Transfer transfer, StressUpdate update);

}  // namespace moraine
