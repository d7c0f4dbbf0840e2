#include "balance/host_relabel.hpp"

#include <algorithm>
#include <functional>
#include <numeric>
#include <tuple>

#include "balance/relabel.hpp"
#include "comm/host_groups.hpp"

namespace moraine {
namespace {

using Order = std::vector<std::int32_t>;

/// What item k keeps if it begins at place `start`.
using Kept = std::function<std::int64_t(std::int32_t k, std::int64_t start)>;

std::int64_t kept_by(const Order& order, const std::vector<std::int64_t>& sizes, const Kept& kept) {
    std::int64_t sum = 0, start = 0;
    for (const std::int32_t k : order) sum += kept(k, start), start += sizes[k];
    return sum;
}

/// Items side by side that keep most; of such orders the first by number.
///   F(set) = max over k not in set of  kept(k, size of set) + F(set with k)
Order best_order(const std::vector<std::int64_t>& sizes, const Kept& kept) {
    const std::size_t n = sizes.size(), all = (std::size_t(1) << n) - 1;
    std::vector<std::int64_t> size(all + 1, 0), most(all + 1, 0);
    std::vector<std::int32_t> first(all + 1, -1);
    for (std::size_t set = 1; set <= all; ++set)
        for (std::size_t k = 0; k < n; ++k)
            if (set >> k & 1) size[set] += sizes[k];
    for (std::size_t set = all; set-- > 0;)
        for (std::size_t k = 0; k < n; ++k) {
            if (set >> k & 1) continue;
            const std::int64_t sum = kept(static_cast<std::int32_t>(k), size[set]) + most[set | std::size_t(1) << k];
            if (first[set] < 0 || sum > most[set]) most[set] = sum, first[set] = static_cast<std::int32_t>(k);
        }
    Order order;
    for (std::size_t set = 0; set != all; set |= std::size_t(1) << first[set]) order.push_back(first[set]);
    return order;
}

Order natural_order(std::size_t n) {
    Order order(n);
    std::iota(order.begin(), order.end(), 0);
    return order;
}

/// Where hosts and their ranks are, and what they hold of each part.
struct Held {
    Held(std::span<const BlockLoad> blocks, std::span<const std::int32_t> part_of,
         std::span<const std::int32_t> host_of_rank)
        : host(host_of_rank),
          pairs(overlaps(blocks, part_of, static_cast<int>(host.size()))),
          ranks(static_cast<std::size_t>(host_count(host))) {
        for (std::size_t r = 0; r < host.size(); ++r) ranks[host[r]].push_back(static_cast<std::int32_t>(r));
        first_of_part.assign(host.size() + 1, 0);
        for (const Overlap& o : pairs) ++first_of_part[o.part + 1];
        std::partial_sum(first_of_part.begin(), first_of_part.end(), first_of_part.begin());
    }

    std::span<const std::int32_t> host;
    std::vector<Overlap> pairs;  ///< by part, then rank
    std::vector<Order> ranks;    ///< of each host
    std::vector<std::size_t> first_of_part;
};

Order by_mean_place(const Held& held, const std::vector<std::int64_t>& sizes) {
    std::vector<double> particles(sizes.size(), 0), sum = particles;
    for (const Overlap& o : held.pairs) {
        particles[held.host[o.rank]] += static_cast<double>(o.particles);
        sum[held.host[o.rank]] += static_cast<double>(o.particles) * (o.part + 0.5);
    }
    std::int64_t start = 0;
    std::vector<std::tuple<double, std::int32_t>> places;
    for (std::size_t h = 0; h < sizes.size(); start += sizes[h], ++h) {
        const double natural = static_cast<double>(start) + 0.5 * static_cast<double>(sizes[h]);
        places.emplace_back(particles[h] > 0 ? sum[h] / particles[h] : natural, static_cast<std::int32_t>(h));
    }
    std::sort(places.begin(), places.end());
    Order order;
    for (const auto& place : places) order.push_back(std::get<1>(place));
    return order;
}

Order order_of_hosts(const Held& held) {
    const std::size_t hosts = held.ranks.size(), parts = held.host.size();
    std::vector<std::int64_t> sizes;
    for (const Order& ranks : held.ranks) sizes.push_back(static_cast<std::int64_t>(ranks.size()));
    std::vector<std::int64_t> before(hosts * (parts + 1), 0);  // held by a host of the parts below
    for (const Overlap& o : held.pairs) before[held.host[o.rank] * (parts + 1) + o.part + 1] += o.particles;
    for (std::size_t h = 0; h < hosts; ++h)
        for (std::size_t p = 0; p < parts; ++p) before[h * (parts + 1) + p + 1] += before[h * (parts + 1) + p];
    const Kept kept = [&](std::int32_t h, std::int64_t start) {
        const std::int64_t* sum = before.data() + h * (parts + 1) + start;
        return sum[sizes[h]] - sum[0];
    };
    if (hosts <= most_exact_order) return best_order(sizes, kept);
    const Order natural = natural_order(hosts), placed = by_mean_place(held, sizes);
    return kept_by(natural, sizes, kept) > kept_by(placed, sizes, kept) ? natural : placed;
}

/// Of the parts [start, start + ranks) to the ranks of host h.
Order order_of_ranks(const Held& held, std::int32_t h, std::int64_t start) {
    const Order& ranks = held.ranks[h];
    const std::size_t n = ranks.size();
    std::vector<Overlap> pairs;  // numbered within run and host
    std::vector<std::int64_t> of(n * n, 0);
    for (std::size_t k = held.first_of_part[start]; k < held.first_of_part[start + static_cast<std::int64_t>(n)]; ++k) {
        const Overlap& o = held.pairs[k];
        if (held.host[o.rank] != h) continue;
        const auto rank =
            static_cast<std::int32_t>(std::lower_bound(ranks.begin(), ranks.end(), o.rank) - ranks.begin());
        pairs.push_back({static_cast<std::int32_t>(o.part - start), rank, o.particles});
        of[static_cast<std::size_t>(rank) * n + static_cast<std::size_t>(pairs.back().part)] = o.particles;
    }
    Order order = n <= most_exact_order ? best_order(std::vector<std::int64_t>(n, 1),
                                                     [&](std::int32_t r, std::int64_t p) { return of[r * n + p]; })
                                        : relabel_pairs(std::move(pairs), static_cast<int>(n));
    for (std::int32_t& rank : order) rank = ranks[rank];
    return order;
}

}  // namespace

std::vector<std::int32_t> relabel_on_hosts(std::span<const BlockLoad> blocks, std::span<const std::int32_t> part_of,
                                           std::span<const std::int32_t> host_of_rank) {
    const Held held(blocks, part_of, host_of_rank);
    std::vector<std::int32_t> rank_of;
    for (const std::int32_t h : order_of_hosts(held)) {
        const Order ranks = order_of_ranks(held, h, static_cast<std::int64_t>(rank_of.size()));
        rank_of.insert(rank_of.end(), ranks.begin(), ranks.end());
    }
    return rank_of;
}

std::vector<std::int32_t> numbered_along_curve(std::vector<std::int32_t> part_of, int parts) {
    const auto last = static_cast<std::int64_t>(part_of.size());
    std::vector<std::int64_t> blocks(static_cast<std::size_t>(parts), 0), seen = blocks;
    std::vector<std::int64_t> median(static_cast<std::size_t>(parts), last);
    for (const std::int32_t part : part_of) ++blocks[part];
    for (std::int64_t b = 0; b < last; ++b)
        if (const std::int32_t part = part_of[b]; ++seen[part] == (blocks[part] + 1) / 2) median[part] = b;
    Order order = natural_order(static_cast<std::size_t>(parts)), number(order.size());
    std::stable_sort(order.begin(), order.end(), [&](std::int32_t x, std::int32_t y) { return median[x] < median[y]; });
    for (std::size_t k = 0; k < order.size(); ++k) number[order[k]] = static_cast<std::int32_t>(k);
    for (std::int32_t& part : part_of) part = number[part];
    return part_of;
}

}  // namespace moraine
