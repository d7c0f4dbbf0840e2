#pragma once
// The list of constitutive laws: the one place that names them all.
//
// A name of material.law leads to a LawInfo (keys, units, bounds: what the reader of scenes, the writer
// of outputs and the documentation need) and, by with_law, to the law's struct: a kernel is compiled
// once per struct. Bingham and Newtonian are names for the Herschel-Bulkley struct, not structs: they
// add no kernels.

#include <algorithm>
#include <span>
#include <string>
#include <utility>
#include <vector>

#include "core/material/law_list.hpp"

namespace moraine {

inline constexpr int max_parameters = 16;

/// A name of material.law. Values are in the order of `parameters`, and checked against them.
struct LawInfo {
    const char* name;
    std::span<const Parameter> parameters;
    int history;  ///< scalars per particle
    std::span<const char* const> history_names;
    bool uses_left_stretch;
    int position;                  ///< position in Laws
    std::span<const double> tail;  ///< values that the name fixes: they follow the parameters
    bool has_initial_state;        ///< which is not zero and depends on stress and body
    bool is_fluid;                 ///< point.hpp
    bool flows;                    ///< point.hpp

    /// P-wave modulus K + 4G/3 [Pa] at the start, under a stress of these normal components [Pa].
    double wave_modulus(const double* values, const BodyStart& start = {}, const Vec<double, 3>& stress = {}) const;
    /// Whether Poisson's ratio is 0.45 and more: volume then changes by a few percent in a sound run.
    bool is_nearly_incompressible(const double* values) const;
    /// nullptr, or why there is no state at the start under this stress.
    const char* problem_at_start(const double* values, const BodyStart& start, const Vec<double, 3>& stress) const;
    /// nullptr, or what is wrong between values that are each within bounds.
    const char* problem(const double* values) const;
};

/// nullptr when there is no such law.
const LawInfo* find_law(const std::string& name);

/// In the order of the list.
std::vector<std::string> law_names();

namespace detail {

template <class Real, class F, template <class> class First, template <class> class... Rest>
auto visit_law(LawList<First, Rest...>, int law, const double* values, F&& f) {
    if constexpr (sizeof...(Rest) > 0)
        if (law > 0) return visit_law<Real>(LawList<Rest...>{}, law - 1, values, std::forward<F>(f));
    return f(First<Real>(values));
}

}  // namespace detail

/// f(law) with the struct behind the name; f returns the same type for every law.
template <class Real, class F>
auto with_law(const LawInfo& info, const double* values, F&& f) {
    double all[max_parameters];
    const auto end = std::copy_n(values, info.parameters.size(), all);
    std::copy(info.tail.begin(), info.tail.end(), end);
    return detail::visit_law<Real>(Laws{}, info.position, all, std::forward<F>(f));
}

/// The same by name, which must be one of law_names().
template <class Real, class F>
auto with_law(const std::string& name, const double* values, F&& f) {
    return with_law<Real>(*find_law(name), values, std::forward<F>(f));
}

}  // namespace moraine
