#include "records/outline.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <map>
#include <tuple>
#include <utility>

namespace moraine {
namespace {

using Corner = PlanCell;

/// Directions of border edges, the reached cell on their left: east, north, west, south.
constexpr std::int64_t step[4][2] = {{1, 0}, {0, 1}, {-1, 0}, {0, -1}};

/// From the south on, and there from the west.
bool is_before(const PlanCell& a, const PlanCell& b) {
    return std::tie(a[1], a[0]) < std::tie(b[1], b[0]);
}

/// Where it stands in a sorted list; none: its size.
std::size_t index_in(const std::vector<PlanCell>& list, const PlanCell& at) {
    const auto found = std::lower_bound(list.begin(), list.end(), at, is_before);
    return found != list.end() && *found == at ? static_cast<std::size_t>(found - list.begin()) : list.size();
}

class Border {
  public:
    explicit Border(std::vector<PlanCell> reached) : reached_(std::move(reached)) {
        std::sort(reached_.begin(), reached_.end(), is_before);
        find_edges();
        part_.assign(reached_.size(), -1);
        for (std::size_t k = 0; k < reached_.size(); ++k)
            if (part_[k] < 0) label(k);
    }

    /// Calls f(part, ring) for all rings; of a part the first one is the outer one.
    template <class F>
    void each_ring(const F& f) const {
        std::vector<std::uint8_t> left = edges_;
        for (std::size_t k = 0; k < corners_.size(); ++k)
            for (int d = 0; d < 4; ++d)
                if (left[k] >> d & 1) split(walk(k, d, left), part_of(corners_[k], d), f);
    }

    int parts() const { return parts_; }

  private:
    void find_edges() {
        std::vector<std::pair<Corner, int>> all;  // where an edge begins, and its direction
        for (const auto& [i, j] : reached_) {
            const auto is_in = [&](const PlanCell& at) { return index_in(reached_, at) < reached_.size(); };
            if (!is_in({i, j - 1})) all.push_back({{i, j}, 0});
            if (!is_in({i + 1, j})) all.push_back({{i + 1, j}, 1});
            if (!is_in({i, j + 1})) all.push_back({{i + 1, j + 1}, 2});
            if (!is_in({i - 1, j})) all.push_back({{i, j + 1}, 3});
        }
        std::sort(all.begin(), all.end(), [](const auto& a, const auto& b) { return is_before(a.first, b.first); });
        for (const auto& [corner, d] : all) {
            if (corners_.empty() || corners_.back() != corner) corners_.push_back(corner), edges_.push_back(0);
            edges_.back() = static_cast<std::uint8_t>(edges_.back() | 1 << d);
        }
    }

    void label(std::size_t first) {
        std::vector<std::size_t> open{first};
        part_[first] = parts_;
        while (!open.empty()) {
            const PlanCell at = reached_[open.back()];
            open.pop_back();
            for (const auto& s : step) {
                const std::size_t beside = index_in(reached_, {at[0] + s[0], at[1] + s[1]});
                if (beside == reached_.size() || part_[beside] >= 0) continue;
                part_[beside] = parts_;
                open.push_back(beside);
            }
        }
        ++parts_;
    }

    /// Of the cell on the left of an edge.
    int part_of(const Corner& c, int d) const {
        const std::int64_t i = d == 0 || d == 3 ? c[0] : c[0] - 1, j = d == 0 || d == 1 ? c[1] : c[1] - 1;
        return part_[index_in(reached_, {i, j})];
    }

    /// Corners of a closed walk along the border, to the left wherever there is a choice.
    std::vector<Corner> walk(std::size_t start, int direction, std::vector<std::uint8_t>& left) const {
        std::vector<Corner> all;
        std::size_t k = start;
        for (int d = direction; left[k] >> d & 1;) {
            left[k] = static_cast<std::uint8_t>(left[k] & ~(1 << d));
            all.push_back(corners_[k]);
            k = index_in(corners_, {corners_[k][0] + step[d][0], corners_[k][1] + step[d][1]});
            for (int turn : {1, 0, 3})
                if (edges_[k] >> ((d + turn) % 4) & 1) {
                    d = (d + turn) % 4;
                    break;
                }
        }
        return all;
    }

    /// A walk that comes to a corner twice is several rings.
    template <class F>
    void split(const std::vector<Corner>& walk, int part, const F& f) const {
        std::vector<Corner> path;
        std::map<Corner, std::size_t> place;
        for (const Corner& c : walk) {
            const auto found = place.find(c);
            if (found != place.end()) {
                const std::size_t from = found->second;
                f(part, std::vector<Corner>(path.begin() + static_cast<std::ptrdiff_t>(from), path.end()));
                for (std::size_t k = from; k < path.size(); ++k) place.erase(path[k]);
                path.resize(from);
            }
            place[c] = path.size();
            path.push_back(c);
        }
        f(part, path);
    }

    std::vector<PlanCell> reached_;
    std::vector<int> part_;            ///< of each
    std::vector<Corner> corners_;      ///< at which edges begin
    std::vector<std::uint8_t> edges_;  ///< there, as bits of their directions
    int parts_ = 0;
};

std::int64_t twice_area(const std::vector<Corner>& ring) {
    std::int64_t sum = 0;
    for (std::size_t i = 0, j = ring.size() - 1; i < ring.size(); j = i++)
        sum += ring[j][0] * ring[i][1] - ring[i][0] * ring[j][1];
    return sum;
}

}  // namespace

std::vector<Rings> outline_of(std::vector<PlanCell> reached, const PlanGrid& grid) {
    const auto place = [&](std::size_t axis, std::int64_t index) {
        if (index == 0) return grid.begin[axis];
        return index == grid.size[axis] ? grid.end[axis] : grid.corner[axis] + grid.cell * static_cast<double>(index);
    };
    const Border border(std::move(reached));
    std::vector<Rings> polygons(static_cast<std::size_t>(border.parts()));
    border.each_ring([&](int part, const std::vector<Corner>& ring) {
        std::vector<std::array<double, 2>> points;
        for (std::size_t k = 0, n = ring.size(); k < n; ++k) {
            const Corner &before = ring[(k + n - 1) % n], &at = ring[k], &after = ring[(k + 1) % n];
            if ((before[0] == at[0]) != (at[0] == after[0])) points.push_back({place(0, at[0]), place(1, at[1])});
        }
        Rings& rings = polygons[static_cast<std::size_t>(part)];
        rings.insert(twice_area(ring) > 0 ? rings.begin() : rings.end(), points);
    });
    return polygons;
}

std::string outline_json(const std::vector<Rings>& polygons, double threshold) {
    std::string text = fmt::format(
        "{{\"type\": \"Feature\", \"properties\": {{\"threshold\": {}}},\n \"geometry\": {{\"type\": \"MultiPolygon\", "
        "\"coordinates\": [",
        threshold);
    for (std::size_t p = 0; p < polygons.size(); ++p) {
        text += p == 0 ? "\n[" : ",\n[";
        for (std::size_t r = 0; r < polygons[p].size(); ++r) {
            text += r == 0 ? "[" : ",\n [";
            for (const auto& c : polygons[p][r]) text += fmt::format("[{:.10g}, {:.10g}], ", c[0], c[1]);
            text += fmt::format("[{:.10g}, {:.10g}]]", polygons[p][r][0][0], polygons[p][r][0][1]);
        }
        text += "]";
    }
    return text + "]}}\n";
}

}  // namespace moraine
