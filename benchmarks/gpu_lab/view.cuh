#pragma once
// What every kernel of the laboratory sees: topology, particles, lists, tiles, nodes. Plain pointers, by value.
//
// A particle is four rows of four reals, one column each, so that a row is one or two 16-byte accesses:
//   Place (x y z mass)   Motion (v V)   Normal (sxx syy szz lnJ)   Shear (sxy syz szx xi)
// A row of a double is one 32-byte sector: a particle read out of order costs no more bytes.
// Block, cell, tile, corner and neighbour numbers are those of src/core/block.hpp.

#include <cstdint>
#include <cstdio>
#include <cstdlib>

#include "core/block.hpp"
#include "core/material/von_mises.hpp"
#include "core/position.hpp"
#include "core/quad.hpp"
#include "core/shape.hpp"
#include "core/strain.hpp"
#include "core/stress.hpp"
#include "core/walls.hpp"

namespace lab {

using namespace moraine;

inline constexpr int side = tile_side(Quadratic::width);
inline constexpr int tile_nodes = side * side * side;
inline constexpr int cells = Block<3>::cells;
inline constexpr int offsets = Block<3>::offsets;
inline constexpr int bounds = cells + 1;   ///< cell bounds stored per block
inline constexpr int exits = offsets + 1;  ///< leaver bounds stored per block

template <class Real>
struct alignas(4 * sizeof(Real)) Place {
    Coordinate<Real> u[3];
    Real mass;
};
template <class Real>
struct alignas(4 * sizeof(Real)) Row {
    Real e[3];
    Real w;
};

template <class Real>
struct Columns {
    Place<Real>* place;
    Row<Real>* motion;  ///< velocity, volume
    Row<Real>* normal;  ///< normal stress, ln J
    Row<Real>* shear;   ///< shear stress xy yz zx, plastic shear strain
    std::uint64_t* id;
    std::uint16_t* body;
};

struct Outcome {
    double work;
    float speed2;   ///< largest |v|^2
    float modulus;  ///< largest M J: with speed2 a bound of the signal speed, without a root per particle
    float moved;
    std::uint32_t faults;
};

template <class Real>
struct View {
    int blocks;
    int node_blocks;
    const std::int32_t* neighbour;         ///< blocks x 27, -1 none
    const std::int32_t* node_block;        ///< blocks x 8
    const std::int32_t* source;            ///< node blocks x 8, -1 none
    const Vec<std::int32_t, 3>* position;  ///< node blocks; the first `blocks` are the blocks
    const std::uint8_t* border;            ///< node blocks

    Columns<Real> p;
    const std::uint32_t* first;       ///< blocks + 1
    const std::uint32_t* cell_first;  ///< blocks x 65
    const std::uint32_t* slot;
    std::uint16_t* moves;    ///< per list entry
    std::uint32_t* changed;  ///< bit per list entry: it changed its cell. Words of block b start at first[b] / 32 + b

    Quad<Real>* tiles;  ///< blocks x 216 x 2
    Quad<Real>* nodes;  ///< node blocks x 64 x 2
    Outcome* outcome;   ///< blocks

    Walls<Real, 3> walls;
    Real inverse_cell;
    Real inverse_density;
    Real mass_cutoff;
    Real flip;
    const double* dt;  ///< on the device
    Vec<Real, 3> gravity;
    VonMises<Real> law;
    int ahead;       ///< how many blocks ahead rows are asked for into L2; 0: not at all
    bool backwards;  ///< blocks run in reverse: the answer must not change

    __device__ int chosen() const { return chosen(int(blockIdx.x), blocks); }
    __device__ int chosen(int item, int n) const { return backwards ? n - 1 - item : item; }
};

/// A warp at entries k - lane .. of a block's list notes who changed cell; called by the lanes with k < end.
template <class Real>
__device__ __forceinline__ void note_changed(const View<Real>& v, int b, std::uint32_t begin, std::uint32_t end,
                                             std::uint32_t k, bool changed) {
    const std::uint32_t lane = threadIdx.x & 31, here = end - (k - lane);
    const unsigned bits = __ballot_sync(here >= 32 ? 0xffffffffu : (1u << here) - 1, changed);
    if (lane == 0) v.changed[begin / 32 + std::uint32_t(b) + (k - begin) / 32] = bits;
}

/// Copies one row by 16-byte accesses.
template <class T>
__device__ __forceinline__ T load_row(const T* from) {
    T row;
    const uint4* f = reinterpret_cast<const uint4*>(from);
    uint4* t = reinterpret_cast<uint4*>(&row);
#pragma unroll
    for (int i = 0; i < int(sizeof(T) / 16); ++i) t[i] = f[i];
    return row;
}
template <class T>
__device__ __forceinline__ void store_row(T* to, const T& row) {
    uint4* t = reinterpret_cast<uint4*>(to);
    const uint4* f = reinterpret_cast<const uint4*>(&row);
#pragma unroll
    for (int i = 0; i < int(sizeof(T) / 16); ++i) t[i] = f[i];
}

inline void check(cudaError_t e, const char* what) {
    if (e == cudaSuccess) return;
    std::fprintf(stderr, "%s failed (%s). Is the device in order?\n", what, cudaGetErrorString(e));
    std::exit(4);
}

}  // namespace lab
