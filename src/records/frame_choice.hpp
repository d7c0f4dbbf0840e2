#pragma once
// What the outputs of a scene show, and the file's name.

#include "records/cell_frame.hpp"
#include "records/output_frame.hpp"

namespace moraine {

/// Calls f with the frame of the scene's outputs. Not collective but as f is.
template <class Real, int Dim, class F>
void with_frame(Simulation<Real, Dim>& sim, const F& f) {
    if (sim.scene().output.on_cells) {
        CellFrame<Real, Dim> frame(sim);
        f(frame);
    } else {
        OutputFrame<Real, Dim> frame(sim);
        f(frame);
    }
}

inline const char* series_name(const Scene& scene) {
    return scene.output.on_cells ? "cells.vtkhdf" : "particles.vtkhdf";
}

}  // namespace moraine
