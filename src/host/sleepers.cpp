#include "host/sleepers.hpp"

#include <algorithm>
#include <limits>

#include "comm/activity_exchange.hpp"
#include "core/sleep/scene_sleep.hpp"

namespace moraine {

namespace {
constexpr int tag = 5;  // beside those of host/host_engine.hpp and engine/agreement.cpp
}  // namespace

template <class Real, int Dim>
Sleepers<Real, Dim>::Sleepers(const Scene& scene, const Comm& comm, const Method<Host, Real, Dim>& method, Share& share)
    : scene_(scene), method_(method), share_(share), messages_(comm, tag), rule_(sleep_rule(scene)) {}

template <class Real, int Dim>
std::span<const std::uint32_t> Sleepers<Real, Dim>::slots(int block) const {
    const ListView<Dim> list = share_.list();
    return {list.slot + list.first[block], list.count(block)};
}

template <class Real, int Dim>
void Sleepers<Real, Dim>::begin_epoch() {
    const auto own = static_cast<std::size_t>(share_.own());
    asleep_.assign(own + share_.tables().ghost.size(), 0);
    made_.assign(own, {});
    masses_.assign(own, {});
    listed_ = still_known_ = false;
    const ParticleView<Real, Dim> p = share_.particles.view();
    Host::launch(share_.own(), [&](int b) {
        const auto of_block = slots(b);
        if (of_block.empty() || !(p.rest_place[of_block.front()] & rest_word::asleep)) return;
        asleep_[static_cast<std::size_t>(b)] = 1;
        settle(b);
    });
}

/// What steps ask of a block that they leave out.
template <class Real, int Dim>
void Sleepers<Real, Dim>::settle(int block) {
    const ParticleView<Real, Dim> p = share_.particles.view();
    BlockOutcome out;
    for (const std::uint32_t s : slots(block))
        out.signal = std::max(out.signal, method_.law_of(p.body[s]).signal(p, s));
    share_.outcome()[block] = out;
    share_.outgoing_count()[block] = 0;
    share_.shuffled()[block] = 0;
    made_[static_cast<std::size_t>(block)] = {};
}

template <class Real, int Dim>
const std::vector<std::int32_t>& Sleepers<Real, Dim>::sleepers() {
    if (listed_) return sleepers_;
    awake_.clear();
    sleepers_.clear();
    for (std::int32_t b = 0; b < share_.own(); ++b) (is_asleep(b) ? sleepers_ : awake_).push_back(b);
    listed_ = true;
    return sleepers_;
}

template <class Real, int Dim>
std::span<const std::int32_t> Sleepers<Real, Dim>::awake() {
    sleepers();
    return awake_;
}

template <class Real, int Dim>
std::int64_t Sleepers<Real, Dim>::particles() const {
    std::int64_t sum = 0;
    for (int b = 0; b < share_.own(); ++b)
        if (is_asleep(b)) sum += share_.list().count(b);
    return sum;
}

template <class Real, int Dim>
void Sleepers<Real, Dim>::wake(int block) {
    const ParticleView<Real, Dim> p = share_.particles.view();
    for (const std::uint32_t s : slots(block)) p.rest_place[s] &= ~rest_word::asleep;
    asleep_[static_cast<std::size_t>(block)] = 0;
    listed_ = false;
}

template <class Real, int Dim>
void Sleepers<Real, Dim>::wake_entered() {
    for (const std::int32_t b : std::vector(sleepers()))
        if (share_.shuffled()[b]) wake(b);
}

template <class Real, int Dim>
double Sleepers<Real, Dim>::activity(int block, Structures structures) const {
    double most = 0;
    if (structures && !slots(block).empty() &&
        is_kept_awake(*structures, rule_.interval, share_.table().position[block]))
        return std::numeric_limits<double>::infinity();
    if (is_asleep(block)) return most;
    const ParticleView<Real, Dim> p = share_.particles.view();
    for (const std::uint32_t s : slots(block)) most = std::max(most, activity_of<Real, Dim>(rule_, p, s));
    return most;
}

template <class Real, int Dim>
double Sleepers<Real, Dim>::activity_around(int block) const {
    double most = activity_[static_cast<std::size_t>(block)];
    for (int code = 0; code < Block<Dim>::offsets; ++code) {
        const std::int32_t n = share_.table().neighbour[block * Block<Dim>::offsets + code];
        if (n >= 0) most = std::max(most, activity_[static_cast<std::size_t>(n)]);
    }
    return most;
}

/// Takes the motion of a block away, into the budget.
template <class Real, int Dim>
void Sleepers<Real, Dim>::put_to_sleep(int block, const Quantum& quantum, Budget<Dim>& budget) {
    const ParticleView<Real, Dim> p = share_.particles.view();
    for (const std::uint32_t s : slots(block)) {
        const double m = static_cast<double>(p.mass[s]);
        double square = 0;
        for (int a = 0; a < Dim; ++a) {
            const double v = static_cast<double>(p.velocity[s][a]);
            square += v * v;
            budget.slept_momentum[static_cast<std::size_t>(a)].add(quantum.of(m * v));
        }
        budget.slept_kinetic.add(quantum.of(0.5 * m * square));
        p.velocity[s] = zero_vec<Real, Dim>();
        if (p.affine) p.affine[s] = zero_mat<Real, Dim>();
        p.rest_place[s] = rest_place<Real, Dim>(p.position[s]) | rest_word::asleep;
        p.rest_stress[s] = rest_stress(p.stress[s]);
    }
    asleep_[static_cast<std::size_t>(block)] = 1;
    listed_ = false;
    settle(block);
}

/// From now on it is told what the particles of an awake block do.
template <class Real, int Dim>
void Sleepers<Real, Dim>::mark(int block) {
    if (is_asleep(block)) return;
    const ParticleView<Real, Dim> p = share_.particles.view();
    for (const std::uint32_t s : slots(block)) {
        p.rest_place[s] = rest_place<Real, Dim>(p.position[s]);
        p.rest_stress[s] = rest_stress(p.stress[s]);
    }
}

template <class Real, int Dim>
void Sleepers<Real, Dim>::check(bool first, const Quantum& quantum, Structures structures, Budget<Dim>& budget) {
    activity_.assign(asleep_.size(), 0);
    Host::launch(share_.own(), [&](int b) { activity_[static_cast<std::size_t>(b)] = activity(b, structures); });
    exchange_activity(messages_, share_.tables(), activity_);
    for (int b = 0; b < share_.own() && !first; ++b) {
        if (slots(b).empty()) continue;
        const SleepChange change = sleep_change(rule_, is_asleep(b), activity_around(b));
        if (change == SleepChange::wakes)
            wake(b);
        else if (change == SleepChange::falls_asleep)
            put_to_sleep(b, quantum, budget);
    }
    Host::launch(share_.own(), [&](int b) { mark(b); });
    still_known_ = false;
}

template <class Real, int Dim>
std::span<const std::int32_t> Sleepers<Real, Dim>::to_sum(std::span<const std::int32_t> blocks, NodeMean mean) {
    sums_.clear();
    const std::int32_t* tile_of = share_.tile_of();
    for (const std::int32_t b : blocks) {
        if (tile_of[b] < 0) continue;
        TileMark& made = made_[static_cast<std::size_t>(b)];
        const TileMark wanted{share_.tile_memory() + forgotten_, tile_of[b], mean};
        if (!is_asleep(b) || made != wanted || method_.grid_bulk()) sums_.push_back(b);  // substeps write to all tiles
        made = is_asleep(b) ? wanted : TileMark{};
    }
    return sums_;
}

/// Tiles are written to in substeps, and their masses are wanted after them.
template <class Real, int Dim>
void Sleepers<Real, Dim>::keep_masses() {
    const TileView<Real> grid = share_.grid();
    const auto nodes = static_cast<std::size_t>(power<Dim>(tile_side(method_.stencil.width)));
    Host::launch(static_cast<std::int64_t>(sums_.size()), [&](int k) {
        const std::int32_t b = sums_[static_cast<std::size_t>(k)];
        if (!is_asleep(b)) return;
        std::vector<Real>& masses = masses_[static_cast<std::size_t>(b)];
        masses.resize(nodes);
        const Real* tile = grid.tiles + std::size_t(grid.tile_of[b]) * nodes * node_reals;
        for (std::size_t n = 0; n < nodes; ++n) masses[n] = tile[n * node_reals];
    });
}

/// What sleeps now has done so since the last sleep check at least, or these are found anew.
template <class Real, int Dim>
bool Sleepers<Real, Dim>::find_still_nodes(Structures structures, std::span<const std::int32_t> near_of) {
    const auto count = static_cast<std::size_t>(share_.table().node_blocks);
    std::vector<std::uint8_t> now(count);
    Host::launch(static_cast<std::int64_t>(count), [&](int c) {
        now[static_cast<std::size_t>(c)] =
            (near_of.empty() || near_of[static_cast<std::size_t>(c)] < 0) &&
            has_tiles_of_sleepers_alone(share_.table(), share_.tile_of(), asleep_.data(), c) &&
            (!structures ||
             is_free_of_structures(*structures, method_.stencil.origin, share_.table().node_position[c]));
    });
    if (still_known_ && now == is_still_) return false;
    is_still_.swap(now);
    still_.clear();
    other_.clear();
    for (std::size_t c = 0; c < count; ++c) (is_still_[c] ? still_ : other_).push_back(static_cast<std::int32_t>(c));
    still_known_ = true;
    return true;
}

template <class Real, int Dim>
void Sleepers<Real, Dim>::keep_still_nodes(const ExactSum* impulse, const Quantum& quantum) {
    still_impulse_.resize(still_.size());
    for (std::size_t k = 0; k < still_.size(); ++k)
        for (std::size_t a = 0; a < Dim; ++a) still_impulse_[k][a] = quantum.value(impulse[k * Dim + a]);
    held_still_.resize(static_cast<std::size_t>(share_.own()));
    Host::launch(share_.own(), [&](int b) {
        if (is_asleep(b)) held_still_[static_cast<std::size_t>(b)] = held_by_nodes(b, true);
    });
}

/// Corners of a sleeper whose node blocks are not solved.
template <class Real, int Dim>
int Sleepers<Real, Dim>::still_corners(int block) const {
    int still = 0;
    for (int delta = 0; still_known_ && delta < Block<Dim>::corners; ++delta)
        still += is_still_[static_cast<std::size_t>(share_.table().node_block[block * Block<Dim>::corners + delta])];
    return still;
}

/// At those of its nodes that are still, or the others, where its tile has mass. The block was summed at rest, so what
/// its nodes have now is what they gave it in this step.
template <class Real, int Dim>
HeldByNodes<Dim> Sleepers<Real, Dim>::held_by_nodes(int block, bool still) const {
    HeldByNodes<Dim> held;
    const int corners = still_corners(block);
    if (corners == (still ? 0 : Block<Dim>::corners)) return held;
    const BlockTable<Dim> table = share_.table();
    const TileView<Real> grid = share_.grid();
    const int side = tile_side(method_.stencil.width), nodes = power<Dim>(side);
    const std::vector<Real>& masses = masses_[static_cast<std::size_t>(block)];
    for (int n = 0; n < nodes; ++n) {
        const double m = static_cast<double>(masses[static_cast<std::size_t>(n)]);
        const CornerNode node = corner_node<Dim>(n, side);
        const auto of = static_cast<std::size_t>(table.node_block[block * Block<Dim>::corners + node.corner]);
        if (!(m > 0) || (corners > 0 && (is_still_[of] != 0) != still)) continue;
        const std::size_t stored = std::size_t(grid.node_of[of]) * Block<Dim>::cells + std::size_t(node.at);
        held.add(rule_, m, grid.nodes + stored * node_reals);
    }
    return held;
}

template <class Real, int Dim>
void Sleepers<Real, Dim>::list_still_nodes_of(int block) {
    for (int delta = 0; still_known_ && delta < Block<Dim>::corners; ++delta) {
        const std::int32_t c = share_.table().node_block[block * Block<Dim>::corners + delta];
        if (is_still_[static_cast<std::size_t>(c)]) woken_nodes_.push_back(c);
    }
}

template <class Real, int Dim>
void Sleepers<Real, Dim>::wake_by_nodes(double dt, const Quantum& quantum, Structures structures, Budget<Dim>& budget) {
    const std::vector<std::int32_t> blocks = sleepers();
    held_.resize(blocks.size());
    Host::launch(static_cast<std::int64_t>(blocks.size()), [&](int k) {
        const auto i = static_cast<std::size_t>(k);
        held_[i] = held_by_nodes(blocks[i], false);
        if (structures && is_kept_awake(*structures, rule_.interval, share_.table().position[blocks[i]]))
            held_[i].fast = true;
    });
    const auto take = [&](const HeldByNodes<Dim>& held, double scale) {
        budget.slept_kinetic.add(quantum.of(held.kinetic * scale * scale));
        for (std::size_t a = 0; a < Dim; ++a) budget.slept_momentum[a].add(quantum.of(held.momentum[a] * scale));
    };
    woken_nodes_.clear();
    for (std::size_t k = 0; k < blocks.size(); ++k) {
        if (held_[k].fast) {
            wake(blocks[k]);
            list_still_nodes_of(blocks[k]);
            continue;
        }
        take(held_[k], 1);
        if (still_known_) take(held_still_[static_cast<std::size_t>(blocks[k])], dt);
    }
    std::sort(woken_nodes_.begin(), woken_nodes_.end());
    woken_nodes_.erase(std::unique(woken_nodes_.begin(), woken_nodes_.end()), woken_nodes_.end());
    for (const std::array<double, Dim>& impulse : still_impulse_)
        for (std::size_t a = 0; a < Dim; ++a) budget.impulse[a].add(quantum.of(impulse[a] * dt));
}

template <class Real, int Dim>
void Sleepers<Real, Dim>::stay() {
    const ListView<Dim> list = share_.list();
    const std::vector<std::int32_t>& blocks = sleepers();
    Host::launch(static_cast<std::int64_t>(blocks.size()), [&](int k) {
        const std::int32_t b = blocks[static_cast<std::size_t>(k)];
        const std::uint32_t* bounds = list.cell_first + std::size_t(b) * (Block<Dim>::cells + 1);
        std::uint16_t* moves = share_.moves() + list.first[b];
        for (int c = 0; c < Block<Dim>::cells; ++c)
            std::fill(moves + bounds[c], moves + bounds[c + 1], encode_move(Block<Dim>::centre, c));
    });
}

template class Sleepers<float, 2>;
template class Sleepers<float, 3>;
template class Sleepers<double, 2>;
template class Sleepers<double, 3>;

}  // namespace moraine
