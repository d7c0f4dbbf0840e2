#pragma once
// [[traction]]: pressure and shear on a flat part of a body's surface. Not collective.

#include <string>
#include <vector>

#include "core/scene_spec.hpp"
#include "io/input_error.hpp"

namespace moraine {

/// A traction as it is written; `spec` lacks body, face and table.
struct TractionText {
    TractionSpec spec;
    std::string body, table;
    int face = -1;  ///< 2 axis + (upper ? 1 : 0); -1: by `normal`
};

/// The spec, of a scene whose bodies are known; the table is the caller's. `path`: of the traction. Throws InputError.
TractionSpec complete_traction(const Scene& scene, const TractionText& text, const std::string& path,
                               const Places& places);

/// Those of the scene with the pressure and shear of a stage.
std::vector<TractionSpec> tractions_in_stage(const Scene& scene, const std::vector<TractionText>& texts,
                                             const Places& places);

/// Methods that tractions cannot do with, and surfaces that no soil is under. Of a scene that is whole. Takes time as
/// its particles do. Throws InputError.
void check_tractions(const Scene& scene, const Places& places);

}  // namespace moraine
