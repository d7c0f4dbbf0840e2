#pragma once
// A cell that a surface cuts: what is open of it and of its faces, and the surface in it, as the splines of its nodes
// see them. In the cell's own measure: lengths in h, from its node.
//
//   F_i = sum over faces f of n_f int_{open part of f} w_i dA,   S_i = int_Gamma w_i n dA,   M_i = int_Omega w_i dV
//
// n points out of the structure. Of a distance that is linear between its values at the cell's corners, the middle of a
// face (3-D) and of the cell, which are means: a face is the same from both of its cells, and no axis is preferred.
// sum_i M_i is the open volume, and by closure sum_i F_i = sum_i S_i: a pressure that is the same everywhere is in
// balance however roughly the surface is known. Corners nearer than `on_surface` lie on it: a surface along a face of
// cells belongs to the cells outside. Weights are folded at walls, where a cell ends at the wall.

#include "core/fluid/grid_pressure.hpp"
#include "core/structures/structure.hpp"

namespace moraine {

inline constexpr double on_surface = 1e-6;    ///< distance of a corner that lies on the surface [cells]
inline constexpr double least_volume = 1e-9;  ///< of a cell that is open at all

/// Where a cell ends, from its node [cells], and its weights.
template <int Dim>
struct CellBox {
    double end[Dim][2];
    CellBasis<double> basis[Dim];

    /// Of all 3^d nodes at s, x fastest.
    void weights(const Vec<double, Dim>& s, double* w) const {
        double x[Dim][3];
        for (int a = 0; a < Dim; ++a)
            for (int i = 0; i < 3; ++i) {
                const double* c = basis[a].value[i];
                x[a][i] = c[0] + s[a] * (c[1] + s[a] * c[2]);
            }
        int n = 0;
        each_node<Dim, 3>(
            [&](int, int i, int j, int k) { w[n++] = x[0][i] * x[1][j] * (Dim == 3 ? x[Dim - 1][k] : 1.0); });
    }
};

template <int Dim>
struct CutCell {
    static constexpr int nodes = power<Dim>(3);
    double volume = 0;          ///< open
    double inside[nodes] = {};  ///< M_i
    double weight[nodes] = {};  ///< w_ie: share of node i in the surface
    double open[2 * Dim] = {};  ///< part of its faces, by axis and end
    double area = 0;            ///< |sum_i S_i|
    Vec<double, Dim> normal{};  ///< of the surface: mean
    Vec<double, Dim> centre{};  ///< of the surface
    int structure = -1;         ///< whose surface it is
};

/// What a pressure in it acts on.
template <int Dim>
struct CutFaces {
    Vec<double, Dim> face[CutCell<Dim>::nodes]{};  ///< F_i
    Vec<double, Dim> bed[CutCell<Dim>::nodes]{};   ///< S_i
};

/// Puts one cell together from the distances at its corners.
template <int Dim>
class CellCutter {
  public:
    /// distance: at corner k, bit a of k: the upper end of axis a [cells]; faces: null where no pressure is the cell's.
    CutCell<Dim> cut(const CellBox<Dim>& box, const double* distance, CutFaces<Dim>* faces) {
        box_ = &box, faces_ = faces;
        for (int k = 0; k < corners; ++k) {
            for (int a = 0; a < Dim; ++a) corner_[k].s[a] = box.end[a][k >> a & 1];
            corner_[k].f = distance[k] > on_surface ? distance[k] : 0.0;
            if (distance[k] < 0) corner_[k].f = distance[k];
        }
        middle_ = mean(corner_, corners);
        each_face();
        close();
        return cell_;
    }

  private:
    static constexpr int nodes = CutCell<Dim>::nodes, corners = 1 << Dim;
    struct Point {
        Vec<double, Dim> s;
        double f;
        bool is_open() const { return f > 0; }
    };

    static Point mean(const Point* p, int n) {
        Point m{zero_vec<double, Dim>(), 0};
        for (int k = 0; k < n; ++k) {
            for (int a = 0; a < Dim; ++a) m.s[a] += p[k].s[a] / n;
            m.f += p[k].f / n;
        }
        return m;
    }
    /// Where the surface crosses from an open point to one that is not.
    static Point between(const Point& open, const Point& shut) {
        const double t = open.f / (open.f - shut.f);
        Point q{open.s, 0};
        for (int a = 0; a < Dim; ++a) q.s[a] += t * (shut.s[a] - open.s[a]);
        return q;
    }

    void each_face() {
        for (int a = 0; a < Dim; ++a)
            for (int side = 0; side < 2; ++side) {
                double on_face[nodes] = {};
                double& open = cell_.open[2 * a + side];
                const int b = (a + 1) % Dim, base = side << a;
                if constexpr (Dim == 2) {
                    const Point ends[2] = {corner_[base], corner_[base | 1 << b]};
                    open += add_edge(ends, faces_ ? on_face : nullptr);
                    const Point simplex[3] = {middle_, ends[0], ends[1]};
                    add_simplex(simplex);
                } else {
                    const int c = (a + 2) % Dim;
                    const Point ring[4] = {corner_[base], corner_[base | 1 << b], corner_[base | 1 << b | 1 << c],
                                           corner_[base | 1 << c]};
                    const Point centre = mean(ring, 4);
                    for (int k = 0; k < 4; ++k) {
                        const Point part[3] = {centre, ring[k], ring[(k + 1) % 4]};
                        open += add_part(part, faces_ ? on_face : nullptr);
                        const Point simplex[4] = {middle_, part[0], part[1], part[2]};
                        add_simplex(simplex);
                    }
                }
                for (int i = 0; faces_ && i < nodes; ++i) faces_->face[i][a] += side == 0 ? -on_face[i] : on_face[i];
            }
    }

    /// The open part of an edge of a cell in 2-D.
    double add_edge(const Point (&p)[2], double* sums) const {
        if (!p[0].is_open() && !p[1].is_open()) return 0;
        const Point a = p[0].is_open() ? p[0] : between(p[1], p[0]), b = p[1].is_open() ? p[1] : between(p[0], p[1]);
        const Point line[2] = {a, b};
        return integrate_line(line, sums);
    }
    /// The open part of a triangle of a face in 3-D.
    double add_part(const Point (&p)[3], double* sums) const {
        const int open = p[0].is_open() + p[1].is_open() + p[2].is_open();
        if (open == 0) return 0;
        if (open == 3) return integrate_triangle(p, 1, sums);
        int lone = 0;
        while (p[lone].is_open() != (open == 1)) ++lone;
        const Point &q = p[lone], &r = p[(lone + 1) % 3], &t = p[(lone + 2) % 3];
        const Point tip[3] = {q, open == 1 ? between(q, r) : between(r, q), open == 1 ? between(q, t) : between(t, q)};
        const double whole = open == 2 ? integrate_triangle(p, 1, sums) : 0;
        return whole + integrate_triangle(tip, open == 1 ? 1 : -1, sums);
    }

    /// The open part of a simplex, and the surface in it.
    void add_simplex(const Point (&p)[Dim + 1]) {
        int in[Dim + 1], out[Dim + 1], open = 0, shut = 0;
        for (int k = 0; k <= Dim; ++k) (p[k].is_open() ? in[open++] : out[shut++]) = k;
        if (open == 0) return;
        if (open == Dim + 1) return add_volume(p, 1);
        if (open == 1 || shut == 1) {
            const Point& tip = p[open == 1 ? in[0] : out[0]];
            Point cap[Dim + 1] = {tip};
            for (int k = 0; k < Dim; ++k) cap[k + 1] = open == 1 ? between(tip, p[out[k]]) : between(p[in[k]], tip);
            if (shut == 1) add_volume(p, 1);
            add_volume(cap, open == 1 ? 1 : -1);
            Point surface[Dim];
            for (int k = 0; k < Dim; ++k) surface[k] = cap[k + 1];
            return add_surface(surface, p[in[0]]);
        }
        if constexpr (Dim == 3) {  // two of four: a wedge
            const Point &a = p[in[0]], &b = p[in[1]];
            const Point ac = between(a, p[out[0]]), ad = between(a, p[out[1]]), bc = between(b, p[out[0]]),
                        bd = between(b, p[out[1]]);
            const Point parts[3][4] = {{a, ac, ad, b}, {ac, ad, b, bc}, {ad, b, bc, bd}};
            for (const auto& part : parts) add_volume(part, 1);
            const Point one[3] = {ac, ad, bd}, other[3] = {ac, bd, bc};
            add_surface(one, a), add_surface(other, a);
        }
    }

    void add_volume(const Point (&p)[Dim + 1], double sign) {
        if constexpr (Dim == 2) {
            cell_.volume += integrate_triangle(p, sign, cell_.inside);
        } else {
            const Vec<double, Dim> e = p[1].s - p[0].s, f = p[2].s - p[0].s, g = p[3].s - p[0].s;
            const double volume = sign * std::fabs(dot(cross(e, f), g)) / 6;
            constexpr double in = 0.5854101966249685, out = 0.1381966011250105;
            for (int q = 0; q < 4; ++q) {
                Vec<double, Dim> s = zero_vec<double, Dim>();
                for (int k = 0; k < 4; ++k)
                    for (int a = 0; a < Dim; ++a) s[a] += (k == q ? in : out) * p[k].s[a];
                double w[nodes];
                box_->weights(s, w);
                for (int i = 0; i < nodes; ++i) cell_.inside[i] += volume / 4 * w[i];
            }
            cell_.volume += volume;
        }
    }

    /// A piece of the surface; `soil`: an open point, to which the normal points.
    void add_surface(const Point (&p)[Dim], const Point& soil) {
        Vec<double, Dim> normal;
        if constexpr (Dim == 2)
            normal = {{p[1].s[1] - p[0].s[1], p[0].s[0] - p[1].s[0]}};
        else
            normal = cross(p[1].s - p[0].s, p[2].s - p[0].s);
        const double length = magnitude(normal);
        if (!(length > 0)) return;
        normal = (dot(normal, soil.s - p[0].s) < 0 ? -1 / length : 1 / length) * normal;
        const double area = Dim == 2 ? length : length / 2;
        for (const Point& q : p) cell_.centre = cell_.centre - (-area / Dim) * q.s;
        cell_.area += area;
        double on_piece[nodes] = {};
        if constexpr (Dim == 2)
            integrate_line(p, on_piece);
        else
            integrate_triangle(p, 1, on_piece);
        for (int i = 0; i < nodes; ++i) bed_[i] = bed_[i] - (-on_piece[i]) * normal;
    }

    void close() {
        if (cell_.area > 0) cell_.centre = (1 / cell_.area) * cell_.centre;
        Vec<double, Dim> all = zero_vec<double, Dim>();
        for (const Vec<double, Dim>& of_node : bed_) all = all - (-1.0) * of_node;
        cell_.area = magnitude(all);
        if (cell_.area > 0) cell_.normal = (1 / cell_.area) * all;
        for (int i = 0; i < nodes; ++i) cell_.weight[i] = cell_.area > 0 ? dot(bed_[i], cell_.normal) / cell_.area : 0;
        for (int i = 0; faces_ && i < nodes; ++i) faces_->bed[i] = bed_[i];
    }

    static Vec<double, Dim> cross(const Vec<double, Dim>& a, const Vec<double, Dim>& b) {
        Vec<double, Dim> c;
        for (int k = 0; k < 3; ++k) c[k % Dim] = a[(k + 1) % 3] * b[(k + 2) % 3] - a[(k + 2) % 3] * b[(k + 1) % 3];
        return c;
    }

    /// Adds the integrals of the weights along a line, by three points of Gauss, which are exact. Its length.
    double integrate_line(const Point (&p)[2], double* sums) const {
        const double length = magnitude(p[1].s - p[0].s);
        if (!sums) return length;
        constexpr double at[3] = {0.1127016653792583, 0.5, 0.8872983346207417},
                         share[3] = {5.0 / 18, 8.0 / 18, 5.0 / 18};
        for (int q = 0; q < 3; ++q) {
            double w[nodes];
            box_->weights(p[0].s - (-at[q]) * (p[1].s - p[0].s), w);
            for (int i = 0; i < nodes; ++i) sums[i] += share[q] * length * w[i];
        }
        return length;
    }
    /// The same over a triangle, by seven points, which are exact in a face. Its area.
    double integrate_triangle(const Point (&p)[3], double sign, double* sums) const {
        const Vec<double, Dim> e = p[1].s - p[0].s, g = p[2].s - p[0].s;
        const double square = dot(e, e) * dot(g, g) - dot(e, g) * dot(e, g);
        const double area = sign * 0.5 * std::sqrt(square > 0 ? square : 0);
        if (!sums) return area;
        constexpr double near = 0.1012865073234563, far = 0.7974269853530873, mid = 0.4701420641051151,
                         end = 0.0597158717897698;
        constexpr double at[7][2] = {{1.0 / 3, 1.0 / 3}, {near, near}, {far, near}, {near, far},
                                     {mid, mid},         {end, mid},   {mid, end}};
        for (int q = 0; q < 7; ++q) {
            double w[nodes];
            box_->weights(p[0].s - (-at[q][0]) * e - (-at[q][1]) * g, w);
            const double share = area * (q == 0 ? 0.225 : q < 4 ? 0.1259391805448271 : 0.1323941527885062);
            for (int i = 0; i < nodes; ++i) sums[i] += share * w[i];
        }
        return area;
    }

    const CellBox<Dim>* box_ = nullptr;
    CutFaces<Dim>* faces_ = nullptr;
    CutCell<Dim> cell_{};
    Vec<double, Dim> bed_[nodes]{};
    Point corner_[corners], middle_;
};

}  // namespace moraine
