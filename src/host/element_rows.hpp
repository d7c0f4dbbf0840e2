#pragma once
// R_e of the elements of a block in a step, a row of nodes at a time: the sums of RowSums (element_rule.hpp) with the
// same operations in the same order, so to the same bits. W_i and masses stand number by number beside each other, as
// registers take them; a row of three nodes is read as four, and the last counts for nothing.

#include <cmath>
#include <limits>

#include "core/data/quad_group.hpp"
#include "core/surfaces/element_rule.hpp"

namespace moraine {

template <int Dim>
struct ElementRows {
    static constexpr int side = tile_side(3), reals = power<Dim>(side) + 1, lanes = SurfaceShares<Dim>::count;
    using Numbers = QuadGroup<double, 1>;

    double mass[reals], all[reals], across[lanes][reals];

    /// Of node n of the tile; mass: infinite where it holds no soil [kg].
    void set(int n, const SurfaceShares<Dim>& shares, double mass_of_node) {
        mass[n] = mass_of_node;
        all[n] = shares.all();
        for (int q = 0; q < lanes; ++q) across[q][n] = (q < Dim ? 1 : 2) * shares.across[q];
    }
    /// The number behind the last row.
    void close() { set(reals - 1, SurfaceShares<Dim>{}, std::numeric_limits<double>::infinity()); }

    double over_normal(const SurfaceElement<Dim>& e) const {
        return over(e, [&](int at) { return along(e.normal, at); });
    }
    double over_slip(const SurfaceElement<Dim>& e, const Vec<double, Dim>& way) const {
        return over(e, [&](int at) { return load(all + at) - along(way, at); });
    }

  private:
    static Numbers load(const double* from) { return Numbers::spread(Quad<double>::load(from)); }

    /// SurfaceShares::along_normal of four nodes.
    Numbers along(const Vec<double, Dim>& n, int at) const {
        Numbers sum(0.0);
        for (int a = 0; a < Dim; ++a) {
            sum += load(across[a] + at) * Numbers(n[a]) * Numbers(n[a]);
            if (Dim == 3 || a == 0) sum += load(across[Dim + a] + at) * Numbers(n[a]) * Numbers(n[(a + 1) % Dim]);
        }
        return sum;
    }
    template <class Share>
    double over(const SurfaceElement<Dim>& e, const Share& share) const {
        double size[SurfaceElement<Dim>::nodes + 1] = {}, row = 0;
        for (int i = 0; i < SurfaceElement<Dim>::nodes; ++i) size[i] = std::fabs(e.weight[i]);
        for (int r = 0; r < SurfaceElement<Dim>::nodes / 3; ++r) {
            const int at = tile_offset<Dim, 3>(e.cell) + side * (r % 3 + side * (r / 3));
            const Numbers of_row = load(size + 3 * r) * share(at) / load(mass + at);
            for (int i = 0; i < 3; ++i) row += of_row.e[i];
        }
        return row;
    }
};

/// Those of one element, as act_on_element asks for them.
template <int Dim>
struct KeptRows {
    const ElementRows<Dim>& block;
    double normal;  ///< over_normal()

    template <class Nodes>
    double across(const SurfaceElement<Dim>&, const Nodes&) const {
        return normal;
    }
    template <class Nodes>
    double along(const SurfaceElement<Dim>& e, const Nodes&, const Vec<double, Dim>& way) const {
        return block.over_slip(e, way);
    }
};

}  // namespace moraine
