#include "scene/scene_set.hpp"

#include <fmt/format.h>

#include "io/input_error.hpp"
#include "scene/scene_file.hpp"
#include "scene/scene_keys.hpp"

namespace moraine {
namespace {

/// `text` as the only value of a document whose place is `place`; an empty document if it is not TOML.
toml::table parse_value(const std::string& text, const std::string& place) {
    try {
        toml::table parsed = toml::parse("v = " + text, place);
        if (parsed.size() == 1) return parsed;
    } catch (const toml::parse_error&) {
        // Not TOML: a string without its quotes.
    }
    return {};
}

/// Moves the value, so that it keeps its place.
void put(toml::table& table, const std::string& key, toml::table parsed) {
    parsed.get("v")->visit([&](auto& value) { table.insert_or_assign(key, std::move(value)); });
}

std::vector<std::string> split(const std::string& path) {
    std::vector<std::string> parts(1);
    for (const char c : path)
        if (c == '.')
            parts.emplace_back();
        else
            parts.back() += c;
    return parts;
}

toml::table& member(toml::table& table, const std::string& key, const std::string& place) {
    if (!table.contains(key)) put(table, key, parse_value("{}", place));
    toml::node& node = *table.get(key);
    if (!node.is_table()) refuse(place, fmt::format("{} has no keys", key), "it is a value", "Set it as a whole?");
    return *node.as_table();
}

/// The table of a list whose label is `name`. A wall that is not there yet is made.
toml::table& listed_member(toml::table& root, const std::string& list, const std::string& name,
                           const std::string& place) {
    const std::string label = label_of_list(list);
    if (list == "wall" && !root.contains(list)) root.insert(list, toml::array{});
    std::vector<std::string> names;
    toml::array* items = root.contains(list) ? root.get(list)->as_array() : nullptr;
    if (items) {
        for (toml::node& item : *items) {
            toml::table* table = item.as_table();
            const auto found = table ? (*table)[label].value<std::string>() : std::nullopt;
            if (found == name) return *table;
            if (found) names.push_back(*found);
        }
        if (list == "wall") {
            toml::table wall = std::move(*parse_value("{}", place).get("v")->as_table());
            put(wall, label, parse_value(quote(name), place));
            items->push_back(std::move(wall));
            return *items->back().as_table();
        }
    }
    refuse(place, fmt::format("there is no {} {}", list, quote(name)),
           names.empty() ? "the scene has none" : "no such " + label,
           names.empty() ? fmt::format("Write one as [[{}]]?", list) : suggest(name, names));
}

}  // namespace

std::string label_of_list(const std::string& table) {
    if (table == "wall") return "face";
    return table == "material" || table == "body" || table == "structure" || table == "release" || table == "inflow" ||
                   table == "table" || table == "stage" || table == "traction"
               ? "name"
               : "";
}

void apply_set(toml::table& root, const std::string& assignment, const std::string& by) {
    const std::string place = by + " " + assignment;
    const std::size_t equals = assignment.find('=');
    if (equals == std::string::npos || equals == 0)
        refuse(place, "no key", "must be KEY=VALUE", "Did you mean --set time.end=1?");
    const std::vector<std::string> parts = split(assignment.substr(0, equals));
    const std::string text = assignment.substr(equals + 1);
    if (parts.size() > deepest_key)
        refuse(place, "the key is too deep", fmt::format("more than {} levels", deepest_key),
               "Is it a key of inputs/reference.toml?");
    refuse_deep_keys(text, place);

    toml::table* table = &root;
    std::size_t next = 0;
    if (!label_of_list(parts[0]).empty()) {
        if (parts.size() < 3)
            refuse(
                place, fmt::format("{} is a list", parts[0]), "it has one table per " + label_of_list(parts[0]),
                fmt::format("Write {}.{}.KEY=VALUE?", parts[0], label_of_list(parts[0]) == "face" ? "FACE" : "NAME"));
        table = &listed_member(root, parts[0], parts[1], place);
        next = 2;
    }
    for (; next + 1 < parts.size(); ++next) table = &member(*table, parts[next], place);
    toml::table value = parse_value(text, place);
    put(*table, parts.back(), value.empty() ? parse_value(quote(text), place) : std::move(value));
}

}  // namespace moraine
