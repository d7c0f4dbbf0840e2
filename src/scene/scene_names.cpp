#include "scene/scene_names.hpp"

#include <fmt/format.h>

#include <algorithm>

#include "io/input_error.hpp"
#include "scene/scene_keys.hpp"
#include "scene/scene_laws.hpp"
#include "scene/scene_set.hpp"
#include "scene/scene_values.hpp"

namespace moraine {
namespace {

/// "time.end", "material.NAME.density".
std::string full_name(const SceneKey& key) {
    if (key.table.empty()) return key.name;
    const std::size_t dot = key.table.find('.');
    std::string table = key.table;
    if (const std::string label = label_of_list(table.substr(0, dot)); !label.empty())
        table.insert(dot == std::string::npos ? table.size() : dot, label == "face" ? ".FACE" : ".NAME");
    return table + "." + key.name;
}

/// A law that is not known uses every key: its name is refused later.
bool is_used(const SceneKey& key, const toml::table& table) {
    if (key.table != "material" || key.only.empty()) return true;
    const auto law = table["law"].value<std::string>();
    return !law || (*law != "file" && !find_law(*law)) || key.only.front() == *law;
}

std::vector<std::string> valid_names(const toml::table& table, const std::string& section) {
    std::vector<std::string> names;
    const auto add = [&](const std::string& name) {
        if (std::find(names.begin(), names.end(), name) == names.end()) names.push_back(name);
    };
    if (section == "terrain") add("contact");
    for (const SceneKey& key : all_scene_keys()) {
        if (key.table == table_of_keys(section) && is_used(key, table)) add(key.name);
        const std::string prefix = section.empty() ? "" : section + ".";
        if (section != "material" && key.table != section && key.table.starts_with(prefix))
            add(key.table.substr(prefix.size(), key.table.find('.', prefix.size()) - prefix.size()));
    }
    if (const LawInfo* law = section == "material" ? law_of(table) : nullptr)
        for (const Parameter& parameter : law->parameters) add(parameter.key);
    return names;
}

std::string suggestion_for(const std::string& name, const std::string& path, const std::vector<std::string>& valid) {
    const std::string prefix = path.empty() ? "" : path + ".";
    if (path.empty())  // a key without its table
        for (const SceneKey& key : all_scene_keys())
            if (key.name == name) return fmt::format("Did you mean {}?", full_name(key));
    if (const std::string near = nearest(name, valid); !near.empty())
        return fmt::format("Did you mean {}{}?", prefix, near);
    std::vector<std::string> elsewhere;
    for (const SceneKey& key : all_scene_keys())
        if (name.size() <= longest_guess && edit_distance(key.name, name) <= static_cast<int>(name.size()) / 4)
            elsewhere.push_back(full_name(key));
    if (!elsewhere.empty()) return fmt::format("Did you mean {}?", elsewhere.front());
    return fmt::format("Use one of {}?", listed(valid));
}

/// A key that other laws have: what it is for is said, instead of a suggestion that would name the same key.
void refuse_other_law(const std::string& name, const std::string& full, const std::string& path,
                      const std::string& place) {
    std::vector<std::string> laws;
    for (const SceneKey& key : all_scene_keys())
        if (key.table == "material" && key.name == name) laws.insert(laws.end(), key.only.begin(), key.only.end());
    if (!laws.empty())
        refuse(place, fmt::format("{} is not used", full), "it is for law " + listed(laws),
               fmt::format("Remove it, or set {}.law?", path));
}

class NameCheck {
  public:
    explicit NameCheck(const std::string& file) : file_(file) {}

    void table(const toml::table& table, const std::string& section, const std::string& path) const {
        if (section == "material" && table["law"].value_or(std::string()) == "file" && !law_of(table))
            return;  // no source
        const std::vector<std::string> valid = valid_names(table, section);
        for (const auto& [key, node] : table) {
            const std::string name(key.str());
            const std::string full = path.empty() ? name : fmt::format("{}.{}", path, name);
            const std::string place = place_of(node, file_);
            if (std::find(valid.begin(), valid.end(), name) == valid.end()) {
                if (section == "material") refuse_other_law(name, full, path, place);
                refuse(place, fmt::format("{} is not a key", full), "no such key", suggestion_for(name, path, valid));
            }
            const std::string inner = section.empty() ? name : fmt::format("{}.{}", section, name);
            if (path.empty() && !label_of_list(name).empty())
                list(node, name);
            else if (is_table(inner) && (node.is_table() || !may_be_number(inner)))
                nested(node, inner, full);
        }
    }

  private:
    static bool is_table(const std::string& section) {
        const std::vector<SceneKey> keys = all_scene_keys();
        return std::any_of(keys.begin(), keys.end(),
                           [&](const SceneKey& key) { return key.table == table_of_keys(section); });
    }

    /// A property, whose table stands for a number.
    static bool may_be_number(const std::string& section) { return table_of_keys(section) == "material.su"; }

    void nested(const toml::node& node, const std::string& section, const std::string& path) const {
        if (!node.is_table())
            refuse(place_of(node, file_), fmt::format("{} is {}", path, kind_of(node)), "must be a table",
                   fmt::format("Write {}.KEY = VALUE, with a key of inputs/reference.toml?", path));
        table(*node.as_table(), section, path);
    }

    void list(const toml::node& node, const std::string& name) const {
        if (!node.is_array())
            refuse(place_of(node, file_), fmt::format("{} is {}", name, kind_of(node)), "must be a list of tables",
                   fmt::format("Write [[{}]]?", name));
        int number = 0;
        for (const toml::node& item : *node.as_array())
            if (item.is_table())
                table(*item.as_table(), name, name + "." + label_of(*item.as_table(), name, ++number));
            else
                nested(item, name, name);
    }

    const std::string& file_;
};

}  // namespace

void refuse_unknown_keys(const toml::table& root, const std::string& file) {
    NameCheck(file).table(root, "", "");
}

std::string label_of(const toml::table& table, const std::string& list, int number) {
    return table[label_of_list(list)].value_or(std::to_string(number));
}

}  // namespace moraine
