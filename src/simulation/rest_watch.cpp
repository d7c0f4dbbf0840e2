#include "simulation/rest_watch.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <bit>
#include <cmath>

#include "core/data/hash.hpp"
#include "core/rest_interval.hpp"
#include "simulation/diagnostics.hpp"

namespace moraine {

namespace {
constexpr std::int64_t most_followed = std::int64_t(1) << 18;  // 8 MiB of places in 3-D, sorted in some 20 ms
constexpr std::size_t head = 7;                                // words of stored() before those of particles
}  // namespace

template <int Dim>
double RestWatch<Dim>::next_look() const {
    const ShakingSpec& shaking = scene_.course.shaking;
    const double shakes = shaking.stage < 0 ? shaking.table.end() : 0;
    return followed_ == 0 ? std::max(scene_.course.gravity.end(), shakes) : begun_ + rest_interval(scene_);
}

template <int Dim>
bool RestWatch<Dim>::is_due(double time) const {
    return time >= next_look();
}

/// Of all ranks, ids ascending. Collective.
template <int Dim>
template <class Real>
std::vector<typename RestWatch<Dim>::Start> RestWatch<Dim>::places(const Simulation<Real, Dim>& sim) const {
    std::vector<Start> mine;
    sim.each_piece({"id", "position", "mass"}, [&](const SharePiece<Real, Dim>& piece) {
        for (int b = piece.begin; b < piece.end; ++b)
            for (const std::uint32_t s : piece.slots(b)) {
                const std::uint64_t id = piece.p.id[s];
                if (followed_ > 1 && mix(id) % static_cast<std::uint64_t>(followed_) != 0) continue;
                mine.push_back({id, static_cast<double>(piece.p.mass[s]), place_of(sim, piece, b, s)});
            }
    });
    std::vector<Start> all = comm_.all_gather(mine);
    std::sort(all.begin(), all.end(), [](const Start& a, const Start& b) { return a.id < b.id; });
    return all;
}

template <int Dim>
bool RestWatch<Dim>::has_moved(const Start& from, const Start& to) const {
    double square = 0;
    for (std::size_t a = 0; a < Dim; ++a) {
        double d = to.x[a] - from.x[a];
        const double length = scene_.max[a] - scene_.min[a];
        if (scene_.periodic[a]) d -= length * std::round(d / length);
        square += d * d;
    }
    const double least = scene_.rest.displacement * scene_.cell;
    return !(square < least * least);
}

/// Of the mass of then; all of none. Every rank adds in the same order.
template <int Dim>
double RestWatch<Dim>::share_at_rest(const std::vector<Start>& now) const {
    double all = 0, resting = 0;
    auto at = now.begin();
    for (const Start& from : starts_) {
        all += from.mass;
        while (at != now.end() && at->id < from.id) ++at;
        if (at != now.end() && at->id == from.id && !has_moved(from, *at)) resting += from.mass;
    }
    return all > 0 ? resting / all : 1;
}

template <int Dim>
template <class Real>
void RestWatch<Dim>::look(Simulation<Real, Dim>& sim) {
    if (!is_due(sim.clock().time)) return;
    sim.bin();
    sim.phases().time(Phase::output, {"rest check", true}, [&] { begin_next(sim); });
}

template <int Dim>
template <class Real>
void RestWatch<Dim>::begin_next(const Simulation<Real, Dim>& sim) {
    const bool ends = followed_ > 0;
    if (!ends)
        followed_ = 1 + (std::max<std::int64_t>(1, comm_.sum(sim.engine().census().particles)) - 1) / most_followed;
    std::vector<Start> now = places(sim);
    if (ends) {
        share_ = share_at_rest(now);
        calm_ = share_ >= scene_.rest.mass ? calm_ + 1 : 0;
    }
    starts_ = std::move(now);
    begun_ = sim.clock().time;
}

template <int Dim>
std::string RestWatch<Dim>::message() const {
    return fmt::format(
        "At rest: in {} intervals of {:.4g} s in turn {:.6g} % of the mass and more moved less than {:.4g} m", calm_,
        rest_interval(scene_), 100 * scene_.rest.mass, scene_.rest.displacement * scene_.cell);
}

template <int Dim>
std::vector<std::int64_t> RestWatch<Dim>::stored() const {
    if (followed_ == 0) return {};
    const auto word = [](double x) { return std::bit_cast<std::int64_t>(x); };
    const RestSpec& rest = scene_.rest;
    std::vector<std::int64_t> all{followed_,
                                  calm_,
                                  word(begun_),
                                  word(share_),
                                  word(rest.displacement),
                                  word(rest.mass),
                                  word(rest_interval(scene_))};
    for (const Start& s : starts_) {
        all.insert(all.end(), {std::bit_cast<std::int64_t>(s.id), word(s.mass)});
        for (const double x : s.x) all.push_back(word(x));
    }
    return all;
}

template <int Dim>
bool RestWatch<Dim>::restore(const std::vector<std::int64_t>& all) {
    constexpr std::size_t words = 2 + Dim;
    if (all.size() < head || (all.size() - head) % words != 0) return false;
    const auto number = [&](std::size_t k) { return std::bit_cast<double>(all[k]); };
    const std::int64_t followed = all[0], calm = all[1];
    if (followed < 1 || calm < 0 || !std::isfinite(number(2)) || !(number(3) >= 0 && number(3) <= 1)) return false;
    std::vector<Start> starts;
    for (std::size_t at = head; at < all.size(); at += words) {
        Start s{std::bit_cast<std::uint64_t>(all[at]), number(at + 1), {}};
        for (std::size_t a = 0; a < Dim; ++a) s.x[a] = number(at + 2 + a);
        const bool rises = starts.empty() || starts.back().id < s.id;
        if (!rises || !(s.mass > 0) || !std::isfinite(s.mass)) return false;
        starts.push_back(s);
    }
    const RestSpec& rest = scene_.rest;
    if (number(4) != rest.displacement || number(5) != rest.mass || number(6) != rest_interval(scene_)) return true;
    followed_ = followed, calm_ = calm, begun_ = number(2), share_ = number(3);
    starts_ = std::move(starts);
    return true;
}

/// Of one dimension.
#define MORAINE_REST_WATCH(Dim)                                  \
    template class RestWatch<Dim>;                               \
    template void RestWatch<Dim>::look(Simulation<float, Dim>&); \
    template void RestWatch<Dim>::look(Simulation<double, Dim>&);
MORAINE_REST_WATCH(2)
MORAINE_REST_WATCH(3)

}  // namespace moraine
