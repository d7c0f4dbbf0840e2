#pragma once
// A sample (tests/core/sample.hpp) on the device: the same particles, lists and tables, for tests of single kernels.

#include <numeric>

#include "core/sample.hpp"
#include "gpu/kernels/view.hpp"
#include "gpu/memory/array.hpp"

namespace moraine::test {

/// The particle in a slot as rows: core, then affine, left stretch, log stretch where the columns exist.
template <class Real, int Dim>
gpu::CoreRows<Real, Dim> core_rows_of(const ParticleView<Real, Dim>& p, std::uint32_t s) {
    gpu::CoreRows<Real, Dim> r{};
    for (int a = 0; a < Dim; ++a) r.set_coordinate(a, p.position[s][a]), r.velocity(a) = p.velocity[s][a];
    r.mass() = p.mass[s], r.volume() = p.volume[s], r.ln_J() = p.ln_J[s];
    for (int k = 0; k < Sym<Real, Dim>::size; ++k) r.stress(k) = p.stress[s][k];
    r.history() = p.history[0] ? p.history[0][s] : Real(0);
    return r;
}

template <class Real, int Dim>
class DeviceSample {
  public:
    explicit DeviceSample(Sample<Real, Dim>& sample) {
        upload_particles(sample);
        upload_tables(sample);
        view.context = sample.method.context;
        const auto bodies = sample.scene.bodies.size();
        half_size_.assign(sample.method.context.half_size, bodies);
        view.context.half_size = half_size_.data();
        moves_.resize(sample.patch.particles.size());
        changed_.resize(sample.patch.particles.size() / 32 + static_cast<std::size_t>(sample.patch.own()) + 1);
        view.moves = moves_.data(), view.changed = changed_.data();
        clear_accounts();
        view.accounts = accounts_.data();
    }

    gpu::View<Real, Dim> view{};
    gpu::Chosen chosen{};  ///< all occupied own blocks

    std::vector<Quad<Real>> tiles() const { return tiles_.host(); }
    std::vector<Quad<Real>> nodes() const { return nodes_.host(); }
    void set_nodes(const std::vector<Quad<Real>>& nodes) { nodes_.assign(nodes); }
    std::vector<std::uint16_t> moves() const { return moves_.host(); }
    std::vector<std::uint32_t> changed() const { return changed_.host(); }
    std::vector<gpu::Account<Dim>> accounts() const { return accounts_.host(); }
    gpu::CoreRows<Real, Dim> particle(std::uint32_t s) const {
        gpu::CoreRows<Real, Dim> r;
        for (int k = 0; k < gpu::core_rows<Dim>; ++k)
            gpu::check(cudaMemcpy(&r.row[k], view.p.core[k] + s, sizeof(r.row[k]), cudaMemcpyDeviceToHost), "copy");
        return r;
    }
    void clear_accounts() {
        gpu::Account<Dim> empty{};
        empty.faulty_id = ~std::uint64_t(0);
        accounts_.assign(std::vector<gpu::Account<Dim>>(gpu::account_parts, empty));
    }

  private:
    void upload_particles(Sample<Real, Dim>& sample) {
        const ParticleView<Real, Dim> p = sample.patch.particles.view();
        const auto n = static_cast<std::uint32_t>(sample.patch.particles.size());
        std::vector<gpu::Row<Real>> rows[gpu::core_rows<Dim>];
        std::vector<gpu::Row<Real>> affine[gpu::affine_rows<Dim>], box;
        for (std::uint32_t s = 0; s < n; ++s) {
            const auto r = core_rows_of(p, s);
            for (int k = 0; k < gpu::core_rows<Dim>; ++k) rows[k].push_back(r.row[k]);
            for (int k = 0; p.affine && k < gpu::affine_rows<Dim>; ++k) {
                const auto& C = p.affine[s];
                affine[k].push_back(Dim == 3 ? gpu::Row<Real>{{C(k, 0), C(k, 1), C(k, Dim - 1), Real(0)}}
                                             : gpu::Row<Real>{{C(0, 0), C(0, 1), C(1, 0), C(1, 1)}});
            }
            if (p.log_stretch) {
                gpu::Row<Real> b{};
                for (int a = 0; a < Dim; ++a) b.e[a] = p.log_stretch[s][a];
                box.push_back(b);
            }
        }
        for (int k = 0; k < gpu::core_rows<Dim>; ++k) core_[k].assign(rows[k]), view.p.core[k] = core_[k].data();
        for (int k = 0; p.affine && k < gpu::affine_rows<Dim>; ++k)
            affine_[k].assign(affine[k]), view.p.affine[k] = affine_[k].data();
        if (p.log_stretch) box_.assign(box), view.p.log_stretch = box_.data();
        id_.assign(p.id, n), body_.assign(p.body, n);
        view.p.id = id_.data(), view.p.body = body_.data();
    }

    template <class T>
    T* copy(gpu::Array<T>& to, const T* from, std::size_t n) {
        to.assign(from, n);
        return to.data();
    }

    void upload_tables(Sample<Real, Dim>& sample) {
        auto& patch = sample.patch;
        const BlockTable<Dim> t = patch.table();
        const ListView<Dim> l = patch.list();
        const auto own = static_cast<std::size_t>(t.own), nb = static_cast<std::size_t>(t.node_blocks);
        using B = Block<Dim>;
        view.table = t;
        view.table.position = copy(position_, t.position, own);
        view.table.neighbour = copy(neighbour_, t.neighbour, own * B::offsets);
        view.table.node_block = copy(node_block_, t.node_block, own * B::corners);
        view.table.border = copy(border_, t.border, own);
        view.table.node_position = copy(node_position_, t.node_position, nb);
        view.table.source = copy(source_, t.source, nb * B::corners);
        view.table.node_border = copy(node_border_, t.node_border, nb);
        view.list.first = copy(first_, l.first, own + 1);
        view.list.cell_first = copy(cell_first_, l.cell_first, own * (B::cells + 1));
        view.list.slot = copy(slot_, l.slot, static_cast<std::size_t>(patch.count()));
        view.grid.tile_of = copy(tile_of_, patch.tile_of(), own);
        std::vector<std::int32_t> every(nb), occupied;
        std::iota(every.begin(), every.end(), 0);
        node_of_.assign(every);
        view.grid.node_of = node_of_.data();
        for (std::size_t b = 0; b < own; ++b)
            if (patch.tile_of()[b] >= 0) occupied.push_back(static_cast<std::int32_t>(b));
        occupied_.assign(occupied);
        count_.assign({static_cast<std::uint32_t>(occupied.size())});
        chosen = {occupied_.data(), count_.data()};
        const int tile_nodes = power<Dim>(tile_side(sample.method.stencil.width));
        tiles_.resize(occupied.size() * static_cast<std::size_t>(2 * tile_nodes));
        nodes_.resize(nb * B::cells * 2);
        gpu::check(cudaMemset(tiles_.data(), 0xff, tiles_.size() * sizeof(Quad<Real>)), "poisoning tiles");
        gpu::check(cudaMemset(nodes_.data(), 0xff, nodes_.size() * sizeof(Quad<Real>)), "poisoning nodes");
        view.grid.tiles = reinterpret_cast<Real*>(tiles_.data());
        view.grid.nodes = reinterpret_cast<Real*>(nodes_.data());
    }

    gpu::Array<gpu::Row<Real>> core_[gpu::core_rows<Dim>], affine_[gpu::affine_rows<Dim>], box_;
    gpu::Array<std::uint64_t> id_;
    gpu::Array<std::uint16_t> body_, moves_;
    gpu::Array<Vec<std::int32_t, Dim>> position_, node_position_;
    gpu::Array<std::int32_t> neighbour_, node_block_, source_, tile_of_, node_of_, occupied_;
    gpu::Array<std::uint8_t> border_, node_border_;
    gpu::Array<std::uint32_t> first_, cell_first_, slot_, count_, changed_;
    gpu::Array<Quad<Real>> tiles_, nodes_;
    gpu::Array<Vec<Real, Dim>> half_size_;
    gpu::Array<gpu::Account<Dim>> accounts_;
};

}  // namespace moraine::test
