#include "core/structures/structure_set.hpp"

#include <cmath>

#include "core/grid/shape.hpp"
#include "core/material/laws.hpp"
#include "core/structures/ground.hpp"

namespace moraine {

namespace {

/// The middle of a polygon's box, or of its area where it turns, and its corners about that, counter-clockwise.
Vec<double, 2> centred_corners(const StructureSpec& spec, std::vector<Vec<double, 2>>& corners) {
    const std::vector<std::array<double, 2>>& points = spec.points;
    Vec<double, 2> low{{points[0][0], points[0][1]}}, high = low;
    double twice_area = 0;
    for (std::size_t i = 0, j = points.size() - 1; i < points.size(); j = i++) {
        for (int a = 0; a < 2; ++a) {
            low[a] = std::min(low[a], points[i][static_cast<std::size_t>(a)]);
            high[a] = std::max(high[a], points[i][static_cast<std::size_t>(a)]);
        }
        twice_area += points[j][0] * points[i][1] - points[i][0] * points[j][1];
    }
    const Vec<double, 2> middle =
        turns(spec.motion) ? centre_of_mass<2>(spec) : Vec<double, 2>{{(low[0] + high[0]) / 2, (low[1] + high[1]) / 2}};
    const std::size_t first = corners.size();
    for (const auto& p : points) corners.push_back({{p[0] - middle[0], p[1] - middle[1]}});
    if (twice_area < 0) std::reverse(corners.begin() + static_cast<std::ptrdiff_t>(first), corners.end());
    return middle;
}

/// Distances of the ground are bounds from here on [cells]: contact and gaps look at nothing further off.
constexpr double ground_reach = 2;

/// Parts of a polygon whose distances differ by less are equally near [cells]: more than rounding at coordinates of a
/// million cells, less than contact can tell.
constexpr double polygon_tie = 1e-6;

/// Structure::cap.
double cap_of(const Scene& scene, const StructureSpec& spec, double xi, double su) {
    return spec.law == InterfaceLaw::voellmy ? spec.density * magnitude(vec_of<3>(scene.gravity)) / xi
                                             : spec.alpha * su;
}

template <int Dim>
void place_ground(const Scene& scene, const StructureSpec& spec, Structure<Dim>& s,
                  std::vector<Vec<double, 2>>& corners) {
    s.first_corner = static_cast<int>(corners.size());
    corners.insert(corners.end(), spec.ground->table.begin(), spec.ground->table.end());
    s.radius = ground_reach * scene.cell;
    if (!spec.ground->friction.empty()) {
        append_bed(*spec.ground, spec.ground->friction, corners);
        s.corners |= bed_friction;
    }
    const std::vector<double>& varies = spec.law == InterfaceLaw::voellmy ? spec.ground->xi : spec.ground->su;
    if (!varies.empty()) {
        std::vector<double> caps;
        for (double value : varies)
            caps.push_back(spec.law == InterfaceLaw::voellmy ? cap_of(scene, spec, value, 0)
                                                             : cap_of(scene, spec, 0, value));
        append_bed(*spec.ground, caps, corners);
        s.corners |= bed_cap;
    }
    const Vec<double, Dim> low = vec_of<Dim>(scene.min), high = vec_of<Dim>(scene.max);
    s.at = low - (-0.5) * (high - low);  // periodic images are those inside the domain
    s.at[Dim - 1] = 0;
}

/// The value of a structure at the start; the corners of a polygon are appended.
template <int Dim>
Structure<Dim> structure_of(const Scene& scene, const StructureSpec& spec, std::vector<Vec<double, 2>>& corners) {
    Structure<Dim> s{};
    s.shape = spec.shape;
    s.radius = spec.radius;
    s.law = spec.law;
    s.follows_soil = spec.soil_su;
    s.friction = spec.friction;
    s.cap = cap_of(scene, spec, spec.xi, spec.su);
    s.velocity = zero_vec<double, Dim>();
    s.turns = turns(spec.motion);
    s.turn = identity<double, Dim>();
    s.spin = zero_vec<double, moments<Dim>>();
    const Vec<double, Dim> from = vec_of<Dim>(spec.from), to = vec_of<Dim>(spec.to);
    const Vec<double, Dim> low = vec_of<Dim>(spec.min), high = vec_of<Dim>(spec.max);
    switch (spec.shape) {
        case StructureShape::plane: {
            const Vec<double, Dim> normal = vec_of<Dim>(spec.normal);
            s.at = vec_of<Dim>(spec.point);
            s.along = (1 / magnitude(normal)) * normal;
            break;
        }
        case StructureShape::sphere:
            s.at = vec_of<Dim>(spec.center);
            break;
        case StructureShape::cylinder:
        case StructureShape::capsule:
            s.at = from - (-0.5) * (to - from);
            s.half = 0.5 * magnitude(to - from);
            s.along = (0.5 / s.half) * (to - from);
            break;
        case StructureShape::box:
            s.at = low - (-0.5) * (high - low);
            s.along = 0.5 * (high - low);
            break;
        case StructureShape::polygon: {
            s.first_corner = static_cast<int>(corners.size());
            s.radius = polygon_tie * scene.cell;
            const Vec<double, 2> middle = centred_corners(spec, corners);
            s.corners = static_cast<int>(corners.size()) - s.first_corner;
            s.at = zero_vec<double, Dim>();
            s.at[0] = middle[0], s.at[1] = middle[1];
            if constexpr (Dim == 3) s.at[2] = (low[2] + high[2]) / 2, s.along[2] = (high[2] - low[2]) / 2;
            break;
        }
        case StructureShape::ground:
            place_ground(scene, spec, s, corners);
            break;
    }
    return s;
}

/// [rad/s]
template <int Dim>
Vec<double, moments<Dim>> angular_velocity_of(const MotionSpec& m) {
    Vec<double, moments<Dim>> w = zero_vec<double, moments<Dim>>();
    for (std::size_t a = 0; a < m.angular_velocity.size(); ++a) w[static_cast<int>(a)] = m.angular_velocity[a];
    return w;
}

template <int Dim>
Vec<double, CollidingBody<Dim>::axes> motion_of(const StructureState<Dim>& state) {
    Vec<double, CollidingBody<Dim>::axes> motion;
    for (int a = 0; a < Dim; ++a) motion[a] = state.velocity[a];
    for (int a = 0; a < moments<Dim>; ++a) motion[Dim + a] = state.spin[a];
    return motion;
}

template <int Dim>
void leave_overlaps(const CollidingBody<Dim>& of, bool turns, StructureState<Dim>& state) {
    Vec<double, moments<Dim>> turn;
    for (int a = 0; a < Dim; ++a) state.displacement[a] += of.way[a];
    for (int a = 0; a < moments<Dim>; ++a) turn[a] = of.way[Dim + a];
    if (turns) state.turned = normalised(rotation_by(turn) * state.turned);
}

/// Of the bodies of a scene in which an interface follows the soil.
std::vector<SoilShare> soil_shares(const Scene& scene, double greatest) {
    std::vector<SoilShare> shares;
    for (const BodySpec& body : scene.bodies) {
        const MaterialSpec& m = scene.materials[static_cast<std::size_t>(body.material)];
        const LawInfo& law = *find_law(m.law);
        SoilShare& own = shares.emplace_back();
        own.scalar = scalar_named(law, m.keeps_strength ? "strength" : "su");
        own.share =
            (own.scalar < 0 ? m.parameters[static_cast<std::size_t>(parameter_named(law, "su"))] : 1) / greatest;
    }
    return shares;
}

}  // namespace

template <int Dim>
StructureSet<Dim>::StructureSet(const Scene& scene) : scene_(scene), states_(scene.structures.size()) {
    bodies_.resize(states_.size());
    for (const StructureSpec& spec : scene.structures) {
        values_.push_back(structure_of<Dim>(scene, spec, corners_));
        start_.push_back(values_.back().at);
        if (spec.soil_su) soil_ = soil_shares(scene, spec.su);
        any_free_ = any_free_ || spec.motion.kind == StructureMotion::free;
        any_moves_ = any_moves_ || spec.motion.kind != StructureMotion::fixed;
        any_turns_ = any_turns_ || turns(spec.motion);
    }
    if (std::any_of(scene.structures.begin(), scene.structures.end(), collides)) {
        collisions_.emplace(scene);
        colliding_.resize(states_.size());
    }
    for (std::size_t k = 0; k < states_.size(); ++k) {
        const MotionSpec& motion = spec(k).motion;
        StructureState<Dim>& state = states_[k];
        if (motion.kind != StructureMotion::free) continue;
        state.velocity = state.carried = vec_of<Dim>(motion.velocity);
        if (!motion.turns) continue;
        bodies_[k] = rigid_body<Dim>(spec(k));
        state.spin = angular_velocity_of<Dim>(motion);
        state.carried_spin = bodies_[k].inertia(state.turned) * state.spin;
    }
}

template <int Dim>
void StructureSet<Dim>::begin_step(double time, double dt, const std::array<double, Dim>& gravity,
                                   std::span<const StructureSums<Dim>> pending, const Quantum& quantum,
                                   std::span<const TurningSums<Dim>> turning) {
    for (std::size_t k = 0; k < colliding_.size(); ++k) colliding_[k] = {motion_of(states_[k]), {}, {}, {}, {}};
    for (std::size_t k = 0; k < values_.size(); ++k) {
        const MotionSpec& motion = spec(k).motion;
        if (motion.kind != StructureMotion::free)
            prescribe(k, time, dt);
        else if (motion.turns)
            begin_turning(k, dt, gravity, pending[k], turning[k], quantum);
        else
            begin_free(k, dt, gravity, pending[k], quantum);
    }
    if (collisions_) collide(dt, pending, quantum, turning);
    for (std::size_t k = 0; k < values_.size(); ++k) {
        StructureState<Dim>& state = states_[k];
        if (!spec(k).motion.turns) continue;
        const Vec<double, moments<Dim>> L = bodies_[k].inertia(state.turned) * state.spin;
        state.spin = (1 / dt) * vector_of(bodies_[k].turn(state.turned, L, dt));
    }
    place();
}

template <int Dim>
void StructureSet<Dim>::collide(double dt, std::span<const StructureSums<Dim>> pending, const Quantum& quantum,
                                std::span<const TurningSums<Dim>> turning) {
    place();
    colliding_.resize(values_.size(), CollidingBody<Dim>{});
    for (std::size_t k = 0; k < values_.size(); ++k) {
        colliding_[k].motion = motion_of(states_[k]);
        if (spec(k).motion.kind != StructureMotion::free)
            colliding_[k].before = colliding_[k].motion;
        else if (collides(spec(k)))
            colliding_[k].answer = answer_of(k, pending[k], quantum, turning);
    }
    collisions_->solve(values_, colliding_, corners_.data(), dt);
    colliding_.resize(values_.size());
    for (std::size_t k = 0; k < values_.size(); ++k)
        if (spec(k).motion.kind == StructureMotion::free) take_collision(k);
}

template <int Dim>
Mat<double, CollidingBody<Dim>::axes> StructureSet<Dim>::answer_of(std::size_t k, const StructureSums<Dim>& pending,
                                                                   const Quantum& quantum,
                                                                   std::span<const TurningSums<Dim>> turning) const {
    if (spec(k).motion.turns) {
        Vec<double, TurningSums<Dim>::count> follows;
        for (int q = 0; q < TurningSums<Dim>::count; ++q) follows[q] = quantum.value(turning[k].sum[q]);
        return inverse_mass(followed_mass(bodies_[k], states_[k].turned, follows));
    }
    auto answer = zero_mat<double, CollidingBody<Dim>::axes>();
    for (int a = 0; a < Dim; ++a)
        answer(a, a) = 1 / (spec(k).motion.mass + quantum.value(pending.sum[StructureSums<Dim>::first_mass + a]));
    return answer;
}

template <int Dim>
void StructureSet<Dim>::take_collision(std::size_t k) {
    StructureState<Dim>& state = states_[k];
    const CollidingBody<Dim>& of = colliding_[k];
    for (int a = 0; a < Dim; ++a) {
        state.velocity[a] = of.motion[a];
        state.carried[a] += of.impulse[a] / spec(k).motion.mass;
    }
    for (int a = 0; spec(k).motion.turns && a < moments<Dim>; ++a) {
        state.spin[a] = of.motion[Dim + a];
        state.carried_spin[a] += of.impulse[Dim + a];
    }
}

template <int Dim>
void StructureSet<Dim>::prescribe(std::size_t k, double time, double dt) {
    const MotionSpec& motion = spec(k).motion;
    StructureState<Dim>& state = states_[k];
    const Triple here = displacement_at(motion, time), there = displacement_at(motion, time + dt);
    for (int a = 0; a < Dim; ++a) {
        const auto i = static_cast<std::size_t>(a);
        state.displacement[a] = here[i];
        state.velocity[a] = (there[i] - here[i]) / dt;
    }
    if (!turns(motion)) return;
    const Vec<double, moments<Dim>> w = angular_velocity_of<Dim>(motion);
    const double factor = motion_factor(motion, time);
    state.turned = rotation_by(factor * w);
    state.spin = ((motion_factor(motion, time + dt) - factor) / dt) * w;
}

template <int Dim>
void StructureSet<Dim>::begin_free(std::size_t k, double dt, const std::array<double, Dim>& gravity,
                                   const StructureSums<Dim>& pending, const Quantum& quantum) {
    const MotionSpec& motion = spec(k).motion;
    StructureState<Dim>& state = states_[k];
    for (int a = 0; a < Dim; ++a) {
        const auto i = static_cast<std::size_t>(a);
        const double felt = quantum.value(pending.sum[a]);
        const double follows = quantum.value(pending.sum[StructureSums<Dim>::first_mass + a]);
        state.carried[a] += felt / motion.mass + dt * (gravity[i] + motion.force[i] / motion.mass);
        state.velocity[a] =
            (motion.mass * state.carried[a] + felt + follows * state.velocity[a]) / (motion.mass + follows);
    }
}

template <int Dim>
void StructureSet<Dim>::begin_turning(std::size_t k, double dt, const std::array<double, Dim>& gravity,
                                      const StructureSums<Dim>& pending, const TurningSums<Dim>& turning,
                                      const Quantum& quantum) {
    const MotionSpec& motion = spec(k).motion;
    const RigidBody<Dim>& body = bodies_[k];
    StructureState<Dim>& state = states_[k];
    FreeMotion<Dim> free;
    for (int a = 0; a < Dim; ++a) {
        const auto i = static_cast<std::size_t>(a);
        free.impulse[a] = quantum.value(pending.sum[a]);
        state.carried[a] += free.impulse[a] / motion.mass + dt * (gravity[i] + motion.force[i] / motion.mass);
        free.momentum[a] = motion.mass * state.carried[a];
        free.seen[a] = state.velocity[a];
    }
    for (int a = 0; a < moments<Dim>; ++a) {
        free.impulse[Dim + a] = quantum.value(pending.sum[Dim + a]);
        state.carried_spin[a] += free.impulse[Dim + a];
        free.momentum[Dim + a] = state.carried_spin[a];
        free.seen[Dim + a] = state.spin[a];
    }
    for (int q = 0; q < TurningSums<Dim>::count; ++q) free.follows[q] = quantum.value(turning.sum[q]);
    const auto expected = expected_motion(body, state.turned, free);
    for (int a = 0; a < Dim; ++a) state.velocity[a] = expected[a];
    for (int a = 0; a < moments<Dim>; ++a) state.spin[a] = expected[Dim + a];
}

template <int Dim>
void StructureSet<Dim>::end_step(double time, double dt) {
    for (std::size_t k = 0; k < values_.size(); ++k) {
        const MotionSpec& motion = spec(k).motion;
        StructureState<Dim>& state = states_[k];
        const bool free = motion.kind == StructureMotion::free;
        state.displacement =
            free ? state.displacement - (-dt) * state.velocity : vec_of<Dim>(displacement_at(motion, time));
        if (free && motion.turns)
            state.turned = normalised(rotation_by(dt * state.spin) * state.turned);
        else if (turns(motion))
            state.turned = rotation_by(motion_factor(motion, time) * angular_velocity_of<Dim>(motion));
        if (free && !colliding_.empty()) leave_overlaps(colliding_[k], motion.turns, state);
    }
}

template <int Dim>
void StructureSet<Dim>::take(std::span<const StructureSums<Dim>> mine, std::span<const TurningSums<Dim>> turning) {
    for (std::size_t k = 0; k < mine.size(); ++k) {
        states_[k].pending.add(mine[k]);
        states_[k].felt.add(mine[k]);
    }
    for (std::size_t k = 0; k < turning.size(); ++k)
        if (spec(k).motion.turns) states_[k].pending_turning.add(turning[k]);
}

template <int Dim>
void StructureSet<Dim>::forget_pending() {
    for (StructureState<Dim>& state : states_) state.pending = {}, state.pending_turning = {};
}

template <int Dim>
ContactField<Dim> StructureSet<Dim>::field() const {
    ContactField<Dim> f{};
    f.structure = values_.data();
    f.count = static_cast<int>(values_.size());
    f.corners = corners_.data();
    f.soil = soil_.empty() ? nullptr : soil_.data();
    f.cell = scene_.cell;
    f.offset = stencil_of(scene_.shape).offset();
    for (int a = 0; a < Dim; ++a) {
        const auto i = static_cast<std::size_t>(a);
        f.origin[a] = scene_.min[i];
        f.period[a] = scene_.periodic[i] ? scene_.max[i] - scene_.min[i] : 0;
    }
    return f;
}

template <int Dim>
void StructureSet<Dim>::place() {
    for (std::size_t k = 0; k < values_.size(); ++k) {
        values_[k].at = start_[k] - (-1.0) * states_[k].displacement;
        values_[k].velocity = states_[k].velocity;
        if (!values_[k].turns) continue;
        values_[k].turn = matrix_of(states_[k].turned);
        values_[k].spin = states_[k].spin;
    }
}

template class StructureSet<2>;
template class StructureSet<3>;

}  // namespace moraine
