#include "records/section_flow.hpp"

#include <algorithm>
#include <bit>
#include <cmath>

namespace moraine {
namespace {

using InPlan = std::array<double, 2>;

constexpr double remembered = 2;  ///< distance from a section up to which places are remembered [map cells]

/// Whether c lies to the left of the way from a to b, or on it.
bool is_left(const InPlan& a, const InPlan& b, const InPlan& c) {
    return (b[0] - a[0]) * (c[1] - a[1]) - (b[1] - a[1]) * (c[0] - a[0]) >= 0;
}

}  // namespace

int crossings(const std::vector<InPlan>& line, const InPlan& p, const InPlan& q) {
    int sum = 0;
    for (std::size_t k = 0; k + 1 < line.size(); ++k) {
        const bool before = is_left(line[k], line[k + 1], p), after = is_left(line[k], line[k + 1], q);
        if (before != after && is_left(p, q, line[k]) != is_left(p, q, line[k + 1])) sum += after ? 1 : -1;
    }
    return sum;
}

SectionFlow::SectionFlow(const Scene& scene, const Comm& comm)
    : scene_(scene), comm_(comm), sums_(scene.hazard.sections.size()), values_(3 * sums_.size()) {
    double density = 0;
    for (const MaterialSpec& material : scene.materials) density = std::max(density, material.density);
    volume_unit_ = std::ldexp(scene.cell * scene.cell * scene.cell, -36);  // 2^27 cells full
    mass_unit_ = density * volume_unit_;
    for (const SectionSpec& section : scene.hazard.sections)
        for (std::size_t k = 0; k + 1 < section.points.size(); ++k) {
            const InPlan &from = section.points[k], &to = section.points[k + 1];
            segments_.push_back({{from[0], from[1]}, {to[0], to[1]}});
        }
}

SectionFlow::InPlan SectionFlow::start_of_way(InPlan from, const InPlan& to) const {
    for (std::size_t a = 0; a < 2; ++a) {
        const double period = scene_.max[a] - scene_.min[a];
        if (scene_.periodic[a]) from[a] += period * std::rint((to[a] - from[a]) / period);
    }
    return from;
}

template <class Real>
std::vector<SectionFlow::Moved> SectionFlow::near_particles(const Simulation<Real, 3>& sim) const {
    const PlanLines lines{sim.plan_places(), segments_.data(), static_cast<int>(segments_.size()),
                          remembered * scene_.hazard.cell};
    std::vector<Moved> near;
    for (const NearParticle& p : sim.answer(LineQuery{lines, {}}).near)
        near.push_back({{p.id, {p.x[0], p.x[1]}}, p.volume, p.mass});
    std::sort(near.begin(), near.end(), [](const Moved& a, const Moved& b) { return a.now.id < b.now.id; });
    return near;
}

std::vector<SectionFlow::Seen> SectionFlow::seen_before(const std::vector<Moved>& now) const {
    std::vector<Seen> known, gone;
    auto here = now.begin();
    for (const Seen& seen : seen_) {
        while (here != now.end() && here->now.id < seen.id) ++here;
        (here != now.end() && here->now.id == seen.id ? known : gone).push_back(seen);
    }
    const std::vector<Seen> elsewhere = comm_.all_gather(gone);
    known.insert(known.end(), elsewhere.begin(), elsewhere.end());
    std::sort(known.begin(), known.end(), [](const Seen& a, const Seen& b) { return a.id < b.id; });
    return known;
}

template <class Real>
void SectionFlow::sample(const Simulation<Real, 3>& sim) {
    const std::vector<Moved> now = near_particles(sim);
    const std::vector<Seen> before = seen_before(now);
    std::vector<std::int64_t> passed(2 * sums_.size(), 0);
    auto then = before.begin();
    for (const Moved& particle : now) {
        while (then != before.end() && then->id < particle.now.id) ++then;
        if (then == before.end()) break;
        if (then->id != particle.now.id) continue;
        const InPlan from = start_of_way(then->x, particle.now.x);
        for (std::size_t k = 0; k < sums_.size(); ++k) {
            const int times = crossings(scene_.hazard.sections[k].points, from, particle.now.x);
            if (times == 0) continue;
            passed[2 * k] += times * std::llround(particle.volume / volume_unit_);
            passed[2 * k + 1] += times * std::llround(particle.mass / mass_unit_);
        }
    }
    comm_.sum(passed);
    const double time = sim.clock().time, since = time - time_;
    for (std::size_t k = 0; k < sums_.size(); ++k) {
        for (std::size_t q = 0; q < 2; ++q) sums_[k][q] += passed[2 * k + q];
        values_[3 * k] = time_ >= 0 && since > 0 ? static_cast<double>(passed[2 * k]) * volume_unit_ / since : 0;
        values_[3 * k + 1] = static_cast<double>(sums_[k][0]) * volume_unit_;
        values_[3 * k + 2] = static_cast<double>(sums_[k][1]) * mass_unit_;
    }
    time_ = time;
    seen_.clear();
    for (const Moved& particle : now) seen_.push_back(particle.now);
}

std::vector<std::string> SectionFlow::columns() const {
    std::vector<std::string> names{"step", "time_s"};
    for (const SectionSpec& section : scene_.hazard.sections)
        for (const char* what : {"discharge_m3_s", "volume_m3", "mass_kg"}) names.push_back(section.name + "_" + what);
    return names;
}

std::vector<std::int64_t> SectionFlow::stored() const {
    std::vector<Seen> seen = comm_.all_gather(seen_);
    std::sort(seen.begin(), seen.end(), [](const Seen& a, const Seen& b) { return a.id < b.id; });
    std::vector<std::int64_t> all{std::bit_cast<std::int64_t>(time_)};
    for (const auto& sum : sums_) all.insert(all.end(), sum.begin(), sum.end());
    for (const Seen& s : seen)
        all.insert(all.end(), {static_cast<std::int64_t>(s.id), std::bit_cast<std::int64_t>(s.x[0]),
                               std::bit_cast<std::int64_t>(s.x[1])});
    return all;
}

bool SectionFlow::restore(const std::vector<std::int64_t>& all) {
    const std::size_t first = 1 + 2 * sums_.size();
    if (all.size() < first || (all.size() - first) % 3 != 0) return false;
    time_ = std::bit_cast<double>(all[0]);
    bool good = std::isfinite(time_);
    for (std::size_t k = 0; k < sums_.size(); ++k) sums_[k] = {all[1 + 2 * k], all[2 + 2 * k]};
    seen_.clear();
    for (std::size_t at = first; at < all.size(); at += 3) {
        const Seen seen{static_cast<std::uint64_t>(all[at]),
                        {std::bit_cast<double>(all[at + 1]), std::bit_cast<double>(all[at + 2])}};
        good = good && std::isfinite(seen.x[0]) && std::isfinite(seen.x[1]) &&
               (seen_.empty() || seen_.back().id < seen.id);
        seen_.push_back(seen);
    }
    return good;
}

template void SectionFlow::sample(const Simulation<float, 3>&);
template void SectionFlow::sample(const Simulation<double, 3>&);

}  // namespace moraine
