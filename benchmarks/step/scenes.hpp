#pragma once
// The scenes of the step's benchmark, made in code: dense bodies whose particles all move.
//
// A column of clay, half as wide as its domain, slides over a free-slip floor at 2 m/s, falls under
// gravity and is sheared by a standing wave of velocity, so that most of it yields. A particle moves by
// 3 % of a cell per step at first and by 8 % on average at the end. The x axis is periodic.

#include <string>
#include <vector>

#include "core/scene_spec.hpp"

namespace moraine {

struct Case {
    std::string name;
    Scene scene;
};

struct ColumnOptions {
    int dimensions = 3;
    Precision precision = Precision::double_;
    Shape shape = Shape::quadratic;
    Transfer transfer = Transfer::flip;
    StressUpdate stress_update = StressUpdate::usl;
    std::string law = "von-mises";
    Volumetric volumetric = Volumetric::particle;
    std::array<int, 3> particles_per_cell{2, 2, 2};
};

/// A column of about `particles` particles.
Case column_case(const ColumnOptions& options, double particles);

/// The two cases that have a target.
std::vector<Case> target_cases(double particles);

/// Those and one for each shape, transfer, stress update, law and dimension, and with the volumetric rates of cells.
std::vector<Case> all_cases(double particles);

/// Cases for the cost of a block: few and many particles per cell, thin layers, single cells.
std::vector<Case> cost_cases(double particles);

}  // namespace moraine
