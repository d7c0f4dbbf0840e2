#pragma once
// Where the surfaces of all structures cut the grid, and what is open beside them: of cells and of nodes, by place
// alone. Cells and nodes are asked for one by one, by threads together, and kept; where a structure moves all is
// forgotten in each step.
//
//   c_i = sum over cells of M_i: what a node can hold, of a full one            (cut_cell.hpp)
//
// The distance of a point is the least of all structures, and the surface in a cell belongs to the one that is nearest
// to its middle. A node that lies so deep that it can hold next to nothing, c_i < c* = 0.03, takes part in the surface
// but has no particle that feels it: it is a slave of the two nodes along a grid direction, an axis or a diagonal
// towards the soil, of which the first holds most:  v = 2 v_1 - v_2,  share f = clamp((c* - c_i) / (0.67 c*)).

#include <deque>
#include <mutex>

#include "core/structures/contact_field.hpp"
#include "core/surfaces/cut_cell.hpp"
#include "core/surfaces/place_table.hpp"
#include "core/surfaces/surface_node.hpp"

namespace moraine {

template <class Real, int Dim>
Walls<double, Dim> doubled(const Walls<Real, Dim>& walls) {
    Walls<double, Dim> w{};
    for (int a = 0; a < Dim; ++a)
        for (int s = 0; s < 2; ++s)
            w.plane[a][s] = walls.plane[a][s], w.kind[a][s] = walls.kind[a][s], w.fold[a][s] = walls.fold[a][s];
    return w;
}

template <class Real, int Dim>
NodeCapacity<double, Dim> doubled(const NodeCapacity<Real, Dim>& ends) {
    NodeCapacity<double, Dim> e{};
    for (int a = 0; a < Dim; ++a)
        for (int s = 0; s < 2; ++s)
            e.plane[a][s] = ends.plane[a][s], e.on[a][s] = double(ends.on[a][s]),
            e.next[a][s] = double(ends.next[a][s]);
    return e;
}

/// What is known of a cell.
template <int Dim>
struct CellState {
    CellPart part;
    const CutCell<Dim>* cut;     ///< null: it is not cut
    const CutFaces<Dim>* faces;  ///< null: or pressures are the particles'
};

/// What threads have found.
template <int Dim>
class SurfaceFinds {
  public:
    PlaceStore<CellState<Dim>, Dim> part{};
    PlaceStore<double, Dim> capacity{};
    PlaceStore<SurfaceNode<Dim>, Dim> node{};
    const bool has_pressures;  ///< those of cells are the grid's

    explicit SurfaceFinds(bool pressures) : has_pressures(pressures) {}
    CellState<Dim> keep(const CutCell<Dim>& cut, const CutFaces<Dim>& faces) {
        const std::lock_guard hold(mutex_);
        if (has_pressures) faces_.push_back(faces);
        cut_.push_back(cut);
        return {CellPart::cut, &cut_.back(), has_pressures ? &faces_.back() : nullptr};
    }
    /// By one thread; whose tables forget, too.
    void forget() { part.forget(), capacity.forget(), node.forget(), cut_.clear(), faces_.clear(); }

  private:
    std::mutex mutex_;
    std::deque<CutCell<Dim>> cut_;  // who is cut stays in place
    std::deque<CutFaces<Dim>> faces_;
};

/// A thread's way to them.
template <int Dim>
class SurfaceGeometry {
  public:
    using Place = Vec<std::int32_t, Dim>;

    explicit SurfaceGeometry(SurfaceFinds<Dim>& finds)
        : finds_(&finds), part_(finds.part), capacity_(finds.capacity), node_(finds.node) {}

    /// What it is of; the field's structures may have moved.
    template <class Real>
    void begin(const ContactField<Dim>& field, const Walls<Real, Dim>& walls, const NodeCapacity<Real, Dim>& ends) {
        field_ = field, walls_ = doubled(walls), ends_ = doubled(ends);
    }
    /// The finds have been forgotten.
    void forget() { part_.forget(), capacity_.forget(), node_.forget(); }
    bool has_pressures() const { return finds_->has_pressures; }

    CellPart part(const Place& node) { return state_of(node).part; }
    /// Of a cell that is cut.
    const CutCell<Dim>& cut(const Place& node) { return *state_of(node).cut; }
    const CutFaces<Dim>* faces(const Place& node) { return state_of(node).faces; }

    double distance(const Vec<double, Dim>& node, int* nearest = nullptr) const {
        return beside(node, nearest).distance / field_.cell;
    }

    const SurfaceNode<Dim>& node(const Place& place) {
        return node_.at(place, [&] { return find_node(place); });
    }

    /// Sum of f |c| of a node over slaves other than that one, of which each counts by the root of what it holds over
    /// what that one holds: their masses go with it, so that who holds next to nothing does not slow the others.
    double followed_beside(const Place& place, const Place& slave) {
        const double own = held_by(node(slave).capacity);
        double sum = weight_beside(place, slave, 1, own, nullptr);
        for (int code = 0; code < CutCell<Dim>::nodes; ++code) {
            Place one = place, two = place;
            int step[Dim];
            for (int a = 0, rest = code; a < Dim; ++a, rest /= 3)
                step[a] = rest % 3 - 1, one[a] -= step[a], two[a] -= 2 * step[a];
            if (2 * code + 1 == CutCell<Dim>::nodes) continue;
            sum += weight_beside(one, slave, 2, own, step) + weight_beside(two, slave, 1, own, step);
        }
        return sum;
    }

    CellBox<Dim> box(const Place& node) const {
        CellBox<Dim> box;
        for (int a = 0; a < Dim; ++a) {
            box.end[a][0] = -0.5, box.end[a][1] = 0.5;
            for (int s = 0; s < 2; ++s)
                if (node[a] == ends_.plane[a][s] && ends_.on[a][s] < 1) box.end[a][s] = 0;
            box.basis[a] = cell_basis<double>(walls_.ghosts(a, node[a] - 1, 3));
        }
        return box;
    }

  private:
    using State = CellState<Dim>;

    static constexpr double least_held = 1e-4 * slave_capacity;  ///< who holds less has no particle

    static double held_by(double capacity) { return capacity > least_held ? capacity : least_held; }
    /// f |c| of a slave beside another one, if it is one and follows in this direction; step: null: in any.
    double weight_beside(const Place& place, const Place& other, int c, double own, const int* step) {
        const SurfaceNode<Dim>& n = node(place);
        bool counts = n.slaved > 0 && n.capacity > least_held, same = true;
        for (int a = 0; a < Dim; ++a) {
            counts = counts && (!step || n.to[a] == step[a]);
            same = same && place[a] == other[a];
        }
        return counts && !same ? c * n.slaved * std::sqrt(n.capacity / own) : 0.0;
    }

    Surface<Dim> beside(const Vec<double, Dim>& node, int* nearest) const {
        Surface<Dim> least{1e300, last_axis<Dim>()};
        if (nearest) *nearest = -1;
        for (int k = 0; k < field_.count; ++k) {
            const Structure<Dim>& s = field_.structure[k];
            Vec<double, Dim> x;
            for (int a = 0; a < Dim; ++a) x[a] = field_.origin[a] + field_.cell * node[a];
            const Surface<Dim> at = surface(s, field_.corners, image_near(field_, s, x));
            if (!(at.distance < least.distance)) continue;
            least = at;
            if (nearest) *nearest = k;
        }
        return least;
    }

    SurfaceNode<Dim> find_node(const Place& place) {
        SurfaceNode<Dim> n{};
        Vec<double, Dim> at;
        for (int a = 0; a < Dim; ++a) at[a] = place[a];
        const Surface<Dim> s = beside(at, &n.structure);
        n.distance = s.distance / field_.cell;
        n.normal = s.normal;
        n.capacity = capacity(place);
        if (n.distance > 0 || n.distance < -free_depth || n.capacity >= slave_capacity) return n;
        find_master(place, n);
        return n;
    }

    bool is_outside(const Place& node) const {
        for (int a = 0; a < Dim; ++a)
            for (int s = 0; s < 2; ++s)
                if (ends_.on[a][s] < 1 && (s == 0 ? node[a] < ends_.plane[a][0] : node[a] > ends_.plane[a][1]))
                    return true;
        return false;
    }

    const State& state_of(const Place& node) {
        return part_.at(node, [&] { return look(node); });
    }
    State look(const Place& node) {
        if (is_outside(node)) return {CellPart::solid, nullptr, nullptr};
        Vec<double, Dim> middle;
        for (int a = 0; a < Dim; ++a) middle[a] = node[a];
        const double away = distance(middle), reach = Dim == 2 ? 0.7072 : 0.8661;
        if (away > reach) return {CellPart::open, nullptr, nullptr};
        if (away < -reach) return {CellPart::solid, nullptr, nullptr};
        const CellBox<Dim> of_cell = box(node);
        double corner[1 << Dim];
        int open = 0;
        for (int k = 0; k < 1 << Dim; ++k) {
            Vec<double, Dim> x = middle;
            for (int a = 0; a < Dim; ++a) x[a] += of_cell.end[a][k >> a & 1];
            corner[k] = distance(x);
            open += corner[k] > on_surface;
        }
        if (open == 1 << Dim) return {CellPart::open, nullptr, nullptr};
        if (open == 0) return {CellPart::solid, nullptr, nullptr};
        CutFaces<Dim> faces;
        CutCell<Dim> cell = CellCutter<Dim>().cut(of_cell, corner, has_pressures() ? &faces : nullptr);
        if (cell.volume < least_volume) return {CellPart::solid, nullptr, nullptr};
        distance(middle - (-1.0) * cell.centre, &cell.structure);
        return finds_->keep(cell, faces);
    }

    double capacity(const Place& place) {
        return capacity_.at(place, [&] { return find_capacity(place); });
    }
    double find_capacity(const Place& place) {
        if (is_outside(place)) return 0;
        double sum = 0, all = 1;
        bool open = true;
        for (int a = 0; a < Dim; ++a) all *= ends_.along(a, place[a]);
        for (int k = 0; k < CutCell<Dim>::nodes; ++k) {
            Place cell = place;
            int own = 0, rest = k, stride = 1;
            double inside = 1;
            for (int a = 0; a < Dim; ++a, rest /= 3, stride *= 3) {
                const int o = rest % 3 - 1;
                cell[a] += o;
                own += stride * (1 - o);
                inside *= o == 0 ? 2.0 / 3 : 1.0 / 6;
            }
            const CellPart is = part(cell);
            open = open && (is == CellPart::open || is_outside(cell));
            if (is == CellPart::cut) sum += cut(cell).inside[own];
            if (is == CellPart::open) sum += ends_are_far(cell) ? inside : weight_in(cell, own);
        }
        return open ? all : sum;
    }
    bool ends_are_far(const Place& cell) const {
        for (int a = 0; a < Dim; ++a)
            for (int s = 0; s < 2; ++s)
                if (ends_.on[a][s] < 1 && std::abs(cell[a] - ends_.plane[a][s]) < 2) return false;
        return true;
    }
    /// M_i of an open cell beside a wall.
    double weight_in(const Place& cell, int own) const {
        const CellBox<Dim> b = box(cell);
        double product = 1;
        for (int a = 0, rest = own; a < Dim; ++a, rest /= 3) {
            const double* c = b.basis[a].value[rest % 3];
            const auto at = [&](double s) { return s * (c[0] + s * (c[1] / 2 + s * c[2] / 3)); };
            product *= at(b.end[a][1]) - at(b.end[a][0]);
        }
        return product;
    }

    void find_master(const Place& place, SurfaceNode<Dim>& n) {
        double best = 0;
        for (int way = 1; way < 1 << Dim; ++way) {
            Place to = place;
            bool goes = true;
            int step[Dim];
            for (int a = 0; a < Dim; ++a) {
                const int towards = n.normal[a] > 0.05 ? 1 : n.normal[a] < -0.05 ? -1 : 0;
                step[a] = way >> a & 1 ? towards : 0;
                goes = goes && (towards != 0 || !(way >> a & 1));
                to[a] += step[a];
            }
            if (!goes) continue;
            const double c = capacity(to);
            if (!(c > best)) continue;
            best = c;
            for (int a = 0; a < Dim; ++a) n.to[a] = step[a];
        }
        const double share = (slave_capacity - n.capacity) / (0.67 * slave_capacity);
        n.slaved = best > 0 ? (share < 1 ? share : 1) : 0;
    }

    ContactField<Dim> field_{};
    Walls<double, Dim> walls_{};
    NodeCapacity<double, Dim> ends_{};
    SurfaceFinds<Dim>* finds_;
    PlaceTable<State, Dim> part_;
    PlaceTable<double, Dim> capacity_;
    PlaceTable<SurfaceNode<Dim>, Dim> node_;
};

}  // namespace moraine
