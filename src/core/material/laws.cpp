#include "core/material/laws.hpp"

#include <string_view>

namespace moraine {
namespace {

// The slurry's keys under their usual names; what is left out of Herschel-Bulkley's five values follows.
constexpr Parameter viscosity = {"viscosity", "Pa s", required, 0, unbounded, false, "plastic viscosity"};
constexpr Parameter bingham_parameters[] = {young_parameter, poisson_parameter, viscosity, yield_stress_parameter};
constexpr double bingham_tail[] = {1};  // exponent
constexpr Parameter newtonian_parameters[] = {young_parameter, poisson_parameter, viscosity};
constexpr double newtonian_tail[] = {0, 1};  // yield stress, exponent

template <template <class> class Law>
LawInfo describe(int position) {
    using L = Law<double>;
    static_assert(L::history <= max_history && std::size(L::parameters) <= max_parameters);
    LawInfo info{
        L::name,       L::parameters, L::history, {}, L::uses_left_stretch, position, {}, HasInitialState<L, double>,
        is_fluid<L>(), flows<L>()};
    if constexpr (L::history > 0) {
        static_assert(std::size(L::history_names) == L::history);
        info.history_names = L::history_names;
    }
    return info;
}

LawInfo renamed(LawInfo info, const char* name, std::span<const Parameter> parameters, std::span<const double> tail) {
    info.name = name;
    info.parameters = parameters;
    info.tail = tail;
    return info;
}

template <template <class> class... Law>
std::vector<LawInfo> describe_all(LawList<Law...>) {
    int position = 0;
    std::vector<LawInfo> table{describe<Law>(position++)...};
    const LawInfo slurry = *std::find_if(table.begin(), table.end(), [](const LawInfo& info) {
        return std::string(info.name) == HerschelBulkley<double>::name;
    });
    table.push_back(renamed(slurry, "bingham", bingham_parameters, bingham_tail));
    table.push_back(renamed(slurry, "newtonian", newtonian_parameters, newtonian_tail));
    return table;
}

const std::vector<LawInfo>& table() {
    static const std::vector<LawInfo> laws = describe_all(Laws{});
    return laws;
}

PointState<double, 3> undeformed(const Vec<double, 3>& stress) {
    PointState<double, 3> state{};
    state.left_stretch = undeformed_stretch<double, 3>();
    for (int k = 0; k < 3; ++k) state.stress[k] = stress[k];
    return state;
}

}  // namespace

const LawInfo* find_law(const std::string& name) {
    for (const LawInfo& info : table())
        if (name == info.name) return &info;
    return nullptr;
}

std::vector<std::string> law_names() {
    std::vector<std::string> names;
    for (const LawInfo& info : table()) names.emplace_back(info.name);
    return names;
}

double LawInfo::wave_modulus(const double* values, const BodyStart& start, const Vec<double, 3>& stress) const {
    return with_law<double>(*this, values, [&](const auto& law) {
        PointState<double, 3> state = undeformed(stress);
        begin_point(law, start, state);
        return law.wave_modulus(state);
    });
}

bool LawInfo::is_nearly_incompressible(const double* values) const {
    for (std::size_t k = 0; k < parameters.size(); ++k)
        if (parameters[k].key == std::string_view(poisson_parameter.key)) return values[k] >= 0.45;
    return false;
}

const char* LawInfo::problem_at_start(const double* values, const BodyStart& start,
                                      const Vec<double, 3>& stress) const {
    return with_law<double>(*this, values, [&](const auto& law) {
        PointState<double, 3> state = undeformed(stress);
        return begin_point(law, start, state);
    });
}

const char* LawInfo::problem(const double* values) const {
    // Static in the law, which is only built to reach it: derived constants of bad values are not used.
    double all[max_parameters];
    std::copy(tail.begin(), tail.end(), std::copy_n(values, parameters.size(), all));
    return with_law<double>(*this, values, [&all](const auto& law) { return law.problem(all); });
}

}  // namespace moraine
