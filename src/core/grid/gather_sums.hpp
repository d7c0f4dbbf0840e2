#pragma once
// The sums of a gather over the nodes of a cell, for as many of its particles as fill a register.
//
//   v_pic = sum_i w_ip v_i',   sum_i w_ip dv_i,   grad v = sum_i v_i' grad w_ip,   C of APIC (particle_update.hpp)
//
// Of the sums nothing depends on how many particles go together: quad_group.hpp. How many pay is a matter of the
// register: docs/adr/0003.

#include "core/data/processor.hpp"
#include "core/data/quad_group.hpp"
#include "core/grid/particle_update.hpp"
#include "core/grid/stencil.hpp"

namespace moraine {

/// Particles of a cell that are gathered together: as many as fill a register with quads.
template <class Real>
inline constexpr int particles_together = 2 * quad* int(sizeof(Real)) > register_bytes   ? 1
                                          : 4 * quad* int(sizeof(Real)) > register_bytes ? 2
                                                                                         : 4;

/// What a particle, or some together, took from the nodes.
template <class Quads, int Dim>
struct Gathered {
    Quads velocity;       ///< sum w v'
    Quads change;         ///< sum w dv
    Quads gradient[Dim];  ///< sum v' dw/dx_b, per axis b
    Quads affine[Dim];    ///< columns of C
};

/// One particle's part of what some took together, where it lies.
template <class T, int Dim>
struct GatheredPart {
    using Real = typename T::Scalar;
    Real* at;

    MORAINE_HD GatheredPart(Gathered<typename T::Quads, Dim>& all, int particle)
        : at(reinterpret_cast<Real*>(&all) + particle * quad) {}
    MORAINE_HD const Real* velocity() const { return at; }
    MORAINE_HD const Real* change() const { return at + stride; }
    MORAINE_HD Real* gradient(int axis) const { return at + (2 + axis) * stride; }
    MORAINE_HD Real* affine(int axis) const { return at + (2 + Dim + axis) * stride; }

  private:
    static constexpr int stride = T::count * quad;
};

template <class T, class Real, int Dim, class Shape>
MORAINE_HD Weights<Real, Dim, Shape> part_of(const Weights<typename T::Number, Dim, Shape>& all, int particle) {
    Weights<Real, Dim, Shape> n;
    for (int a = 0; a < Dim; ++a) {
        n.f[a] = T::number_of(all.f[a], particle);
        for (int i = 0; i < Shape::width; ++i) {
            n.w[a][i] = T::number_of(all.w[a][i], particle);
            n.dw[a][i] = T::number_of(all.dw[a][i], particle);
        }
    }
    return n;
}

/// Weights of the particles in `slots`.
template <class T, class Shape, class Real, int Dim>
MORAINE_HD Weights<typename T::Number, Dim, Shape> stencils(const StencilContext<Real, Dim>& context,
                                                            const ParticleView<Real, Dim>& p,
                                                            const std::uint32_t* slots) {
    using Number = typename T::Number;
    Weights<Number, Dim, Shape> n;
    for (int a = 0; a < Dim; ++a) {
        n.f[a] = T::each([&](int k) { return fraction_of<Real>(p.position[slots[k]][a]); });
        if constexpr (Shape::sized && T::count > 1) {  // the formula chooses: particle by particle
            Real w[T::count][Shape::width], dw[T::count][Shape::width];
            for (int k = 0; k < T::count; ++k)
                Shape::weights(T::number_of(n.f[a], k), gimp_half(context, p, slots[k], a), w[k], dw[k]);
            for (int i = 0; i < Shape::width; ++i) {
                n.w[a][i] = T::each([&](int k) { return w[k][i]; });
                n.dw[a][i] = T::each([&](int k) { return dw[k][i]; });
            }
        } else {
            Real half = Real(0);
            if constexpr (Shape::sized) half = gimp_half(context, p, slots[0], a);
            Shape::weights(n.f[a], Number(half), n.w[a], n.dw[a]);
        }
        for (int i = 0; i < Shape::width; ++i) n.dw[a][i] *= Number(context.inverse_cell);
    }
    return n;
}

/// nodes: of the tile, from the first of the stencil on; plain: by axis, C is the velocity gradient.
template <bool Affine, class T, class Shape, class Real, int Dim>
MORAINE_HD Gathered<typename T::Quads, Dim> sum_nodes(const Weights<typename T::Number, Dim, Shape>& n,
                                                      const Quad<Real>* nodes, const bool* plain, Real inverse_cell) {
    using Number = typename T::Number;
    using Quads = typename T::Quads;
    constexpr int width = Shape::width, side = tile_side(width), layers = Dim == 2 ? 1 : width;
    const Quads none = T::spread(Quad<Real>::zero());
    Gathered<Quads, Dim> g;
    g.velocity = g.change = none;
    for (int a = 0; a < Dim; ++a) g.gradient[a] = g.affine[a] = none;
    Number lever[Dim][width];
    if constexpr (Affine)
        for (int a = 0; a < Dim; ++a)
            affine_levers<Shape>(n.f[a], n.w[a], n.dw[a], Number(inverse_cell), plain[a], lever[a]);
    for (int k = 0; k < layers; ++k)
        for (int j = 0; j < width; ++j) {
            const Number wz = Dim == 2 ? Number(1) : n.w[Dim - 1][k];
            const Number wyz = n.w[1][j] * wz;
            const Number dyz = n.dw[1][j] * wz;
            const Quad<Real>* row = nodes + 2 * (side * (j + side * k));
            Quads across = none, along = none, change = none, levered = none;
            for (int i = 0; i < width; ++i) {
                const Quads v = T::spread(row[2 * i]);
                across = fma(n.w[0][i], v, across);
                along = fma(n.dw[0][i], v, along);
                change = fma(n.w[0][i], T::spread(row[2 * i + 1]), change);
                if constexpr (Affine) levered = fma(lever[0][i], v, levered);
            }
            g.change = fma(wyz, change, g.change);
            g.gradient[0] = fma(wyz, along, g.gradient[0]);
            if constexpr (Affine) g.affine[0] = fma(wyz, levered, g.affine[0]);
            g.velocity = fma(wyz, across, g.velocity);
            g.gradient[1] = fma(dyz, across, g.gradient[1]);
            if constexpr (Dim == 3)
                g.gradient[Dim - 1] = fma(n.w[1][j] * n.dw[Dim - 1][k], across, g.gradient[Dim - 1]);
            if constexpr (Affine) {
                g.affine[1] = fma(lever[1][j] * wz, across, g.affine[1]);
                if constexpr (Dim == 3)
                    g.affine[Dim - 1] = fma(n.w[1][j] * lever[Dim - 1][k], across, g.affine[Dim - 1]);
            }
        }
    return g;
}

}  // namespace moraine
