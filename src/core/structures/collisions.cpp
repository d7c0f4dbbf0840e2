#include "core/structures/collisions.hpp"

#include <algorithm>
#include <cmath>

#include "core/structures/structure_set.hpp"

namespace moraine {

namespace {

/// Of the smaller of two structures: overlaps are left that are no more, and points are kept that are nearer.
constexpr double slop = 2e-6, nearness = 1e-4;
/// Share of an overlap that a step takes out.
constexpr double parting = 0.2;
/// Sweeps end when none changes a velocity by more than this share of the greatest, or at the last.
constexpr double sweep_end = 1e-10;
constexpr int most_sweeps = 2000;
/// By which a sweep turns the way along which a point slides.
constexpr int most_turns = 3;

template <int N>
void add(Vec<double, N>& to, double factor, const Vec<double, N>& v) {
    for (int i = 0; i < N; ++i) to[i] += factor * v[i];
}

/// Unit vectors across a surface (0) and along it.
std::array<Vec<double, 2>, 2> frame_of(const Vec<double, 2>& n) {
    return {n, {{-n[1], n[0]}}};
}
std::array<Vec<double, 3>, 3> frame_of(const Vec<double, 3>& n) {
    int least = 0;
    for (int a = 1; a < 3; ++a)
        if (std::fabs(n[a]) < std::fabs(n[least])) least = a;
    Vec<double, 3> axis = zero_vec<double, 3>();
    axis[least] = 1;
    const Vec<double, 3> across = moment_of<3>(n, axis), along = (1 / magnitude(across)) * across;
    return {n, along, moment_of<3>(n, along)};
}

/// A unit force at an arm, and its moment.
template <int Dim>
Vec<double, CollidingBody<Dim>::axes> at_arm(const Vec<double, Dim>& force, const Vec<double, Dim>& arm) {
    Vec<double, CollidingBody<Dim>::axes> both;
    const Vec<double, moments<Dim>> moment = moment_of(arm, force);
    for (int i = 0; i < Dim; ++i) both[i] = force[i];
    for (int i = 0; i < moments<Dim>; ++i) both[Dim + i] = moment[i];
    return both;
}

/// How fast any point of a structure moves at most [m/s].
template <int Dim>
double top_speed(const Vec<double, CollidingBody<Dim>::axes>& motion, double reach) {
    double linear = 0, angular = 0;
    for (int i = 0; i < Dim; ++i) linear += motion[i] * motion[i];
    for (int i = 0; i < moments<Dim>; ++i) angular += motion[Dim + i] * motion[Dim + i];
    return std::sqrt(linear) + (angular > 0 ? std::sqrt(angular) * reach : 0.0);
}

bool is_half_space(StructureShape shape) {
    return shape == StructureShape::plane || shape == StructureShape::ground;
}

/// A closed face of the domain, as the plane that ends it.
template <int Dim>
Structure<Dim> wall_of(const Scene& scene, int face) {
    Structure<Dim> wall{};
    wall.shape = StructureShape::plane;
    wall.at = vec_of<Dim>(face % 2 ? scene.max : scene.min);
    wall.along = zero_vec<double, Dim>();
    wall.along[face / 2] = face % 2 ? -1 : 1;
    return wall;
}

}  // namespace

bool collides(const StructureSpec& s) {
    return s.motion.collision.has_value();
}

bool collide(const StructureSpec& a, const StructureSpec& b) {
    const auto moves = [](const StructureSpec& s) { return s.motion.kind == StructureMotion::free; };
    return (moves(a) || moves(b)) && (!moves(a) || collides(a)) && (!moves(b) || collides(b));
}

bool meets_structures(const WallSpec& wall) {
    return wall.kind == WallKind::no_slip || wall.kind == WallKind::free_slip || wall.kind == WallKind::friction ||
           wall.absorbs;
}

template <int Dim>
Collisions<Dim>::Collisions(const Scene& scene) : structures_(scene.structures.size()) {
    for (int a = 0; a < Dim; ++a) {
        const auto i = static_cast<std::size_t>(a);
        period_[a] = scene.periodic[i] ? scene.max[i] - scene.min[i] : 0;
    }
    for (int face = 0; face < 2 * Dim; ++face) {
        const WallSpec& wall = scene.walls[static_cast<std::size_t>(face / 2)][static_cast<std::size_t>(face % 2)];
        if (!meets_structures(wall)) continue;
        walls_.push_back(wall_of<Dim>(scene, face)), faces_.push_back(face);
    }
    const auto n = static_cast<int>(structures_), all = n + static_cast<int>(walls_.size());
    const auto spec = [&](int k) -> const StructureSpec& { return scene.structures[static_cast<std::size_t>(k)]; };
    for (int a = 0; a < n; ++a)
        for (int b = a + 1; b < all; ++b) {
            const bool wall = b >= n;
            if (wall ? spec(a).motion.kind != StructureMotion::free || !collides(spec(a)) : !collide(spec(a), spec(b)))
                continue;
            const bool swap = is_half_space(spec(a).shape);
            Pair pair{swap ? b : a, swap ? a : b, 1e300, 1e300};
            for (const int k : {a, b}) {
                if (k >= n || !collides(spec(k))) continue;
                pair.friction = std::fmin(pair.friction, spec(k).motion.collision->friction);
                pair.restitution = std::fmin(pair.restitution, spec(k).motion.collision->restitution);
            }
            pairs_.push_back(pair);
        }
}

template <int Dim>
template <class F>
void Collisions<Dim>::each_near(std::span<const Structure<Dim>> structures, std::span<const double> margins,
                                const Vec<double, 2>* corners, const F& f) const {
    constexpr int images[] = {0, 1, -1};
    for (const Pair& pair : pairs_) {
        const auto i = static_cast<std::size_t>(pair.a), j = static_cast<std::size_t>(pair.b);
        const Structure<Dim>& a = structures[i];
        Structure<Dim> b = j < structures_ ? structures[j] : walls_[j - structures_];
        const double margin = margins[i] + (j < structures_ ? margins[j] : 0.0);
        if (is_half_space(b.shape)) {
            Structure<Dim> inside = a;  // of the domain, with which ground ends
            for (int k = 0; k < Dim && b.shape == StructureShape::ground; ++k)
                if (period_[k] > 0) inside.at[k] -= period_[k] * std::rint((a.at[k] - b.at[k]) / period_[k]);
            f(inside, b, pair, 0, margin);
            continue;
        }
        const double reach = reach_of(a, corners) + reach_of(b, corners) + margin;
        const Vec<double, Dim> place = b.at;
        for (int image = 0; image < (Dim == 2 ? 9 : 27); ++image) {
            bool is_one = true;
            for (int k = 0, rest = image; k < Dim; ++k, rest /= 3) {
                is_one = is_one && (rest % 3 == 0 || period_[k] > 0);
                b.at[k] = place[k];
                if (period_[k] > 0)
                    b.at[k] += period_[k] * (std::rint((a.at[k] - place[k]) / period_[k]) + images[rest % 3]);
            }
            if (is_one && magnitude(b.at - a.at) <= reach) f(a, b, pair, image, margin);
        }
    }
}

template <int Dim>
typename Collisions<Dim>::Row Collisions<Dim>::row_of(const Pair& pair, const ContactPoint<Dim>& point,
                                                      const Structure<Dim>& a, const Structure<Dim>& b,
                                                      std::span<const CollidingBody<Dim>> bodies) const {
    Row row{};
    row.a = pair.a, row.b = pair.b;
    row.gap = point.gap;
    row.friction = pair.friction;
    const auto frame = frame_of(point.normal);
    for (int d = 0; d < Dim; ++d) {
        row.arm_a[d] = at_arm(frame[static_cast<std::size_t>(d)], point.at - a.at);
        row.arm_b[d] = at_arm(frame[static_cast<std::size_t>(d)], point.at - b.at);
        row.answer_a[d] = bodies[static_cast<std::size_t>(pair.a)].answer * row.arm_a[d];
        row.answer_b[d] = bodies[static_cast<std::size_t>(pair.b)].answer * row.arm_b[d];
    }
    for (int d = 0; d < Dim; ++d)
        for (int e = 0; e < Dim; ++e)
            row.answer(d, e) = dot(row.arm_a[d], row.answer_a[e]) + dot(row.arm_b[d], row.answer_b[e]);
    row.stick = inverse(row.answer);
    return row;
}

template <int Dim>
void Collisions<Dim>::find_rows(std::span<const Structure<Dim>> structures, std::span<CollidingBody<Dim>> bodies,
                                const Vec<double, 2>* corners, double dt) {
    std::vector<double> margins;
    for (std::size_t k = 0; k < structures_; ++k) {
        const double reach = reach_of(structures[k], corners);
        const double speed =
            std::fmax(top_speed<Dim>(bodies[k].before, reach), top_speed<Dim>(bodies[k].motion, reach));
        margins.push_back(2 * dt * speed + (std::isfinite(reach) ? nearness * reach : 0.0));
    }
    rows_.clear();
    std::vector<ContactPoint<Dim>> points;
    auto last = last_.begin();
    const auto add_rows = [&](const auto& a, const auto& b, const Pair& pair, int image, double margin) {
        points.clear();
        find_contact_points(a, b, corners, margin, points);
        for (std::size_t q = 0; q < points.size(); ++q) {
            Row row = row_of(pair, points[q], a, b, bodies);
            row.impulse = {{static_cast<int>(&pair - pairs_.data()), image, static_cast<int>(q)},
                           zero_vec<double, Dim>()};
            row.slop = slop * std::fmin(reach_of(a, corners), reach_of(b, corners));
            const auto speed = [&](const auto of) {
                return dot(row.arm_b[0], bodies[static_cast<std::size_t>(pair.b)].*of) -
                       dot(row.arm_a[0], bodies[static_cast<std::size_t>(pair.a)].*of);
            };
            const double approach = speed(&CollidingBody<Dim>::before);
            row.bound = row.gap > 0 ? -row.gap / dt : 0;
            if (pair.restitution > 0 && approach < 0 && row.gap + dt * speed(&CollidingBody<Dim>::motion) < 0)
                row.bound = std::fmax(row.bound, -pair.restitution * approach);
            while (last != last_.end() && last->place < row.impulse.place) ++last;
            if (last != last_.end() && last->place == row.impulse.place) row.impulse.value = last->value;
            rows_.push_back(row);
        }
    };
    each_near(structures, margins, corners, add_rows);
}

template <int Dim>
Vec<double, Dim> Collisions<Dim>::Row::lawful(const Vec<double, Dim>& free) const {
    if (free[0] >= bound) return zero_vec<double, Dim>();
    Vec<double, Dim> wanted = -1.0 * free;
    wanted[0] += bound;
    const Vec<double, Dim> stuck = stick * wanted;
    Vec<double, Dim> along = stuck, before = impulse.value;
    along[0] = before[0] = 0;
    if (stuck[0] >= 0 && magnitude(along) <= friction * stuck[0]) return stuck;
    if (Dim == 3 && magnitude(before) > 0) along = before;  // a sweep goes on where the one before came to
    const double size = magnitude(along);
    return sliding(free, (size > 0 ? 1 / size : 0.0) * along);
}

/// In 2-D there are two ways; in 3-D it is turned against the velocity along the surface.
template <int Dim>
Vec<double, Dim> Collisions<Dim>::Row::sliding(const Vec<double, Dim>& free, Vec<double, Dim> way) const {
    Vec<double, Dim> p;
    for (int k = 0; k < (Dim == 2 ? 1 : most_turns); ++k) {
        double across = answer(0, 0);
        for (int d = 1; d < Dim; ++d) across += friction * answer(0, d) * way[d];
        // where friction alone would hold it off (Painleve): as if it did not
        const double pressed = (bound - free[0]) / (across > 0.01 * answer(0, 0) ? across : answer(0, 0));
        p = friction * pressed * way;
        p[0] = pressed;
        if (Dim == 2) break;
        Vec<double, Dim> next = p - (1 / (answer(1, 1) + answer(Dim - 1, Dim - 1))) * (free - (-1.0) * (answer * p));
        next[0] = 0;
        const double size = magnitude(next);
        if (size > 0) way = (1 / size) * next;
    }
    return p;
}

/// Until all rows hold of the motions or ways of the bodies, which have the rows' impulses in them.
template <int Dim>
void Collisions<Dim>::sweep(std::span<CollidingBody<Dim>> bodies,
                            Vec<double, CollidingBody<Dim>::axes> CollidingBody<Dim>::*of, double enough) {
    for (int k = 0; k < most_sweeps; ++k) {
        double change = 0;
        for (std::size_t q = 0; q < rows_.size(); ++q) {
            Row& row = rows_[k % 2 ? rows_.size() - 1 - q : q];
            auto &a = bodies[static_cast<std::size_t>(row.a)].*of, &b = bodies[static_cast<std::size_t>(row.b)].*of;
            Vec<double, Dim>& own = row.impulse.value;
            Vec<double, Dim> free = -1.0 * (row.answer * own);
            for (int d = 0; d < Dim; ++d) free[d] += dot(row.arm_b[d], b) - dot(row.arm_a[d], a);
            const Vec<double, Dim> lawful = row.lawful(free), more = lawful - own;
            own = lawful;
            for (int d = 0; d < Dim; ++d) {
                add(b, more[d], row.answer_b[d]), add(a, -more[d], row.answer_a[d]);
                change = std::fmax(change, std::fabs(more[d]) * row.answer(d, d));
            }
        }
        if (change <= enough) return;
    }
}

/// Takes overlaps out by ways; the impulses of the rows are those of the ways from here on.
template <int Dim>
void Collisions<Dim>::part(std::span<CollidingBody<Dim>> bodies, double dt) {
    double deepest = 0;
    for (Row& row : rows_) {
        const Vec<double, CollidingBody<Dim>::axes>&a = bodies[static_cast<std::size_t>(row.a)].motion,
                          &b = bodies[static_cast<std::size_t>(row.b)].motion;
        const double gap = row.gap + dt * (dot(row.arm_b[0], b) - dot(row.arm_a[0], a));
        deepest = std::fmax(deepest, -row.gap - row.slop);
        row.bound = row.gap < -row.slop ? parting * (-row.gap - row.slop) : -std::fmax(0.0, gap);
        row.friction = 0;
        row.impulse.value = zero_vec<double, Dim>();
    }
    if (deepest > 0) sweep(bodies, &CollidingBody<Dim>::way, 1e-3 * parting * deepest);
}

template <int Dim>
void Collisions<Dim>::solve(std::span<const Structure<Dim>> structures, std::vector<CollidingBody<Dim>>& bodies,
                            const Vec<double, 2>* corners, double dt) {
    bodies.resize(structures_ + walls_.size());
    find_rows(structures, bodies, corners, dt);
    last_.clear();
    if (rows_.empty()) return;
    double fastest = 0;
    for (Row& row : rows_) {
        for (const int k : {row.a, row.b}) {
            const auto i = static_cast<std::size_t>(k);
            const double reach = i < structures_ ? reach_of(structures[i], corners) : 0.0;
            for (const auto& of : {bodies[i].before, bodies[i].motion})
                fastest = std::fmax(fastest, top_speed<Dim>(of, std::isfinite(reach) ? reach : 0.0));
        }
    }
    for (const Row& row : rows_)
        for (int d = 0; d < Dim; ++d) {
            add(bodies[static_cast<std::size_t>(row.b)].motion, row.impulse.value[d], row.answer_b[d]);
            add(bodies[static_cast<std::size_t>(row.a)].motion, -row.impulse.value[d], row.answer_a[d]);
        }
    sweep(bodies, &CollidingBody<Dim>::motion, sweep_end * fastest);
    for (const Row& row : rows_) {
        for (int d = 0; d < Dim; ++d) {
            add(bodies[static_cast<std::size_t>(row.b)].impulse, row.impulse.value[d], row.arm_b[d]);
            add(bodies[static_cast<std::size_t>(row.a)].impulse, -row.impulse.value[d], row.arm_a[d]);
        }
        last_.push_back(row.impulse);
    }
    part(bodies, dt);
}

template <int Dim>
typename Collisions<Dim>::Overlap Collisions<Dim>::worst_overlap(std::span<const Structure<Dim>> structures,
                                                                 const Vec<double, 2>* corners) const {
    Overlap worst;
    std::vector<ContactPoint<Dim>> points;
    const std::vector<double> margins(structures_);
    each_near(structures, margins, corners, [&](const auto& a, const auto& b, const Pair& pair, int, double) {
        points.clear();
        find_contact_points(a, b, corners, 0.0, points);
        const auto n = static_cast<int>(structures_);
        for (const ContactPoint<Dim>& point : points) {
            const double depth = -point.gap;
            if (depth <= worst.depth || depth <= slop * std::fmin(reach_of(a, corners), reach_of(b, corners))) continue;
            worst = {pair.a, pair.b, -1, depth};
            if (pair.b >= n) worst.wall = faces_[static_cast<std::size_t>(pair.b - n)];
        }
    });
    return worst;
}

template <int Dim>
std::vector<double> Collisions<Dim>::stored() const {
    std::vector<double> all;
    for (const ContactImpulse<Dim>& impulse : last_) {
        all.insert(all.end(), impulse.place.begin(), impulse.place.end());
        all.insert(all.end(), impulse.value.e, impulse.value.e + Dim);
    }
    return all;
}

template <int Dim>
bool Collisions<Dim>::restore(const std::vector<double>& all) {
    constexpr std::size_t width = 3 + Dim;
    if (all.size() % width != 0) return false;
    last_.clear();
    for (auto from = all.begin(); from != all.end(); from += width) {
        ContactImpulse<Dim> one;
        for (std::size_t k = 0; k < 3; ++k) {
            const double number = from[static_cast<std::ptrdiff_t>(k)];
            if (!(number >= 0 && number < 1e9)) return false;
            one.place[k] = static_cast<int>(number);
        }
        for (int d = 0; d < Dim; ++d) one.value[d] = from[3 + d];
        if (!(one.value[0] >= 0) || (!last_.empty() && !(last_.back().place < one.place))) return false;
        last_.push_back(one);
    }
    return true;
}

template class Collisions<2>;
template class Collisions<3>;

}  // namespace moraine
