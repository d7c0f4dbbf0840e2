#pragma once
// The kernels side by side.

#include "stepper.cuh"

namespace lab {

/// The first is the one that whole steps use unless told otherwise.
template <class Real>
std::vector<P2gVariant<Real>> p2g_variants();
template <class Real>
std::vector<G2pVariant<Real>> g2p_variants();

template <>
inline std::vector<P2gVariant<float>> p2g_variants() {
    return {{"staged-3", run_staged<float, 3, 1, 3>, false},
            {"staged-4", run_staged<float, 4, 1, 3>, false},
            {"resident-3", run_resident<float, 3, 1, 3>, false},
            {"staged-3-free", run_staged<float, 3, 1, 2>, false},
            {"roles-3", run_staged<float, 3, 2, 2>, false},
            {"passes-2", run_passes<float, 2, 3>, false},
            {"direct", run_direct<float, 3>, false},
            {"node gather", run_gather_nodes<float>, true},
            {"global atomics", run_global_atomics<float>, true},
            {"shared atomics", run_shared_tile<float, 0>, false},
            {"warp reduction", run_shared_tile<float, 1>, false},
            {"fixed point", run_shared_tile<float, 2>, false}};
}
template <>
inline std::vector<P2gVariant<double>> p2g_variants() {
    return {{"resident-2", run_resident<double, 2, 2, 2>, false},
            {"passes-2", run_passes<double, 2, 2>, false},
            {"roles-3", run_staged<double, 3, 2, 1>, false},
            {"staged-3", run_staged<double, 3, 1, 1>, false},
            {"direct", run_direct<double, 1>, false},
            {"node gather", run_gather_nodes<double>, true},
            {"global atomics", run_global_atomics<double>, true},
            {"warp reduction", run_shared_tile<double, 1>, false}};
}
template <>
inline std::vector<G2pVariant<float>> g2p_variants() {
    return {{"steps-128x6", run_ahead<float, 128, 6, true>},  {"steps-128x5", run_ahead<float, 128, 5, true>},
            {"ahead-128x6", run_ahead<float, 128, 6, false>}, {"ahead-128x5", run_ahead<float, 128, 5, false>},
            {"128x5 narrow", run_g2p<float, 128, 5, true>},   {"128x4 narrow", run_g2p<float, 128, 4, true>},
            {"128x4 wide", run_g2p<float, 128, 4, false>},    {"128x6 narrow", run_g2p<float, 128, 6, true>},
            {"256x2 narrow", run_g2p<float, 256, 2, true>}};
}
template <>
inline std::vector<G2pVariant<double>> g2p_variants() {
    return {{"ahead-128x4", run_ahead<double, 128, 4, false>}, {"steps-128x4", run_ahead<double, 128, 4, true>},
            {"ahead-128x3", run_ahead<double, 128, 3, false>}, {"128x3 narrow", run_g2p<double, 128, 3, true>},
            {"128x2 narrow", run_g2p<double, 128, 2, true>},   {"128x4 narrow", run_g2p<double, 128, 4, true>},
            {"128x3 wide", run_g2p<double, 128, 3, false>}};
}

}  // namespace lab
