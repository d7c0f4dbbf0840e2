#pragma once
// [shaking]: a base that moves by a table (core/gravity.hpp). Not collective.

#include "core/scene_spec.hpp"
#include "io/input_error.hpp"

namespace moraine {

/// What a base has at the end of its table, and at most: velocity [m/s] and way [m].
struct BaseDrift {
    double velocity = 0, way = 0, largest_velocity = 0, largest_way = 0;
};

/// By the integrals of the table's lines, which are exact at its rows.
BaseDrift drift_of(const ShakingSpec& shaking);

/// Direction, stage and base of a scene whose stages are known. Throws InputError.
void complete_shaking(Scene& scene, const Places& places);

}  // namespace moraine
