#pragma once
// A dense box of blocks in Morton order with random particles, made on the device: what transfers are timed on.
//
// Cells hold 2^d particles on average and fill unevenly (standard deviation 1.4), as bodies that have moved do: a warp
// then has 23 of 32 lanes at work, as in the laboratory's scenes. Lists follow memory. There are no walls.

#include <bit>
#include <vector>

#include "core/data/hash.hpp"
#include "core/data/morton.hpp"
#include "gpu/kernels/view.hpp"
#include "gpu/memory/array.hpp"

namespace moraine::test {

/// A number from 0 to 1 that depends on its arguments alone.
template <class Real>
__device__ Real random_at(std::uint64_t entry, int what) {
    return Real(mix(entry * 64 + std::uint64_t(what)) >> 40) * Real(1.0 / (1 << 24));
}

/// Fills the particles of one cell per thread: positions anywhere in the cell, all other numbers of order one.
template <class Real, int Dim>
__global__ void fill_cells(gpu::View<Real, Dim> v, std::uint32_t* slots) {
    constexpr int cells = Block<Dim>::cells;
    const int b = int(blockIdx.x), c = int(threadIdx.x);
    const std::uint32_t* bounds = v.list.cell_first + std::size_t(b) * (cells + 1) + c;
    for (std::uint32_t s = v.list.first[b] + bounds[0]; s < v.list.first[b] + bounds[1]; ++s) {
        gpu::CoreRows<Real, Dim> r{};
        for (int k = 0; k < gpu::core_rows<Dim>; ++k)
            for (int e = 0; e < 4; ++e) r.row[k].e[e] = random_at<Real>(s, 4 * k + e) - Real(0.5);
        for (int a = 0; a < Dim; ++a)
            r.set_coordinate(a, Coordinate<Real>((c >> (2 * a)) & 3) * one_cell<Real> +
                                    Coordinate<Real>(random_at<Real>(s, 20 + a) * Real(one_cell<Real>)));
        r.mass() += Real(1), r.volume() += Real(1);
        for (int k = 0; k < gpu::core_rows<Dim>; ++k) v.p.core[k][s] = r.row[k];
        for (int e = 0; e < 4; ++e) {
            for (int k = 0; k < gpu::affine_rows<Dim>; ++k) v.p.affine[k][s].e[e] = random_at<Real>(s, 30 + 4 * k + e);
            v.p.log_stretch[s].e[e] = random_at<Real>(s, 50 + e) - Real(0.5);
        }
        v.p.body[s] = std::uint16_t(s & 1);
        slots[s] = s;
    }
}

template <class Real, int Dim>
class DenseBox {
  public:
    gpu::View<Real, Dim> view{};
    gpu::Chosen chosen{};
    std::uint32_t particles = 0;
    int blocks;

    /// 2^bits blocks, for stencils of `width` nodes per axis.
    DenseBox(int bits, int width) : blocks(1 << bits) {
        using B = Block<Dim>;
        std::vector<std::uint32_t> first(1, 0), cell_first;
        std::vector<Vec<std::int32_t, Dim>> position;
        std::vector<std::int32_t> every;
        for (int b = 0; b < blocks; ++b) {
            std::uint32_t n = 0;
            cell_first.push_back(0);
            for (int c = 0; c < B::cells; ++c) {
                n += (1u << Dim) - 4 + std::uint32_t(std::popcount(mix(std::uint64_t(b) * B::cells + c) & 0xff));
                cell_first.push_back(n);
            }
            first.push_back(particles += n);
            const auto at = Morton<Dim>::decode(Morton<Dim>::encode({}) + std::uint64_t(b));
            Vec<std::int32_t, Dim> p;
            for (int a = 0; a < Dim; ++a) p[a] = at[static_cast<std::size_t>(a)];
            position.push_back(p), every.push_back(b);
        }
        first_.assign(first), cell_first_.assign(cell_first), position_.assign(position), every_.assign(every);
        border_.assign(std::vector<std::uint8_t>(every.size(), 0));
        count_.assign({std::uint32_t(blocks)});
        half_size_.assign(std::vector<Vec<Real, Dim>>{filled(Real(0.25)), filled(Real(0.125))});
        tiles_.resize(every.size() * std::size_t(power<Dim>(tile_side(width)) * node_reals));
        make_view();
    }

  private:
    static Vec<Real, Dim> filled(Real value) {
        Vec<Real, Dim> v;
        for (int a = 0; a < Dim; ++a) v[a] = value;
        return v;
    }

    void make_view() {
        for (int k = 0; k < gpu::core_rows<Dim>; ++k) core_[k].resize(particles), view.p.core[k] = core_[k].data();
        for (int k = 0; k < gpu::affine_rows<Dim>; ++k)
            affine_[k].resize(particles), view.p.affine[k] = affine_[k].data();
        box_.resize(particles), body_.resize(particles), slot_.resize(particles);
        view.p.log_stretch = box_.data(), view.p.body = body_.data();
        view.table.own = blocks, view.table.position = position_.data(), view.table.border = border_.data();
        view.list = {first_.data(), cell_first_.data(), slot_.data()};
        view.grid.tile_of = every_.data(), view.grid.tiles = tiles_.data();
        view.context.inverse_cell = Real(2), view.context.half_size = half_size_.data();
        chosen = {every_.data(), count_.data()};
        fill_cells<Real, Dim><<<blocks, Block<Dim>::cells>>>(view, slot_.data());
        gpu::check(cudaDeviceSynchronize(), "Filling the box");
    }

    gpu::Array<gpu::Row<Real>> core_[gpu::core_rows<Dim>], affine_[gpu::affine_rows<Dim>], box_;
    gpu::Array<std::uint16_t> body_;
    gpu::Array<std::uint32_t> first_, cell_first_, slot_, count_;
    gpu::Array<std::int32_t> every_;
    gpu::Array<std::uint8_t> border_;
    gpu::Array<Vec<std::int32_t, Dim>> position_;
    gpu::Array<Vec<Real, Dim>> half_size_;
    gpu::Array<Real> tiles_;
};

}  // namespace moraine::test
