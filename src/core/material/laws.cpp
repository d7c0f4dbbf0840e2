#include "core/material/laws.hpp"

#include <deque>
#include <string_view>

#include "core/material/own_properties.hpp"

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

constexpr const char* density_scalar = "initial_density";
constexpr const char* strength_scalar = "strength";

/// What a law over depth that is described once points to, by its mask: these last.
struct MaskedLaw {
    std::string name;
    std::vector<const char*> scalars;
    double mask;
};

/// Bits of the mask: the law's parameters over depth, density, strength.
std::vector<const char*> names_of_bits(const LawInfo& law) {
    std::vector<const char*> names;
    for (const int parameter : law.over_depth) names.push_back(law.parameters[static_cast<std::size_t>(parameter)].key);
    names.push_back(density_scalar);
    names.push_back(strength_scalar);
    return names;
}

/// The law over depth of one mask.
LawInfo masked(LawInfo law, const LawInfo& uniform, int mask) {
    static std::deque<MaskedLaw> kept;
    MaskedLaw& own = kept.emplace_back();
    own.mask = mask;
    own.scalars.assign(uniform.history_names.begin(), uniform.history_names.end());
    const std::vector<const char*> bits = names_of_bits(law);
    for (std::size_t k = 0; k < bits.size(); ++k) {
        if ((mask >> k & 1) == 0) continue;
        own.name += (own.name.empty() ? "" : ", ") + std::string(bits[k]);
        own.scalars.push_back(bits[k]);
    }
    own.name = std::string(uniform.name) + " over depth (" + own.name + ")";
    law.name = own.name.c_str();
    law.history = static_cast<int>(own.scalars.size());
    law.history_names = own.scalars;
    law.tail = {&own.mask, 1};
    return law;
}

/// In place of the one struct of laws over depth its names by masks.
std::vector<LawInfo> with_masks(const std::vector<LawInfo>& laws) {
    std::vector<LawInfo> all;
    for (const LawInfo& law : laws) {
        if (!law.uniform) all.push_back(law);
        for (int mask = 1; law.uniform && mask < law.masks; ++mask) {
            const auto uniform = std::find_if(laws.begin(), laws.end(), [&](const LawInfo& other) {
                return std::string_view(other.name) == law.uniform && !other.uniform;
            });
            all.push_back(masked(law, *uniform, mask));
        }
    }
    return all;
}

template <template <class> class... Law>
std::vector<LawInfo> describe_all(LawList<Law...>) {
    int position = 0;
    std::vector<LawInfo> table = with_masks({describe<Law>(position++)...});
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

const LawInfo* find_law_over_depth(const LawInfo& law, const OwnScalars& scalars) {
    const int density = static_cast<int>(law.over_depth.size());
    int mask = scalars.strength ? 1 << (density + 1) : 0;
    for (const int property : scalars.properties) {
        const auto at = std::find(law.over_depth.begin(), law.over_depth.end(), property);
        if (at == law.over_depth.end() && property != static_cast<int>(law.parameters.size())) return nullptr;
        mask |= 1 << (at - law.over_depth.begin());
    }
    for (const LawInfo& info : table())
        if (info.uniform && std::string_view(info.uniform) == law.name && info.tail[0] == mask) return &info;
    return nullptr;
}

bool may_vary(const LawInfo& law, std::size_t property) {
    return find_law_over_depth(law, {.properties = {static_cast<int>(property)}}) != nullptr;
}

const char* property_name(const LawInfo& law, std::size_t property) {
    return property < law.parameters.size() ? law.parameters[property].key : "density";
}

int scalar_named(const LawInfo& law, std::string_view property) {
    const std::string_view wanted = property == "density" ? density_scalar : property;
    for (std::size_t k = 0; k < law.history_names.size(); ++k)
        if (law.history_names[k] == wanted) return static_cast<int>(k);
    return -1;
}

int parameter_named(const LawInfo& law, std::string_view key) {
    for (std::size_t k = 0; k < law.parameters.size(); ++k)
        if (law.parameters[k].key == key) return static_cast<int>(k);
    return -1;
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
