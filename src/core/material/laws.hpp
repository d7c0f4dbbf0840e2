#pragma once
// The list of constitutive laws: the one place that names them all.
//
// A name of material.law leads to a LawInfo (keys, units, bounds: what the reader of scenes, the writer
// of outputs and the documentation need) and, by with_law, to the law's struct: a kernel is compiled
// once per struct. Bingham and Newtonian are names for the Herschel-Bulkley struct, not structs: they
// add no kernels. Laws in files (compile/law_file.hpp) are added when a scene names them.

#include <algorithm>
#include <stdexcept>
#include <string>
#include <string_view>
#include <utility>
#include <vector>

#include "core/material/law_info.hpp"
#include "core/material/law_list.hpp"

namespace moraine {

/// nullptr when there is no such law.
const LawInfo* find_law(const std::string& name);

/// What a law may keep per particle besides its state (over_depth.hpp).
struct OwnScalars {
    std::vector<int> properties = {};  ///< positions of parameters; as many as there are: the density
    bool strength = false;             ///< an undrained strength as it is now
};

/// The law that keeps these of another one; nullptr: there is none. Their names are its last history_names.
const LawInfo* find_law_over_depth(const LawInfo& law, const OwnScalars& scalars);

/// Whether a property may be each particle's own.
bool may_vary(const LawInfo& law, std::size_t property);

/// "su", or "density"; its scalar: that of this name, "density" being "initial_density".
const char* property_name(const LawInfo& law, std::size_t property);
int scalar_named(const LawInfo& law, std::string_view property);
/// Its position; -1: there is none.
int parameter_named(const LawInfo& law, std::string_view key);

/// Those of the program that a scene may name, in the order of the list.
std::vector<std::string> law_names();

/// A law in a file, which find_law() knows from now on, until the end: its name says its content, and what it points to
/// must last. Not for several threads.
void add_law(const LawInfo& law);

namespace detail {

template <class Real, class F, template <class> class First, template <class> class... Rest>
auto visit_law(LawList<First, Rest...>, int law, const double* values, F&& f) {
    if constexpr (sizeof...(Rest) > 0)
        if (law > 0) return visit_law<Real>(LawList<Rest...>{}, law - 1, values, std::forward<F>(f));
    return f(First<Real>(values));
}

}  // namespace detail

/// f(law) with the struct behind the name, which must be one of the program's; f returns the same type for every law.
template <class Real, class F>
auto with_law(const LawInfo& info, const double* values, F&& f) {
    if (info.of_file()) throw std::logic_error("a law in a file has no struct here");
    double all[max_parameters];
    const auto end = std::copy_n(values, info.parameters.size(), all);
    std::copy(info.tail.begin(), info.tail.end(), end);
    return detail::visit_law<Real>(Laws{}, info.position, all, std::forward<F>(f));
}

/// The same by name.
template <class Real, class F>
auto with_law(const std::string& name, const double* values, F&& f) {
    return with_law<Real>(*find_law(name), values, std::forward<F>(f));
}

}  // namespace moraine
