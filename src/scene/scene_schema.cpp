#include "scene/scene_schema.hpp"

#include <fmt/format.h>
#include <toml++/toml.h>

#include <algorithm>
#include <cmath>
#include <utility>

#include "scene/scene_keys.hpp"
#include "scene/scene_set.hpp"

namespace moraine {
namespace {

using Named = Json::Named;
using List = Json::List;

Json as_json(const toml::node& node) {
    if (const auto* text = node.as_string()) return text->get();
    if (const auto* whole = node.as_integer()) return whole->get();
    if (const auto* real = node.as_floating_point()) return real->get();
    if (const auto* truth = node.as_boolean()) return truth->get();
    List items;
    for (const toml::node& item : *node.as_array()) items.push_back(as_json(item));
    return items;
}

Named number_of(const char* type, const KeyRange& range) {
    Named out{{"type", type}};
    if (std::isfinite(range.lower)) out.emplace_back(range.open_lower ? "exclusiveMinimum" : "minimum", range.lower);
    if (std::isfinite(range.upper)) out.emplace_back(range.open_upper ? "exclusiveMaximum" : "maximum", range.upper);
    return out;
}

Named list_of(Json items, int least, int most = 0) {
    Named out{{"type", "array"}, {"items", std::move(items)}};
    if (least > 0) out.emplace_back("minItems", least);
    if (most > 0) out.emplace_back("maxItems", most);
    return out;
}

/// What a list of strings may name; empty: anything.
std::vector<std::string> choices_of(const SceneKey& key) {
    if (key.table != "output" || key.name != "fields") return key.choices;
    Scene all;
    all.water.on = true;
    for (const std::string& name : law_names()) {
        const LawInfo& law = *find_law(name);
        all.materials.emplace_back().law = name;
        OwnScalars own;
        for (std::size_t k = 0; k <= law.parameters.size(); ++k)
            if (may_vary(law, k)) own.properties.push_back(static_cast<int>(k));
        for (const bool strength : {true, false}) {
            own.strength = strength;
            if (const LawInfo* over = find_law_over_depth(law, own)) all.materials.emplace_back().law = over->name;
        }
    }
    return output_field_names(all);
}

Named strings_of(const std::vector<std::string>& choices) {
    Named out{{"type", "string"}};
    if (!choices.empty()) out.emplace_back("enum", choices);
    return out;
}

Named schema_of_profile();

Named type_of(const SceneKey& key) {
    const Named number = number_of("number", key.range);
    switch (key.type) {
        case KeyType::text:
            return {{"type", "string"}};
        case KeyType::name:
            return {{"type", "string"}, {"pattern", "^[A-Za-z0-9_-]+$"}, {"maxLength", 64}};
        case KeyType::choice:
            return strings_of(key.choices);
        case KeyType::real:
            return number;
        case KeyType::real_or_text:
            return {{"anyOf", List{number, Named{{"type", "string"}}}}};
        case KeyType::real_or_choice:
            return {{"anyOf", List{number, strings_of(key.choices)}}};
        case KeyType::real_or_profile:
            return {{"anyOf", List{number, schema_of_profile()}}};
        case KeyType::integer:
            return number_of("integer", key.range);
        case KeyType::integer_or_choice:
            return {{"anyOf", List{number_of("integer", key.range), strings_of(key.choices)}}};
        case KeyType::vector:
            return list_of(number, 2, 3);
        case KeyType::pair:
            return list_of(number, 2, 2);
        case KeyType::per_axis: {
            const Named whole = number_of("integer", key.range);
            return {{"anyOf", List{whole, list_of(whole, 2, 3)}}};
        }
        case KeyType::axes:
            return list_of(strings_of({"x", "y", "z"}), 0);
        case KeyType::words:
            return list_of(strings_of(choices_of(key)), 0);
        case KeyType::points:
            return list_of(list_of(number, 2, 2), 3);
        case KeyType::line:
            return list_of(list_of(number, 2, 2), 2);
        case KeyType::list:
            return list_of(number, 0);
        case KeyType::truth:
            return {{"type", "boolean"}};
        case KeyType::settings:
            return {{"type", "object"}};
    }
    return {};
}

Named schema_of(const SceneKey& key) {
    Named out{{"description", describe(key)}};
    for (auto& part : type_of(key)) out.push_back(std::move(part));
    if (key.standard && !key.standard->empty() && key.type != KeyType::vector)  // as many numbers as dimensions
        out.emplace_back("default", as_json(*toml::parse("v = " + *key.standard).get("v")));
    return out;
}

bool has(const Named& named, const std::string& name) {
    return std::any_of(named.begin(), named.end(), [&](const auto& entry) { return entry.first == name; });
}

/// A table under construction: what all its values of the selector have, and what one of them has.
class Table {
  public:
    explicit Table(std::string section) : section_(std::move(section)) {
        const std::string selector = selector_of(table_of_keys(section_));
        for (const SceneKey& key : all_scene_keys()) {
            if (key.table != table_of_keys(section_)) continue;
            add(key);
            if (key.name == selector) values_ = key.choices;
        }
        for (const std::string& value : values_) conditions_.push_back(condition(selector, value));
    }

    void add_table(const std::string& name, Json schema, bool required) {
        properties_.emplace_back(name, std::move(schema));
        if (required) required_.emplace_back(name);
    }

    /// Whether a scene must have it.
    bool has_required() const { return !required_.empty(); }

    Named schema() const {
        Named out{{"type", "object"}, {"additionalProperties", section_ == "material"}, {"properties", properties_}};
        if (!required_.empty()) out.emplace_back("required", required_);
        if (!conditions_.empty()) out.emplace_back("allOf", conditions_);
        return out;
    }

  private:
    /// A key of several laws has bounds in the conditions alone.
    void add(const SceneKey& key) {
        const bool everywhere = key.only.empty();
        if (everywhere && key.required()) required_.emplace_back(key.name);
        if (!everywhere) some_.push_back(key);
        if (has(properties_, key.name)) return;
        SceneKey shown = key;
        if (!everywhere && key.table == "material") shown.range = {}, shown.standard.reset();
        Named schema = schema_of(shown);
        if (!everywhere && key.table == "material") schema.front().second = type_text(key) + ". " + key.meaning;
        properties_.emplace_back(key.name, schema);
    }

    /// With this value: the keys that it uses, and no key that it does not. A law in a file has any.
    Json condition(const std::string& selector, const std::string& value) const {
        Named used, refused;
        List required;
        for (const SceneKey& key : some_) {
            if (std::find(key.only.begin(), key.only.end(), value) == key.only.end()) continue;
            used.emplace_back(key.name, key.table == "material" ? Json(schema_of(key)) : Json(true));
            if (key.required()) required.emplace_back(key.name);
        }
        for (const SceneKey& key : some_)
            if (value != "file" && !has(used, key.name) && !has(refused, key.name))
                refused.emplace_back(key.name, false);
        used.insert(used.end(), refused.begin(), refused.end());
        const Json chosen = Named{{"const", value}};
        Named then{{"properties", used}};
        if (!required.empty()) then.emplace_back("required", required);
        if (section_ == "material" && value != "file") then.emplace_back("propertyNames", Named{{"enum", names()}});
        return Named{{"if", Named{{"properties", Named{{selector, chosen}}}, {"required", List{selector}}}},
                     {"then", then}};
    }

    List names() const {
        List all;
        for (const auto& [name, schema] : properties_) all.emplace_back(name);
        return all;
    }

    std::string section_;
    std::vector<std::string> values_;  ///< of the selector
    std::vector<SceneKey> some_;       ///< keys that only some values use
    Named properties_;
    List required_, conditions_;
};

constexpr const char* profile_section = "material.su";

Named schema_of_profile() {
    return Table(profile_section).schema();
}

/// Tables of the scene, by the dots of their names: those within another one follow it.
std::vector<std::string> sections_in(const std::string& outer) {
    const std::string prefix = outer.empty() ? "" : outer + ".";
    std::vector<std::string> names;
    for (const SceneKey& key : all_scene_keys()) {
        if (key.table == outer || key.table.empty() || !key.table.starts_with(prefix)) continue;
        if (key.table == profile_section) continue;  // within the keys that it may stand for
        const std::string name = key.table.substr(0, key.table.find('.', prefix.size()));
        if (std::find(names.begin(), names.end(), name) == names.end()) names.push_back(name);
    }
    if (outer == "terrain") names.emplace_back("terrain.contact");
    return names;
}

Table table_of(const std::string& section) {
    Table table(section);
    for (const std::string& inner : sections_in(section)) {
        const Table part = table_of(inner);
        const bool listed = section.empty() && !label_of_list(inner).empty();
        const std::string name = inner.substr(section.empty() ? 0 : section.size() + 1);
        const bool wanted =
            section.empty() && !listed && inner != "hazard" && inner != "shaking" && part.has_required();
        table.add_table(name, listed ? list_of(part.schema(), 0) : part.schema(), wanted);
    }
    return table;
}

}  // namespace

Json scene_schema() {
    Named out{{"$schema", "http://json-schema.org/draft-07/schema#"}, {"title", "a scene of Moraine"}};
    for (auto& part : table_of("").schema()) out.push_back(std::move(part));
    return out;
}

}  // namespace moraine
