#include "records/sleep_forecast.hpp"

#include <algorithm>
#include <limits>

namespace moraine {

/// As Simulation::check_sleep().
template <class Real, int Dim>
bool SleepForecast<Real, Dim>::is_due(const RunClock<Dim>& clock) const {
    return step_ < 0 || (clock.time >= time_ + interval_ && clock.step >= step_ + least_sleep_steps);
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

/// Of particles that came from other ranks since the last check. Collective.
template <class Real, int Dim>
void SleepForecast<Real, Dim>::learn(const std::vector<Rest>& now) {
    std::vector<std::uint64_t> missing;
    for (const Rest& rest : now)
        if (!std::binary_search(rests_.begin(), rests_.end(), rest)) missing.push_back(rest.id);
    std::vector<Rest> known;
    for (const std::uint64_t id : comm_.all_gather(missing)) {
        const auto at = std::lower_bound(rests_.begin(), rests_.end(), Rest{id, 0, 0});
        if (at != rests_.end() && at->id == id) known.push_back(*at);
    }
    for (const Rest& rest : comm_.all_gather(known))
        if (std::binary_search(missing.begin(), missing.end(), rest.id)) rests_.push_back(rest);
    std::sort(rests_.begin(), rests_.end());
}

/// Of the occupied blocks of all ranks, in key order. Collective.
template <class Real, int Dim>
typename SleepForecast<Real, Dim>::Activities SleepForecast<Real, Dim>::activities(const Simulation<Real, Dim>& sim,
                                                                                   bool due) const {
    Activities mine;
    sim.each_piece({}, [&](const SharePiece<Real, Dim>& piece) {
        for (int b = piece.begin; b < piece.end; ++b) {
            Activity block{piece.tables.own[static_cast<std::size_t>(b)], 0, 0};
            for (const std::uint32_t s : piece.slots(b)) {
                block.speed = std::max(block.speed, activity_by_speed<Real, Dim>(rule_, piece.p, s));
                if (!due) continue;
                const auto at = std::lower_bound(rests_.begin(), rests_.end(), Rest{piece.p.id[s], 0, 0});
                const bool known = at != rests_.end() && at->id == piece.p.id[s];
                block.u = std::max(block.u, known ? activity_since<Real, Dim>(rule_, piece.p, s, at->place, at->stress)
                                                  : std::numeric_limits<double>::infinity());
            }
            if (!piece.slots(b).empty()) mine.push_back(block);
        }
    });
    Activities all = comm_.all_gather(mine);
    std::sort(all.begin(), all.end(), [](const Activity& a, const Activity& b) { return a.key < b.key; });
    return all;
}

/// U of core/sleep.hpp.
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
    const Activities all = activities(sim, due);
    std::vector<Key> asleep;
    for (const Activity& block : all) {
        const bool slept = std::binary_search(asleep_.begin(), asleep_.end(), block.key);
        const bool stays = slept && block.speed <= 1;
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
