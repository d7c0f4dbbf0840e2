#include "core/material/laws.hpp"

#include <deque>
#include <string_view>

namespace moraine {
namespace {

// The slurry's keys under their usual names; what is left out of Herschel-Bulkley's five values follows.
constexpr Parameter viscosity = {"viscosity", "Pa s", required, 0, unbounded, false, "plastic viscosity"};
constexpr Parameter bingham_parameters[] = {young_parameter, poisson_parameter, viscosity, yield_stress_parameter};
constexpr double bingham_tail[] = {1};  // exponent
constexpr Parameter newtonian_parameters[] = {young_parameter, poisson_parameter, viscosity};
constexpr double newtonian_tail[] = {0, 1};  // yield stress, exponent

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

/// Laws in files.
std::deque<LawInfo>& added() {
    static std::deque<LawInfo> laws;
    return laws;
}

/// The values of the struct's constructor.
struct AllValues {
    double all[max_parameters];

    AllValues(const LawInfo& law, const double* values) {
        std::copy(law.tail.begin(), law.tail.end(), std::copy_n(values, law.parameters.size(), all));
    }
};

}  // namespace

const LawInfo* find_law(const std::string& name) {
    for (const LawInfo& info : table())
        if (name == info.name) return &info;
    for (const LawInfo& info : added())
        if (name == info.name) return &info;
    return nullptr;
}

void add_law(const LawInfo& law) {
    added().push_back(law);
}

std::vector<std::string> law_names() {
    std::vector<std::string> names;
    for (const LawInfo& info : table())
        if (!info.uniform) names.emplace_back(info.name);
    return names;
}

const LawInfo* find_law_over_depth(const LawInfo& law, std::size_t parameter) {
    for (const LawInfo& info : table())
        if (info.uniform && std::string_view(info.uniform) == law.name && info.varying == static_cast<int>(parameter))
            return &info;
    return nullptr;
}

double LawInfo::wave_modulus(const double* values, const BodyStart& start, const Vec<double, 3>& stress) const {
    return calls.wave_modulus(AllValues(*this, values).all, start, stress);
}

bool LawInfo::is_nearly_incompressible(const double* values) const {
    for (std::size_t k = 0; k < parameters.size(); ++k)
        if (parameters[k].key == std::string_view(poisson_parameter.key)) return values[k] >= 0.45;
    return false;
}

const char* LawInfo::problem_at_start(const double* values, const BodyStart& start,
                                      const Vec<double, 3>& stress) const {
    return calls.problem_at_start(AllValues(*this, values).all, start, stress);
}

const char* LawInfo::problem(const double* values) const {
    return calls.problem(AllValues(*this, values).all);
}

}  // namespace moraine
