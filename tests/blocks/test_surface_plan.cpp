#include <omp.h>

#include <utility>

#include "blocks/random_world.hpp"
#include "blocks/surface_plan.hpp"

using namespace moraine;
using moraine::test::World;

// What a plan finds by looking ahead, over epochs and by threads is what a new one finds.

namespace {

constexpr double cell = 0.5;

template <int Dim>
struct Bed {
    Structure<Dim> plane{};
    Walls<double, Dim> walls{};
    NodeCapacity<double, Dim> ends{};

    /// Through the middle of the domain, turned.
    explicit Bed(const World<Dim>& world) {
        plane.shape = StructureShape::plane, plane.law = InterfaceLaw::rough;
        double square = 0;
        for (int a = 0; a < Dim; ++a) {
            plane.at[a] = 0.5 * cell * world.domain.nodes[static_cast<std::size_t>(a)] + 0.13;
            plane.along[a] = a + 0.4, square += plane.along[a] * plane.along[a];
            for (int s = 0; s < 2; ++s) {
                walls.plane[a][s] = ends.plane[a][s] = s == 0 ? -1000 : 1000;
                ends.on[a][s] = ends.next[a][s] = 1;
            }
        }
        plane.along = (1 / std::sqrt(square)) * plane.along;
    }
    ContactField<Dim> field() const {
        ContactField<Dim> f{};
        f.structure = &plane, f.count = 1, f.cell = cell;
        return f;
    }
    void make(SurfacePlan<Dim>& plan, const EpochTables<Dim>& tables) const {
        plan.make(tables, field(), false, walls, ends);
    }
};

template <int Dim>
void check_same(const SurfaceBlock<Dim>& a, const SurfaceBlock<Dim>& b) {
    REQUIRE(a.elements.size() == b.elements.size());
    REQUIRE(a.slaves.size() == b.slaves.size());
    REQUIRE(a.around == b.around);
    REQUIRE(a.cell.size() == b.cell.size());
    for (std::size_t k = 0; k < a.elements.size(); ++k) {
        REQUIRE(a.elements[k].cell == b.elements[k].cell);
        for (int i = 0; i < a.elements[k].nodes; ++i) REQUIRE(a.elements[k].weight[i] == b.elements[k].weight[i]);
    }
    for (std::size_t c = 0; c < a.cell.size(); ++c) {
        REQUIRE(a.cell[c].volume == b.cell[c].volume);
        REQUIRE(!a.cell[c].cut == !b.cell[c].cut);
        for (int i = 0; a.cell[c].cut && i < CutCell<Dim>::nodes; ++i)
            REQUIRE(a.cell[c].cut->bed[i][0] == b.cell[c].cut->bed[i][0]);
    }
}

template <int Dim>
void check_same(const SurfacePlan<Dim>& a, const SurfacePlan<Dim>& b) {
    REQUIRE(a.blocks == b.blocks);
    REQUIRE(a.near_nodes == b.near_nodes);
    for (std::size_t k = 0; k < a.blocks.size(); ++k) check_same(*a.block_at[k], *b.block_at[k]);
    for (std::size_t j = 0; j < a.nodes_at.size(); ++j)
        for (int n = 0; n < a.cells; ++n) REQUIRE(a.nodes_at[j]->node[n].capacity == b.nodes_at[j]->node[n].capacity);
}

template <int Dim>
void check_plans(bool pressures) {
    int found = 0;
    for (std::uint64_t seed = 0; seed < 6; ++seed) {
        CAPTURE(seed);
        World<Dim> world(seed, 1);
        const Bed<Dim> bed(world);
        const auto tables = [&] { return make_epoch<Dim>(world.topology(), world.domain, world.stencil, 0); };
        const EpochTables<Dim> all = tables();
        for (std::size_t k = world.occupied.size(); k-- > 1;)
            if (k % 3 != 0) world.occupied.erase(world.occupied.begin() + static_cast<std::ptrdiff_t>(k));
        const EpochTables<Dim> few = tables();
        omp_set_num_threads(4);
        SurfacePlan<Dim> ahead(cell, 0, pressures);
        bed.make(ahead, few);
        while (ahead.prefetch()) ++found;
        bed.make(ahead, all);
        omp_set_num_threads(1);
        SurfacePlan<Dim> anew(cell, 0, pressures);
        bed.make(anew, all);
        check_same(ahead, anew);
        for (std::size_t k = 1; k < anew.block_at.size(); ++k)  // as their order says
            REQUIRE(anew.block_at[k]->number == anew.block_at[k - 1]->number + 1);
        SurfacePlan<Dim> back(cell, 0, pressures);
        bed.make(ahead, few), bed.make(back, few);
        check_same(ahead, back);
        bed.make(ahead, all);
        check_same(ahead, anew);
    }
    CHECK(found > 3);
}

}  // namespace

TEST_CASE("what is found ahead and by threads is what is found at once by one") {
    for (const bool pressures : {false, true}) check_plans<2>(pressures), check_plans<3>(pressures);
}
