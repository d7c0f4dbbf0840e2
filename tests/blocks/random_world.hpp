#pragma once
// A random domain, open, closed or periodic, with random occupied blocks and random owners: the same on
// all ranks that use the same seed.

#include <doctest/doctest.h>

#include <algorithm>
#include <random>
#include <set>
#include <vector>

#include "blocks/epoch.hpp"
#include "core/data/hash.hpp"

namespace moraine::test {

template <int Dim>
struct World {
    Scene scene;
    DomainBlocks<Dim> domain;
    Stencil stencil;
    std::vector<OccupiedBlock> occupied;
    int ranks;

    World(std::uint64_t seed, int of_ranks)
        : scene(random_scene(seed)), domain(scene), stencil(stencil_of(scene.shape)), ranks(of_ranks) {
        const double share = 0.05 + 0.3 * static_cast<double>(seed % 4);
        each_position([&](const BlockPosition<Dim>& at) {
            const Key key = Morton<Dim>::encode(at);
            if (static_cast<double>(mix(seed ^ mix(key)) % 1000) < 1000 * share) occupied.push_back({key, 0});
        });
        if (occupied.empty()) occupied.push_back({Morton<Dim>::encode({}), 0});
        std::sort(occupied.begin(), occupied.end(), [](const auto& a, const auto& b) { return a.key < b.key; });
        shuffle_owners(seed);
    }

    /// A pseudo-random owner per block.
    void shuffle_owners(std::uint64_t salt) {
        for (OccupiedBlock& b : occupied)
            b.owner = static_cast<std::int32_t>(mix(salt + mix(b.key)) % static_cast<unsigned>(ranks));
    }

    Topology<Dim> topology() const {
        return make_topology<Dim>(domain, occupied, [](const BlockPosition<Dim>&) { return -1; });
    }

    bool is_occupied(Key key) const {
        return std::any_of(occupied.begin(), occupied.end(), [key](const auto& b) { return b.key == key; });
    }

    /// Calls f(position) for each block of the domain.
    template <class F>
    void each_position(const F& f) const {
        BlockPosition<Dim> at{};
        const auto next = [&] {
            for (std::size_t a = 0; a < Dim; ++a) {
                if (++at[a] < domain.count[a]) return true;
                at[a] = 0;
            }
            return false;
        };
        do f(at);
        while (next());
    }

    /// Neighbour at an offset; false: outside.
    bool neighbour(const BlockPosition<Dim>& at, int code, BlockPosition<Dim>& to) const {
        for (int a = 0; a < Dim; ++a)
            to[static_cast<std::size_t>(a)] = at[static_cast<std::size_t>(a)] + Block<Dim>::offset(code, a);
        return domain.wrap(to);
    }

    /// Global index of a node of the tile of the block at `at`, wrapped.
    std::array<int, Dim> tile_node(const BlockPosition<Dim>& at, int n) const {
        const int side = tile_side(stencil.width);
        std::array<int, Dim> node{};
        for (std::size_t a = 0; a < Dim; ++a, n /= side) {
            node[a] = 4 * at[a] + n % side;
            if (domain.periodic[a]) node[a] %= domain.nodes[a];
        }
        return node;
    }

  private:
    static Scene random_scene(std::uint64_t seed) {
        Scene scene;
        scene.dimensions = Dim;
        scene.cell = 1;
        const moraine::Shape shapes[] = {moraine::Shape::linear, moraine::Shape::quadratic, moraine::Shape::cubic};
        scene.shape = shapes[seed % 3];
        for (std::size_t a = 0; a < Dim; ++a) {
            const std::uint64_t h = mix(seed * 8 + a);
            scene.periodic[a] = h % 2;
            const auto blocks = static_cast<double>(1 + h / 2 % (Dim == 2 ? 6 : 4));
            scene.max[a] = 4 * blocks + (scene.periodic[a] ? 0 : static_cast<double>(h / 64 % 4));
        }
        return scene;
    }
};

/// Does a tile node lie in the overlap with the block at offset `code`? By its definition.
template <int Dim>
bool overlaps(int n, int code, int width) {
    const int side = tile_side(width);
    for (int a = 0; a < Dim; ++a, n /= side) {
        const int eta = Block<Dim>::offset(code, a);
        const int from_eta = n % side - 4 * eta;  // place of the node in the tile of the block at eta
        if (from_eta < 0 || from_eta >= side) return false;
    }
    return true;
}

}  // namespace moraine::test
