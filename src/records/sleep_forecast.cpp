#include "records/sleep_forecast.hpp"

#include <algorithm>
#include <cstddef>
#include <cstring>
#include <limits>
#include <span>

#include "comm/point_to_point.hpp"

namespace moraine {
namespace {

constexpr double never = std::numeric_limits<double>::infinity();  // activity of what does not fall asleep

template <class T>
void append(std::vector<std::byte>& bytes, const T& row) {
    const auto part = std::as_bytes(std::span(&row, 1));
    bytes.insert(bytes.end(), part.begin(), part.end());
}

template <class T>
void append_rows(std::vector<T>& rows, const std::vector<std::byte>& bytes) {
    const std::size_t before = rows.size();
    rows.resize(before + bytes.size() / sizeof(T));
    if (!bytes.empty()) std::memcpy(rows.data() + before, bytes.data(), bytes.size());
}

}  // namespace

/// As Simulation::check_sleep().
template <class Real, int Dim>
bool SleepForecast<Real, Dim>::is_due(const RunClock<Dim>& clock) const {
    return step_ < 0 || (clock.time >= time_ + rule_.interval && clock.step >= step_ + least_sleep_steps);
}

template <class Real, int Dim>
std::vector<typename SleepForecast<Real, Dim>::Rest> SleepForecast<Real, Dim>::rests_of(
    const Simulation<Real, Dim>& sim) const {
    std::vector<Rest> rests;
    sim.each_piece({}, [&](const SharePiece<Real, Dim>& piece) {
        for (const std::uint32_t s : piece.slots())
            rests.push_back(
                {piece.p.id[s], rest_place<Real, Dim>(piece.p.position[s]), rest_stress(piece.p.stress[s])});
    });
    std::sort(rests.begin(), rests.end());
    return rests;
}

/// Of particles that came from other ranks since the last check: who had one before and who has it now meet at rank id
/// mod P. Collective.
template <class Real, int Dim>
void SleepForecast<Real, Dim>::learn(const std::vector<Rest>& now) {
    const auto ranks = static_cast<std::size_t>(comm_.size());
    std::vector<std::vector<std::byte>> gone(ranks), missing(ranks), answers(ranks);
    for (const Rest& rest : rests_)
        if (!std::binary_search(now.begin(), now.end(), rest)) append(gone[rest.id % ranks], rest);
    for (const Rest& rest : now)
        if (!std::binary_search(rests_.begin(), rests_.end(), rest)) append(missing[rest.id % ranks], rest.id);
    std::vector<Rest> met;
    for (const auto& bytes : exchange_all(comm_, gone)) append_rows(met, bytes);
    std::sort(met.begin(), met.end());
    const std::vector<std::vector<std::byte>> asked = exchange_all(comm_, missing);
    for (std::size_t rank = 0; rank < ranks; ++rank) {
        std::vector<std::uint64_t> ids;
        append_rows(ids, asked[rank]);
        for (const std::uint64_t id : ids) {
            const auto at = std::lower_bound(met.begin(), met.end(), Rest{id, 0, 0});
            if (at != met.end() && at->id == id) append(answers[rank], *at);
        }
    }
    for (const auto& bytes : exchange_all(comm_, answers)) append_rows(rests_, bytes);
    std::sort(rests_.begin(), rests_.end());
}

/// Of the occupied blocks of all ranks, in key order. Collective.
template <class Real, int Dim>
typename SleepForecast<Real, Dim>::Activities SleepForecast<Real, Dim>::activities(const Simulation<Real, Dim>& sim,
                                                                                   bool due) const {
    Activities mine;
    const ContactField<Dim> structures = sim.structures().field();
    sim.each_piece({}, [&](const SharePiece<Real, Dim>& piece) {
        for (int b = piece.begin; b < piece.end; ++b) {
            const auto i = static_cast<std::size_t>(b);
            Activity block{piece.tables.own[i], 0, 0, false};
            if (is_kept_awake(structures, rule_.interval, piece.tables.position[i])) block.u = block.speed = never;
            for (const std::uint32_t s : piece.slots(b)) {
                block.speed = std::max(block.speed, activity_by_speed(rule_, piece.p.velocity[s]));
                if (!due) continue;
                const auto at = std::lower_bound(rests_.begin(), rests_.end(), Rest{piece.p.id[s], 0, 0});
                const bool known = at != rests_.end() && at->id == piece.p.id[s];
                block.u = std::max(block.u,
                                   known ? activity_since<Real, Dim>(rule_, piece.p, s, at->place, at->stress) : never);
            }
            if (!piece.slots(b).empty()) mine.push_back(block);
        }
    });
    Activities all = comm_.all_gather(mine);
    std::sort(all.begin(), all.end(), [](const Activity& a, const Activity& b) { return a.key < b.key; });
    return all;
}

/// U of core/sleep/sleep.hpp.
template <class Real, int Dim>
double SleepForecast<Real, Dim>::activity_around(const Activities& all, Key key) const {
    double most = 0;
    for (int code = 0; code < Block<Dim>::offsets; ++code) {
        BlockPosition<Dim> at = Morton<Dim>::decode(key);
        for (int a = 0; a < Dim; ++a) at[a] += Block<Dim>::offset(code, a);
        if (!domain_.wrap(at)) continue;
        const Key near = Morton<Dim>::encode(at);
        const auto found =
            std::lower_bound(all.begin(), all.end(), near, [](const Activity& block, Key k) { return block.key < k; });
        if (found != all.end() && found->key == near) most = std::max(most, found->u);
    }
    return most;
}

template <class Real, int Dim>
const std::vector<Key>& SleepForecast<Real, Dim>::look(const Simulation<Real, Dim>& sim) {
    const bool first = step_ < 0, due = is_due(sim.clock());
    std::vector<Rest> now;
    if (due) {
        now = rests_of(sim);
        if (!first) learn(now);
    }
    Activities all = activities(sim, due);
    for (Activity& block : all) {
        block.stays = block.speed <= 1 && std::binary_search(asleep_.begin(), asleep_.end(), block.key);
        if (block.stays) block.u = 0;
    }
    std::vector<Key> asleep;
    for (const Activity& block : all) {
        const bool stays = block.stays;
        if (due ? activity_around(all, block.key) < (stays ? rule_.wake : 1) : stays) asleep.push_back(block.key);
    }
    asleep_ = std::move(asleep);
    if (due) rests_ = std::move(now), time_ = sim.clock().time, step_ = sim.clock().step;
    return asleep_;
}

template class SleepForecast<float, 2>;
template class SleepForecast<float, 3>;
template class SleepForecast<double, 2>;
template class SleepForecast<double, 3>;

}  // namespace moraine
