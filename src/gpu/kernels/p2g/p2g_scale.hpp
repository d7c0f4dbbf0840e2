#pragma once
// What particle to grid is told besides the view. Plain data.

namespace moraine::gpu {

/// With the mean in the force quad's last lane, for scenes whose fluids want it (core/data/grid_views.hpp).
template <class Real>
struct MeanScale {
    Real cell;     ///< h [m]
    bool volumes;  ///< NodeMean::volume, else NodeMean::stress
    bool of_grid;  ///< stresses act by their deviators (core/fluid/grid_pressure.hpp)
};

}  // namespace moraine::gpu
