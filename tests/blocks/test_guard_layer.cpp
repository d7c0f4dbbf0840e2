#include "blocks/epoch.hpp"
#include "blocks/guard_layer.hpp"
#include "blocks/random_world.hpp"

using namespace moraine;
using moraine::test::World;

namespace {

/// Whole cells between a cell of a block, along an axis, and the neighbour at offset eta.
int gap(int place, int eta) {
    return eta == 0 ? 0 : eta > 0 ? 3 - place : place;
}

template <int Dim>
void guard_layer_is_near_absent_blocks() {
    for (std::uint64_t seed = 0; seed < 40; ++seed) {
        CAPTURE(seed);
        const World<Dim> world(seed, 3);
        const Topology<Dim> topology = world.topology();
        for (int rank = 0; rank < world.ranks; ++rank) {
            const EpochTables<Dim> t = make_epoch<Dim>(topology, world.domain, world.stencil, rank);
            for (std::size_t i = 0; i < t.own.size(); ++i) {
                std::uint64_t guard_layer = 0;
                BlockPosition<Dim> near{};
                for (int code = 0; code < Block<Dim>::offsets; ++code) {
                    if (!world.neighbour(Morton<Dim>::decode(t.own[i]), code, near)) continue;
                    if (topology.find(Morton<Dim>::encode(near)) >= 0) continue;
                    for (int cell = 0; cell < Block<Dim>::cells; ++cell) {
                        bool close = true;
                        for (int a = 0, n = cell; a < Dim; ++a, n /= 4)
                            close = close && gap(n % 4, Block<Dim>::offset(code, a)) < 3;
                        if (close) guard_layer |= std::uint64_t(1) << cell;
                    }
                }
                REQUIRE(t.guard_layer[i] == guard_layer);
                if (world.is_occupied(t.own[i])) REQUIRE(guard_layer == 0);
            }
        }
    }
}

}  // namespace

TEST_CASE("the guard layer is the cells less than 3 cells away from a block of the domain that the topology lacks") {
    guard_layer_is_near_absent_blocks<2>();
    guard_layer_is_near_absent_blocks<3>();
}
