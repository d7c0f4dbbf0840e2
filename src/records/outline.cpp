#include "records/outline.hpp"

#include <fmt/format.h>

#include <map>

namespace moraine {
namespace {

using Corner = std::array<std::int64_t, 2>;

/// Directions of border edges, the reached cell on their left: east, north, west, south.
constexpr std::int64_t step[4][2] = {{1, 0}, {0, 1}, {-1, 0}, {0, -1}};

class Border {
  public:
    Border(const std::vector<bool>& reached, const Corner& size)
        : reached_(reached),
          size_(size),
          edges_(static_cast<std::size_t>((size[0] + 1) * (size[1] + 1)), 0),
          part_(reached.size(), -1) {
        for (std::int64_t j = 0; j < size[1]; ++j)
            for (std::int64_t i = 0; i < size[0]; ++i) {
                if (!is_in(i, j)) continue;
                if (!is_in(i, j - 1)) edge(i, j, 0);
                if (!is_in(i + 1, j)) edge(i + 1, j, 1);
                if (!is_in(i, j + 1)) edge(i + 1, j + 1, 2);
                if (!is_in(i - 1, j)) edge(i, j + 1, 3);
                if (part_[cell(i, j)] < 0) label(i, j);
            }
    }

    /// Calls f(part, ring) for all rings; of a part the first one is the outer one.
    template <class F>
    void each_ring(const F& f) const {
        std::vector<std::uint8_t> left = edges_;
        for (std::int64_t j = 0; j <= size_[1]; ++j)
            for (std::int64_t i = 0; i <= size_[0]; ++i)
                for (int d = 0; d < 4; ++d)
                    if (left[corner(i, j)] >> d & 1) split(walk({i, j}, d, left), part_of({i, j}, d), f);
    }

    int parts() const { return parts_; }

  private:
    bool is_in(std::int64_t i, std::int64_t j) const {
        return i >= 0 && j >= 0 && i < size_[0] && j < size_[1] && reached_[cell(i, j)];
    }
    std::size_t cell(std::int64_t i, std::int64_t j) const { return static_cast<std::size_t>(i + size_[0] * j); }
    std::size_t corner(std::int64_t i, std::int64_t j) const {
        return static_cast<std::size_t>(i + (size_[0] + 1) * j);
    }
    void edge(std::int64_t i, std::int64_t j, int d) {
        edges_[corner(i, j)] = static_cast<std::uint8_t>(edges_[corner(i, j)] | 1 << d);
    }

    void label(std::int64_t i, std::int64_t j) {
        std::vector<Corner> open{{i, j}};
        part_[cell(i, j)] = parts_;
        while (!open.empty()) {
            const Corner at = open.back();
            open.pop_back();
            for (const auto& s : step) {
                const std::int64_t x = at[0] + s[0], y = at[1] + s[1];
                if (!is_in(x, y) || part_[cell(x, y)] >= 0) continue;
                part_[cell(x, y)] = parts_;
                open.push_back({x, y});
            }
        }
        ++parts_;
    }

    /// Of the cell on the left of an edge.
    int part_of(const Corner& c, int d) const {
        const std::int64_t i = d == 0 || d == 3 ? c[0] : c[0] - 1, j = d == 0 || d == 1 ? c[1] : c[1] - 1;
        return part_[cell(i, j)];
    }

    /// Corners of a closed walk along the border, to the left wherever there is a choice.
    std::vector<Corner> walk(const Corner& start, int direction, std::vector<std::uint8_t>& left) const {
        std::vector<Corner> all;
        Corner at = start;
        for (int d = direction; left[corner(at[0], at[1])] >> d & 1;) {
            left[corner(at[0], at[1])] = static_cast<std::uint8_t>(left[corner(at[0], at[1])] & ~(1 << d));
            all.push_back(at);
            at = {at[0] + step[d][0], at[1] + step[d][1]};
            for (int turn : {1, 0, 3})
                if (edges_[corner(at[0], at[1])] >> ((d + turn) % 4) & 1) {
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

    const std::vector<bool>& reached_;
    Corner size_;
    std::vector<std::uint8_t> edges_;  ///< that begin at each corner, as bits of their directions
    std::vector<int> part_;            ///< of each cell
    int parts_ = 0;
};

std::int64_t twice_area(const std::vector<Corner>& ring) {
    std::int64_t sum = 0;
    for (std::size_t i = 0, j = ring.size() - 1; i < ring.size(); j = i++)
        sum += ring[j][0] * ring[i][1] - ring[i][0] * ring[j][1];
    return sum;
}

}  // namespace

std::vector<Rings> outline_of(const std::vector<bool>& reached, const PlanGrid& grid) {
    const auto place = [&](std::size_t axis, std::int64_t index) {
        const std::int64_t of_map = grid.first[axis] + index;
        if (of_map == 0) return grid.begin[axis];
        return of_map == grid.whole[axis] ? grid.end[axis]
                                          : grid.corner[axis] + grid.cell * static_cast<double>(of_map);
    };
    const Border border(reached, grid.size);
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
