#pragma once
// Light nodes on the device (core/grid/light_stencil.hpp): what one particle's gradients lose, read from memory node by
// node. Slopes are per cell. Only blocks that find_limited.cuh has listed come here.

#include "core/grid/light_stencil.hpp"
#include "gpu/kernels/g2p/box.cuh"

namespace moraine::gpu {

/// The nodes of one block's particles in shared memory, their masses with them; ghosts behind walls as they lie there,
/// for nobody asks for them.
template <class Real, int Dim, int Width>
struct LightTile {
    static constexpr int size = power<Dim>(tile_side(Width));
    Row<Real> first[size];   ///< v', zero along axes that the node is held along, and m in the last lane
    Row<Real> second[size];  ///< dv, and 1 / m

    __device__ __forceinline__ void set(int n, const Row<Real>* node) {
        const Row<Real> node_now = load_row(node);
        Row<Real> now = node_now, change = load_row(node + 1);
        const Real m = now.e[quad - 1];
#pragma unroll
        for (int b = 0; b < Dim; ++b)
            if (!moves_along<Real, Dim>(node_now.e, b)) now.e[b] = Real(0);
        change.e[quad - 1] = m > Real(0) ? Real(1) / m : Real(0);
        store_row(first + n, now);
        store_row(second + n, change);
    }
    __device__ __forceinline__ Real mass(int n) const {
        return first[n].e[quad - 1];
    }
    __device__ __forceinline__ Real inverse(int n) const {
        return second[n].e[quad - 1];
    }
    /// Whether nothing holds the node along axis b.
    __device__ __forceinline__ bool moves(int n, int b) const {
        return first[n].e[b] != Real(0);
    }
};

/// The masses alone, and which axes a node moves along.
template <class Real, int Dim, int Width>
struct MassTile {
    static constexpr int size = power<Dim>(tile_side(Width));
    Real masses[size], inverses[size];
    std::uint8_t moving[size];  ///< bits, by axis

    __device__ __forceinline__ void set(int n, const Row<Real>* node) {
        const Row<Real> now = load_row(node);
        masses[n] = now.e[quad - 1];
        inverses[n] = masses[n] > Real(0) ? Real(1) / masses[n] : Real(0);
        unsigned bits = 0;
#pragma unroll
        for (int b = 0; b < Dim; ++b) bits |= unsigned(moves_along<Real, Dim>(now.e, b)) << b;
        moving[n] = static_cast<std::uint8_t>(bits);
    }
    __device__ __forceinline__ Real mass(int n) const {
        return masses[n];
    }
    __device__ __forceinline__ Real inverse(int n) const {
        return inverses[n];
    }
    __device__ __forceinline__ bool moves(int n, int b) const {
        return (moving[n] >> b & 1) != 0;
    }
};

/// Fills the tile of a block; all threads of the team, which see it afterwards.
template <class Shape, class Real, int Dim, class Tile>
__device__ __forceinline__ void load_light_tile(const View<Real, Dim>& v, int block, Tile& tile) {
    for (int n = Team<Dim>::rank(); n < Tile::size; n += Team<Dim>::threads)
        tile.set(n, node_in_tile<tile_side(Shape::width)>(v, block, n));
    Team<Dim>::sync();
}

/// A cell of a block: its first node, and the ghosts that its stencil reaches.
template <class Shape, int Dim>
struct LightCell {
    int number;            ///< in the block
    int first;             ///< node in the tile
    int index[Dim];        ///< in the domain
    unsigned ghosts[Dim];  ///< Walls::ghosts
    bool at_wall;

    /// at: of the cell in the block.
    template <class Real>
    __device__ __forceinline__ LightCell(const View<Real, Dim>& v, int block, const int (&at)[Dim]) {
        number = first = 0;
        at_wall = false;
#pragma unroll
        for (int a = Dim - 1; a >= 0; --a) {
            number = number * Block<Dim>::side + at[a];
            first = first * tile_side(Shape::width) + at[a];
            index[a] = first_node<Shape>(v.table.position[block][a]) + at[a];
            ghosts[a] = v.table.border[block] ? v.context.walls.ghosts(a, index[a], Shape::width) : 0u;
            at_wall = at_wall || ghosts[a] != 0;
        }
    }

    /// Whether the node at i, j, k of the stencil is none of its ghosts.
    __device__ __forceinline__ bool is_inside(int i, int j, int k) const {
        return !at_wall || moraine::is_inside<Dim>(ghosts, i, j, k);
    }
};

/// What the particles of a cell share.
template <class Real, int Dim>
struct CellMasses {
    Real least[Block<Dim>::cells];   ///< of a node of the stencil; negative where a ghost is folded [kg]
    Real around[Block<Dim>::cells];  ///< of all its nodes but ghosts [kg]
};

/// Fills them; all threads of the team, which see them afterwards.
template <class Shape, class Real, int Dim, class Tile>
__device__ __forceinline__ void weigh_cells(const View<Real, Dim>& v, int block, const Tile& tile,
                                            CellMasses<Real, Dim>& masses) {
    for (int c = Team<Dim>::rank(); c < Block<Dim>::cells; c += Team<Dim>::threads) {
        int at[Dim];
#pragma unroll
        for (int a = 0; a < Dim; ++a) at[a] = cell_coordinate<Dim>(c, a);
        const LightCell<Shape, Dim> cell(v, block, at);
        Real least = tile.mass(cell.first), around = Real(0);
        each_node<Dim, Shape::width>([&](int n, int i, int j, int k) {
            const Real m = tile.mass(cell.first + n);
            least = min(least, m);
            around += cell.is_inside(i, j, k) ? m : Real(0);
        });
        masses.least[c] = cell.at_wall ? Real(-1) : least;
        masses.around[c] = around;
    }
    Team<Dim>::sync();
}

/// Thread blocks of a multiprocessor of the instances for limited blocks: a thread has all the registers that it can.
inline constexpr int light_blocks = 2;

/// Whether another instance takes the block.
template <class Real, int Dim>
__device__ __forceinline__ bool is_limited(const GatherArgs<Real, Dim>& g, int block) {
    return g.light.stiffness && g.light.limited[block];
}

/// What a particle's limits are asked with.
template <class Real, int Dim>
struct LightParticle {
    Vec<Coordinate<Real>, Dim> u;
    std::uint32_t slot;
    Real mass, volume;  ///< [kg], [m3]
};

/// A particle's stencil, folded.
template <class Shape, bool Affine, class Real, int Dim>
__device__ __forceinline__ void weigh_particle(const View<Real, Dim>& v, const GatherArgs<Real, Dim>& g,
                                               const LightCell<Shape, Dim>& cell, const Vec<Coordinate<Real>, Dim>& u,
                                               std::uint32_t s, LightStencil<Real, Dim, Shape::width>& n) {
    Row<Real> stretch;
    if constexpr (Shape::sized)
        if (v.p.log_stretch) stretch = load_row(v.p.log_stretch + s);
    Real f[Dim];
#pragma unroll
    for (int a = 0; a < Dim; ++a) {
        f[a] = fraction_of<Real>(u[a]);
        Shape::weights(f[a], Shape::sized ? half_size(v, v.p.body[s], stretch, a) : Real(0), n.w[a], n.dw[a]);
    }
    fold_stencil<Shape, Affine>(cell.ghosts, g.tpic, f, Real(1), n);
}

/// rho_p h^d [kg].
template <class Real, int Dim>
__device__ __forceinline__ Real full_at(const View<Real, Dim>& v, Real mass, Real volume) {
    Real full = mass / volume;
#pragma unroll
    for (int a = 0; a < Dim; ++a) full /= v.context.inverse_cell;
    return full;
}

/// The particle's stencil, folded, and its share. Whole where nothing is to be asked.
template <class Shape, bool Affine, bool Unrolled, class Tile, class Real, int Dim>
__device__ __forceinline__ LightShare<Real, Dim> share_of(const View<Real, Dim>& v, const GatherArgs<Real, Dim>& g,
                                                          const Tile& tile, const CellMasses<Real, Dim>& masses,
                                                          const LightCell<Shape, Dim>& cell,
                                                          const LightParticle<Real, Dim>& p,
                                                          LightStencil<Real, Dim, Shape::width>& n) {
    LightShare<Real, Dim> share;
    share.whole = true;
    const Stiffness<Real> k = g.light.stiffness[v.p.body[p.slot]];
    if (Real(2) * masses.least[cell.number] >= k.full_mass) return share;
    weigh_particle<Shape, Affine>(v, g, cell, p.u, p.slot, n);
    Vec<Real, Dim> reaction = reactions<Unrolled>(
        n, masses.around[cell.number], full_at<Real, Dim>(v, p.mass, p.volume),
        [&](int at, int i, int j, int l) { return cell.is_inside(i, j, l) ? tile.inverse(cell.first + at) : Real(0); },
        [&](int at, int b) { return tile.moves(cell.first + at, b); });
    const Real per_length = g.dt * v.context.inverse_cell;
#pragma unroll
    for (int b = 0; b < Dim; ++b) reaction[b] *= per_length * per_length * k.wave * p.volume / p.mass;
    return light_share(g.light.limits, reaction, n.folded, k.dilation);
}

template <class Shape, class Real, int Dim>
__device__ __forceinline__ LightCell<Shape, Dim> cell_at(const View<Real, Dim>& v, int block,
                                                         const Vec<Coordinate<Real>, Dim>& u) {
    int at[Dim];
#pragma unroll
    for (int a = 0; a < Dim; ++a) at[a] = cell_of<Real>(u[a]);
    return {v, block, at};
}

/// What light nodes take from each thread's particle, until it has gathered: in registers it would be too much.
template <class Real, int Dim, int Width>
struct LightShared {
    LightTile<Real, Dim, Width> tile;
    CellMasses<Real, Dim> masses;
    Real seen[Dim * Dim][Team<Dim>::threads], kept[Dim * Dim][Team<Dim>::threads];
};

/// What a particle's light nodes cannot bear, to shared memory; called before it gathers. Returns whether there is
/// anything.
template <class Shape, bool Affine, class Real, int Dim>
__device__ __forceinline__ bool find_taken(const View<Real, Dim>& v, const GatherArgs<Real, Dim>& g, int block,
                                           const LightParticle<Real, Dim>& p,
                                           LightShared<Real, Dim, Shape::width>& shared) {
    const LightCell<Shape, Dim> cell = cell_at<Shape>(v, block, p.u);
    LightStencil<Real, Dim, Shape::width> n;
    const LightShare<Real, Dim> share = share_of<Shape, Affine, false>(v, g, shared.tile, shared.masses, cell, p, n);
    if (share.whole) return false;
    const auto taken = taken_gradients<Affine>(n, g.light.limits, share, [&](int at, int i, int j, int k) {
        const int place[3] = {i, j, k};
        int index[Dim];
#pragma unroll
        for (int a = 0; a < Dim; ++a) index[a] = cell.index[a] + place[a];
        const int node = cell.first + at;
        return acceleration<Real, Dim>(v.context.walls, index, shared.tile.first[node].e, shared.tile.second[node].e);
    });
    const int rank = Team<Dim>::rank();
#pragma unroll
    for (int i = 0; i < Dim * Dim; ++i) {
        shared.seen[i][rank] = taken.seen(i / Dim, i % Dim);
        if constexpr (Affine) shared.kept[i][rank] = taken.kept(i / Dim, i % Dim);
    }
    return true;
}

template <class Case>
struct LightTerm {
    static constexpr unsigned hooks = Case::light ? hook_block : 0u;
    struct Shared : SharedIf<LightTerm, Case::light, LightShared<typename Case::Real, Case::dim, Case::Shape::width>> {
    };

    MORAINE_TEAM void at_block(const auto& in, Shared& own) {
        load_light_tile<typename Case::Shape>(in.v, in.work.block, own.tile);
        weigh_cells<typename Case::Shape>(in.v, in.work.block, own.tile, own.masses);
    }

    /// gathered(): what the particle in slot s gathers; less what its light nodes cannot bear.
    template <bool Affine>
    MORAINE_TEAM auto around(const auto& in, Shared& own, std::uint32_t s, const auto& gathered) {
        constexpr int Dim = Case::dim;
        CoreRows<typename Case::Real, Dim> p;
#pragma unroll
        for (int r = 0; r < core_rows<Dim>; ++r) p.row[r] = load_row(in.v.p.core[r] + s);
        const bool any = find_taken<typename Case::Shape, Affine>(
            in.v, in.g, in.work.block, {place_of<typename Case::Real, Dim>(p), s, p.mass(), p.volume()}, own);
        asm volatile("" ::: "memory");  // nothing of it stays in registers
        auto sums = gathered();
        const int rank = Team<Dim>::rank();
#pragma unroll
        for (int i = 0; i < Dim * Dim; ++i) {
            if (any) sums.gradient[i % Dim][i / Dim] += own.seen[i][rank];
            if constexpr (Affine)
                if (any) sums.affine[i % Dim][i / Dim] += own.kept[i][rank];
        }
        return sums;
    }
};

}  // namespace moraine::gpu
