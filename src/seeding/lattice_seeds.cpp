#include "seeding/lattice_seeds.hpp"

#include <algorithm>
#include <numeric>

#include "core/data/morton.hpp"
#include "core/material/laws.hpp"
#include "seeding/seed_state.hpp"

namespace moraine {

namespace {

constexpr std::int64_t most_points = std::int64_t(1) << 24;  ///< along one axis: the tables stay small

/// Where the points of one axis are binned.
template <class Real>
struct AxisPlaces {
    std::vector<std::int32_t> cell;  ///< 4 block + cell
    std::vector<Coordinate<Real>> u;
};

template <class Real, int Dim>
AxisPlaces<Real> places_along(const Scene& scene, const Method<Host, Real, Dim>& method,
                              const DomainBlocks<Dim>& domain, const Lattice& lattice, int a) {
    AxisPlaces<Real> places;
    const auto axis = static_cast<std::size_t>(a);
    for (std::int64_t i = 0; i < lattice.count[axis]; ++i) {
        const Place<Real> at = place_along(scene, method, a, lattice.place(axis, i));
        BlockPosition<Dim> block{};
        block[axis] = at.block;
        domain.wrap(block);
        places.cell.push_back(4 * block[axis] + cell_of<Real>(at.u));
        places.u.push_back(at.u);
    }
    return places;
}

/// Adds one axis of a body: points by cell, in each by index.
template <class Real, int Dim>
void add_axis(const AxisPlaces<Real>& places, int a, LatticeBody<Real, Dim>& body, LatticeTables<Real, Dim>& tables) {
    const auto [low, high] = std::minmax_element(places.cell.begin(), places.cell.end());
    const auto block_of = [](std::int32_t cell) { return cell >> 2; };  // rounds down
    body.block[a] = block_of(*low);
    body.blocks[a] = block_of(*high) - body.block[a] + 1;
    body.bound[a] = static_cast<std::uint32_t>(tables.bound.size());
    body.point[a] = static_cast<std::uint32_t>(tables.index.size());

    std::vector<std::uint32_t> order(places.cell.size());
    std::iota(order.begin(), order.end(), 0u);
    std::stable_sort(order.begin(), order.end(),
                     [&](std::uint32_t i, std::uint32_t j) { return places.cell[i] < places.cell[j]; });
    std::vector<std::uint32_t> bound(static_cast<std::size_t>(4 * body.blocks[a] + 1), 0);
    for (std::int32_t cell : places.cell) ++bound[static_cast<std::size_t>(cell - 4 * body.block[a] + 1)];
    std::partial_sum(bound.begin(), bound.end(), bound.begin());
    tables.bound.insert(tables.bound.end(), bound.begin(), bound.end());
    for (std::uint32_t i : order) {
        tables.index.push_back(i);
        tables.u.push_back(places.u[i]);
    }
}

/// What differs along one axis alone: stress with the height, velocity with the phase of a wave.
template <class Real, int Dim>
void add_state(const Scene& scene, const BodySpec& spec, const Lattice& lattice, LatticeBody<Real, Dim>& body,
               LatticeTables<Real, Dim>& tables) {
    const bool waves = spec.wave.wavelength > 0 && spec.wave.axis < Dim;
    body.up = up_axis(scene);
    body.wave = waves ? spec.wave.axis : 0;
    body.stress = static_cast<std::uint32_t>(tables.stress.size());
    body.flow = static_cast<std::uint32_t>(tables.flow.size());
    const auto up = static_cast<std::size_t>(body.up), wave = static_cast<std::size_t>(body.wave);
    for (std::int64_t i = 0; i < lattice.count[up]; ++i) {
        Triple x{};
        x[up] = lattice.place(up, i);
        tables.stress.push_back(geostatic_stress<Real>(scene, spec, x));
    }
    for (std::int64_t i = 0; i < lattice.count[wave]; ++i) {
        Triple x{};
        x[wave] = lattice.place(wave, i);
        const Triple v = start_velocity(spec, x);
        Vec<Real, Dim> flow;
        for (int a = 0; a < Dim; ++a) flow[a] = static_cast<Real>(v[static_cast<std::size_t>(a)]);
        tables.flow.push_back(flow);
    }
}

template <class Real, int Dim>
LatticeBody<Real, Dim> add_body(const Scene& scene, const Method<Host, Real, Dim>& method,
                                const DomainBlocks<Dim>& domain, std::size_t b, LatticeTables<Real, Dim>& tables) {
    const BodySpec& spec = scene.bodies[b];
    const Lattice lattice = lattice_of(scene, spec);
    LatticeBody<Real, Dim> body{};
    body.body = static_cast<std::uint16_t>(b);
    body.id = static_cast<std::uint64_t>(b) << 48;
    std::int64_t points = 1;
    for (int a = 0; a < Dim; ++a) {
        body.stride[a] = static_cast<std::uint64_t>(points);
        points *= lattice.count[static_cast<std::size_t>(a)];
        add_axis(places_along(scene, method, domain, lattice, a), a, body, tables);
    }
    const double density = scene.materials[static_cast<std::size_t>(spec.material)].density;
    const double mass = density * (measure_of(spec, scene.dimensions) / static_cast<double>(points));
    body.mass = static_cast<Real>(mass);
    body.volume = static_cast<Real>(mass / density);
    add_state(scene, spec, lattice, body, tables);
    return body;
}

template <class Real, int Dim>
Vec<std::int32_t, Dim> position_of(Key key) {
    const BlockPosition<Dim> at = Morton<Dim>::decode(key);
    Vec<std::int32_t, Dim> block;
    std::copy(at.begin(), at.end(), block.e);
    return block;
}

/// Blocks of one body, in any order.
template <class Real, int Dim>
void add_keys(const LatticeTables<Real, Dim>& tables, const LatticeBody<Real, Dim>& body, std::vector<Key>& keys) {
    std::array<std::vector<std::int32_t>, 3> along{{{0}, {0}, {0}}};
    for (int a = 0; a < Dim; ++a) {
        auto& blocks = along[static_cast<std::size_t>(a)];
        blocks.clear();
        const std::uint32_t* bound = tables.bound.data() + body.bound[a];
        for (std::int32_t k = 0; k < body.blocks[a]; ++k)
            if (bound[4 * k + 4] > bound[4 * k]) blocks.push_back(body.block[a] + k);
    }
    for (std::int32_t z : along[2])
        for (std::int32_t y : along[1])
            for (std::int32_t x : along[0]) {
                const std::array<std::int32_t, 3> all{x, y, z};
                BlockPosition<Dim> at;
                std::copy_n(all.begin(), Dim, at.begin());
                keys.push_back(Morton<Dim>::encode(at));
            }
}

}  // namespace

bool is_lattice(const Scene& scene) {
    if (!scene.course.tractions.empty()) return false;  // who is under one is not zeros
    for (const StructureSpec& structure : scene.structures)
        if (structure.clear) return false;
    for (const MaterialSpec& material : scene.materials)
        if (find_law(material.law)->has_initial_state || !material.profiles.empty() || material.keeps_strength)
            return false;
    return std::all_of(scene.bodies.begin(), scene.bodies.end(), [&](const BodySpec& body) {
        if (body.shape != BodyShape::box || body.seeding != Seeding::lattice || body.stage > 0) return false;
        const Lattice lattice = lattice_of(scene, body);
        return *std::max_element(lattice.count.begin(), lattice.count.end()) <= most_points;
    });
}

template <class Real, int Dim>
LatticeTables<Real, Dim> lattice_tables(const Scene& scene, const Method<Host, Real, Dim>& method,
                                        const DomainBlocks<Dim>& domain) {
    LatticeTables<Real, Dim> tables;
    for (std::size_t b = 0; b < scene.bodies.size(); ++b)
        tables.body.push_back(add_body(scene, method, domain, b, tables));
    return tables;
}

template <class Real, int Dim>
std::vector<LatticeBlock> lattice_blocks(const LatticeTables<Real, Dim>& tables, bool with_cells) {
    std::vector<Key> keys;
    for (const LatticeBody<Real, Dim>& body : tables.body) add_keys(tables, body, keys);
    std::sort(keys.begin(), keys.end());
    keys.erase(std::unique(keys.begin(), keys.end()), keys.end());
    const LatticeView<Real, Dim> lattice = tables.view();
    std::vector<LatticeBlock> blocks(keys.size());
#pragma omp parallel for schedule(static)
    for (std::size_t k = 0; k < keys.size(); ++k) {
        const Vec<std::int32_t, Dim> at = position_of<Real, Dim>(keys[k]);
        blocks[k] = {keys[k], lattice.count(at), 0};
        for (int cell = 0; with_cells && cell < Block<Dim>::cells; ++cell)
            blocks[k].cells += lattice.count(at, cell) > 0;
    }
    return blocks;
}

#define MORAINE_LATTICE(Real, Dim)                                                                 \
    template LatticeTables<Real, Dim> lattice_tables(const Scene&, const Method<Host, Real, Dim>&, \
                                                     const DomainBlocks<Dim>&);                    \
    template std::vector<LatticeBlock> lattice_blocks(const LatticeTables<Real, Dim>&, bool);
MORAINE_LATTICE(float, 2)
MORAINE_LATTICE(float, 3)
MORAINE_LATTICE(double, 2)
MORAINE_LATTICE(double, 3)
#undef MORAINE_LATTICE

}  // namespace moraine
