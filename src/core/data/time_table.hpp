#pragma once
// A table of time: what a load is worth at time t, linear between its rows, and constant before the first and after
// the last one.
//
// A step takes the mean over its length, which is the value at its middle wherever no row falls into it: impulses are
// then the exact integral of the table, whatever the steps. A step ends at no row.

#include <algorithm>
#include <cstddef>
#include <vector>

namespace moraine {

/// Linear between rows, constant before the first and after the last. xs: rising; ys: as many, at least one.
inline double value_between(const std::vector<double>& xs, const std::vector<double>& ys, double x) {
    const auto next = std::upper_bound(xs.begin(), xs.end(), x);
    if (next == xs.begin()) return ys.front();
    if (next == xs.end()) return ys.back();
    const auto k = static_cast<std::size_t>(next - xs.begin());
    const double share = (x - xs[k - 1]) / (xs[k] - xs[k - 1]);
    return ys[k - 1] + share * (ys[k] - ys[k - 1]);
}

struct TimeTable {
    std::vector<double> times;   ///< rising [s]
    std::vector<double> values;  ///< as many; of what names the table

    bool empty() const { return times.empty(); }
    /// From when on it is constant [s].
    double end() const { return empty() ? 0 : times.back(); }

    double at(double t) const { return value_between(times, values, t); }

    /// Over [from, to], from < to. Exact where it is constant there.
    double mean(double from, double to) const {
        auto next = std::upper_bound(times.begin(), times.end(), from);
        double sum = 0, begin = from, at_begin = at(from);
        for (; next != times.end() && *next < to; ++next) {
            const double value = values[static_cast<std::size_t>(next - times.begin())];
            sum += 0.5 * (at_begin + value) * (*next - begin);
            begin = *next, at_begin = value;
        }
        const double rest = 0.5 * (at_begin + at(to));
        return begin == from ? rest : (sum + rest * (to - begin)) / (to - from);
    }

    /// Over a length of time from t on, which may be none.
    double mean_from(double t, double length) const { return length > 0 ? mean(t, t + length) : at(t); }

    /// Of the sizes of its values.
    double largest() const {
        double most = 0;
        for (const double v : values) most = std::max(most, v < 0 ? -v : v);
        return most;
    }
};

}  // namespace moraine
