#pragma once
// The plain reference: the definition, in double, by nested loops. Nobody times it.

#include <cmath>

#include "p2g/sample.hpp"

namespace moraine {

template <class Real>
std::vector<double> reference_sums(Sample<Real>& s) {
    std::vector<double> sums(s.grid_nodes() * node_reals, 0.0);
    for (int i = 0; i < s.particles(); ++i) {
        const auto p = static_cast<std::size_t>(i);
        const int block = i / (Block<3>::cells * Sample<Real>::per_cell);
        double w[3][3], dw[3][3];
        int lowest[3];
        for (int a = 0; a < 3; ++a) {
            lowest[a] = 4 * s.block_position[static_cast<std::size_t>(block)][a] + cell_of<Real>(s.position[p][a]);
            Quadratic::weights(static_cast<double>(fraction_of<Real>(s.position[p][a])), 0.0, w[a], dw[a]);
        }
        for (int n = 0; n < 27; ++n) {
            const int at[3] = {n % 3, n / 3 % 3, n / 9};
            double* to = sums.data() + s.node(lowest[0] + at[0], lowest[1] + at[1], lowest[2] + at[2]) * node_reals;
            const double weight = w[0][at[0]] * w[1][at[1]] * w[2][at[2]];
            to[0] += weight * static_cast<double>(s.mass[p]);
            for (int a = 0; a < 3; ++a) {
                to[1 + a] += weight * static_cast<double>(s.mass[p]) * static_cast<double>(s.velocity[p][a]);
                for (int b = 0; b < 3; ++b) {
                    double slope = dw[b][at[b]];
                    for (int c = 0; c < 3; ++c)
                        if (c != b) slope *= w[c][at[c]];
                    to[quad + a] -= static_cast<double>(s.volume[p]) * static_cast<double>(s.stress[p](a, b)) * slope;
                }
            }
        }
    }
    return sums;
}

/// Largest difference in a component over the largest value of that component.
template <class Real>
double relative_error(const GridSums<Real>& mine, const std::vector<double>& reference) {
    double worst = 0;
    for (int k = 0; k < node_reals; ++k) {
        double largest = 0;
        double difference = 0;
        for (std::size_t n = static_cast<std::size_t>(k); n < reference.size(); n += node_reals) {
            largest = std::fmax(largest, std::fabs(reference[n]));
            difference = std::fmax(difference, std::fabs(static_cast<double>(mine[n]) - reference[n]));
        }
        if (difference > 0) worst = std::fmax(worst, difference / largest);
    }
    return worst;
}

}  // namespace moraine
