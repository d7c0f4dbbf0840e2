#include "scene/scene_keys.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <cctype>
#include <cmath>
#include <string_view>

#include "io/input_error.hpp"
#include "scene/scene_stages.hpp"
#include "scene/scene_tables.hpp"
#include "scene/scene_tractions.hpp"

namespace moraine {
namespace {

template <class Target>
void append(std::vector<SceneKey>& keys, const std::vector<KeyRow<Target>>& rows) {
    for (const auto& row : rows) keys.push_back(row.key);
}

std::vector<std::string> in_quotes(const std::vector<std::string>& words) {
    std::vector<std::string> out;
    out.reserve(words.size());
    for (const std::string& word : words) out.push_back(quote(word));
    return out;
}

}  // namespace

Triple KeyValue::triple() const {
    Triple t{};
    for (std::size_t a = 0; a < numbers.size() && a < 3; ++a) t[a] = numbers[a];
    return t;
}

SceneKey parameter_key(const LawInfo& law, const Parameter& parameter) {
    SceneKey key{.table = "material", .name = parameter.key, .unit = parameter.unit};
    const auto position = static_cast<std::size_t>(parameter_named(law, parameter.key));
    if (may_vary(law, position)) key.type = KeyType::real_or_profile;
    if (!std::isnan(parameter.standard)) key.standard = shortest(parameter.standard);
    key.range = {parameter.lower, parameter.upper, parameter.open, parameter.open};
    key.only = {law.name};
    key.meaning = std::string(parameter.meaning) + ".";
    if (std::isalpha(static_cast<unsigned char>(key.meaning[1])))  // a word, not a symbol
        key.meaning[0] = static_cast<char>(std::toupper(static_cast<unsigned char>(key.meaning[0])));
    return key;
}

std::vector<SceneKey> all_scene_keys() {
    std::vector<SceneKey> keys;
    append(keys, scene_rows());
    append(keys, time_rows());
    append(keys, table_rows());
    append(keys, shaking_rows());
    append(keys, water_rows());
    append(keys, material_rows());
    for (const std::string& name : law_names()) {
        const LawInfo& law = *find_law(name);
        for (const Parameter& parameter : law.parameters) keys.push_back(parameter_key(law, parameter));
    }
    append(keys, profile_rows());
    append(keys, body_rows());
    append(keys, wall_rows());
    append(keys, terrain_rows());
    append(keys, hazard_rows());
    append(keys, release_rows());
    append(keys, inflow_rows());
    append(keys, structure_rows());
    append(keys, traction_rows());
    append(keys, stage_rows());
    return keys;
}

std::string table_of_keys(const std::string& table) {
    constexpr std::string_view outer = "material.";
    if (table.starts_with(outer))
        for (const std::string& name : law_names()) {
            const LawInfo& law = *find_law(name);
            for (std::size_t k = 0; k <= law.parameters.size(); ++k)
                if (may_vary(law, k) && table.substr(outer.size()) == property_name(law, k)) return "material.su";
        }
    return table == "terrain.contact" ? "structure.contact" : table;
}

std::string selector_of(const std::string& table) {
    if (table == "body") return "shape";
    if (table == "material") return "law";
    if (table == "wall" || table == "structure.motion") return "kind";
    if (table == "structure") return "shape";
    if (table == "structure.contact") return "law";
    return "";
}

std::vector<std::string> output_field_names(const Scene& scene) {
    std::vector<std::string> names{"velocity", "stress", "pressure", "density", "ln_J", "mass", "volume", "body"};
    if (scene.water.on) names.insert(names.end(), {"pore_pressure", "porosity", "darcy_velocity"});
    for (const MaterialSpec& material : scene.materials)
        if (const LawInfo* law = find_law(material.law))
            for (const char* name : law->history_names)
                if (std::find(names.begin(), names.end(), name) == names.end()) names.emplace_back(name);
    return names;
}

std::string range_text(const KeyRange& range) {
    const bool below = std::isfinite(range.lower);
    const bool above = std::isfinite(range.upper);
    if (below && above)
        return fmt::format("in {}{}, {}{}", range.open_lower ? '(' : '[', range.lower, range.upper,
                           range.open_upper ? ')' : ']');
    if (below) return fmt::format("{} {}", range.open_lower ? ">" : ">=", range.lower);
    if (above) return fmt::format("{} {}", range.open_upper ? "<" : "<=", range.upper);
    return "";
}

std::string type_text(const SceneKey& key) {
    const std::string unit = key.unit == "-" ? "" : fmt::format(" [{}]", key.unit);
    switch (key.type) {
        case KeyType::text:
            return "a string";
        case KeyType::name:
            return "a name (at most 64 letters, digits, _ and -)";
        case KeyType::choice:
            return "one of " + listed(in_quotes(key.choices));
        case KeyType::real:
            return "a number" + unit;
        case KeyType::real_or_text:
            return "a number" + unit + " or a string";
        case KeyType::real_or_choice:
            return "a number" + unit + " or " + listed(in_quotes(key.choices));
        case KeyType::real_or_profile:
            return "a number or a profile" + unit;
        case KeyType::integer:
            return "a whole number" + unit;
        case KeyType::integer_or_choice:
            return listed(in_quotes(key.choices)) + ", or a whole number" + unit;
        case KeyType::vector:
            return "one number for each dimension" + unit;
        case KeyType::pair:
            return "two rising numbers" + unit;
        case KeyType::per_axis:
            return "a whole number or one for each dimension" + unit;
        case KeyType::axes:
            return "a list of \"x\", \"y\", \"z\"";
        case KeyType::words:
            return "a list of strings";
        case KeyType::points:
            return "a list of at least three [x, y]" + unit;
        case KeyType::line:
            return "a list of at least two [x, y]" + unit;
        case KeyType::list:
            return "a list of numbers" + unit;
        case KeyType::truth:
            return "true or false";
        case KeyType::settings:
            return "a table of keys and values";
    }
    return "";
}

std::string describe(const SceneKey& key) {
    std::string text = type_text(key);
    if (const std::string range = range_text(key.range); !range.empty()) text += " " + range;
    // A law's keys stand under their law, which says who uses them.
    if (!key.only.empty() && key.table != "material")
        text += fmt::format(", for {} {}", selector_of(key.table), fmt::join(key.only, ", "));
    if (key.required())
        text += "; required";
    else if (!key.standard->empty())
        text += "; default " + *key.standard;
    else
        text += "; no default";
    text[0] = static_cast<char>(std::toupper(static_cast<unsigned char>(text[0])));
    return text + ". " + key.meaning;
}

}  // namespace moraine
