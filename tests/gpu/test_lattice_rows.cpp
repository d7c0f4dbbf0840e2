#include <doctest/doctest.h>

#include <cstring>
#include <vector>

#include "blocks/lattice_fill.hpp"
#include "core/material/laws.hpp"
#include "gpu/memory/lattice_rows.hpp"
#include "lattice_scenes.hpp"
#include "seeding/lattice_seeds.hpp"

using namespace moraine;

// What the device's kernel does by thread, done on the host: no device is needed.

namespace {

/// Rows of n particles, and the pointers to them.
template <class Real, int Dim>
struct RowMemory {
    std::vector<gpu::Row<Real>> core[gpu::core_rows<Dim>];
    std::vector<std::uint64_t> id;
    std::vector<std::uint16_t> body;
    gpu::Columns<Real, Dim> columns{};

    explicit RowMemory(std::size_t n) : id(n), body(n) {
        for (int k = 0; k < gpu::core_rows<Dim>; ++k) core[k].resize(n), columns.core[k] = core[k].data();
        columns.id = id.data();
        columns.body = body.data();
    }
};

template <class Real, int Dim>
bool same(const gpu::CoreRows<Real, Dim>& rows, const ParticleView<Real, Dim>& p, std::uint32_t s) {
    bool equal = rows.mass() == p.mass[s] && rows.volume() == p.volume[s] && rows.ln_J() == p.ln_J[s];
    for (int a = 0; a < Dim; ++a)
        equal = equal && rows.coordinate(a) == p.position[s][a] && rows.velocity(a) == p.velocity[s][a];
    for (int k = 0; k < Sym<Real, Dim>::size; ++k) equal = equal && rows.stress(k) == p.stress[s][k];
    return equal && rows.history() == Real(0);
}

/// As the kernel: bounds of the cells, then particle by particle.
template <class Real, int Dim>
void check_rows(const Scene& scene) {
    const Method<Host, Real, Dim> method(scene);
    const LatticeTables<Real, Dim> tables = lattice_tables(scene, method, DomainBlocks<Dim>(scene));
    const LatticeView<Real, Dim> lattice = tables.view();
    std::int64_t differ = 0, particles = 0;
    for (const LatticeBlock& block : lattice_blocks(tables, true)) {
        const BlockPosition<Dim> position = Morton<Dim>::decode(block.key);
        Vec<std::int32_t, Dim> at;
        std::copy(position.begin(), position.end(), at.e);
        Particles<Host, Real, Dim> columns(method.needs);
        columns.resize(block.particles);
        fill_block(lattice, at, 0, columns.view());
        RowMemory<Real, Dim> rows(block.particles);
        std::uint32_t bound[Block<Dim>::cells + 1] = {0}, cells = 0;
        for (int c = 0; c < Block<Dim>::cells; ++c) {
            bound[c + 1] = bound[c] + lattice.count(at, c);
            cells += lattice.count(at, c) > 0;
        }
        CHECK(bound[Block<Dim>::cells] == block.particles);
        CHECK(cells == block.cells);
        for (std::uint32_t k = block.particles; k-- > 0;) {
            const int cell = gpu::cell_at<Dim>(bound, k);
            gpu::put_rows(lattice.particle(at, cell, k - bound[cell]), rows.columns, k);
        }
        for (std::uint32_t k = 0; k < block.particles; ++k) {
            gpu::CoreRows<Real, Dim> core;
            for (int r = 0; r < gpu::core_rows<Dim>; ++r) core.row[r] = rows.core[r][k];
            const ParticleView<Real, Dim> p = columns.view();
            differ += !same(core, p, k) || rows.id[k] != p.id[k] || rows.body[k] != p.body[k];
        }
        particles += block.particles;
    }
    CHECK(differ == 0);
    CHECK(particles > 100);
}

}  // namespace

TEST_CASE("a device's rows of a lattice hold what the host's columns do") {
    for (const Scene& scene : test::lattice_scenes()) {
        CAPTURE(static_cast<int>(scene.shape));
        if (scene.dimensions == 2)
            check_rows<float, 2>(scene), check_rows<double, 2>(scene);
        else
            check_rows<float, 3>(scene), check_rows<double, 3>(scene);
    }
}
