#include "scene/scene_values.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <sstream>

#include "core/data/error.hpp"

namespace moraine {
namespace {

constexpr std::size_t longest_name = 64;  // of a link in a checkpoint 255 is the most, "structure_NAME" and more

std::string text_of(const toml::node& node) {
    std::ostringstream out;
    node.visit([&](const auto& n) { out << n; });
    return out.str();
}

/// The value without its quotes, when that is what the key needs.
std::string without_quotes(const toml::node& node) {
    const auto* text = node.as_string();
    if (!text) return "";
    try {
        const toml::table parsed = toml::parse("v = " + text->get());
        return parsed.size() == 1 && parsed.get("v")->is_number() ? text->get() : "";
    } catch (const toml::parse_error&) {
        return "";
    }
}

/// The key's default as a scene of so many dimensions writes it.
std::string standard_text(const SceneKey& key, int dimensions) {
    if (key.type != KeyType::vector) return *key.standard;
    std::vector<std::string> numbers;
    for (const double x : standard_value(key, dimensions).numbers) numbers.push_back(shortest(x));
    return fmt::format("[{}]", listed(numbers));
}

/// Of the two files that have every key, the one that has this.
std::string look_up(const SceneKey& key) {
    const std::string table = key.table.substr(0, key.table.find('.'));
    const bool terrain = table == "terrain" || table == "hazard" || table == "release" || table == "inflow" ||
                         (table == "structure" && key.name == "xi");
    return fmt::format("Look up {} in inputs/reference{}.toml?", key.name, terrain ? "_terrain" : "");
}

[[noreturn]] void refuse_type(const toml::node& node, const KeyContext& c) {
    const bool number =
        c.key.type == KeyType::real || c.key.type == KeyType::integer || c.key.type == KeyType::integer_or_choice;
    const std::string bare = number ? without_quotes(node) : "";
    const std::string help =
        !bare.empty() ? fmt::format("Did you mean {}, without quotes?", bare)
        : c.key.standard && !c.key.standard->empty()
            ? fmt::format("Write it as in {} = {}?", c.key.name, standard_text(c.key, c.dimensions))
            : look_up(c.key);
    refuse(c.place, fmt::format("{} is {}", c.path, kind_of(node)), "must be " + type_text(c.key), help);
}

std::string mended(double value, const SceneKey& key, int dimensions) {
    const KeyRange& range = key.range;
    if (std::isfinite(value) && value < 0 && range.lower == 0 && range.holds(-value))
        return fmt::format("Did you mean {}?", shortest(-value));
    if (key.standard && !key.standard->empty() && key.type != KeyType::per_axis)
        return fmt::format("Did you mean {}, the default?", standard_text(key, dimensions));
    const bool low = !(value > range.lower);
    const double bound = low ? range.lower : range.upper;
    if (bound != 0 && std::isfinite(bound)) {
        const bool open = low ? range.open_lower : range.open_upper;
        return fmt::format("Did you mean {}?", shortest(open ? bound + (low ? 0.01 : -0.01) : bound));
    }
    return look_up(key);
}

double checked(double value, const KeyContext& c) {
    if (!std::isfinite(value))
        refuse(c.place, fmt::format("{} = {}", c.path, value), "must be a finite number",
               mended(value, c.key, c.dimensions));
    if (!c.key.range.holds(value))
        refuse(c.place, fmt::format("{} = {}", c.path, shortest(value)), "must be " + range_text(c.key.range),
               mended(value, c.key, c.dimensions));
    return value;
}

double real(const toml::node& node, const KeyContext& c) {
    if (!node.is_number()) refuse_type(node, c);
    return checked(*node.value<double>(), c);
}

std::int64_t integer(const toml::node& node, const KeyContext& c) {
    if (!node.is_integer()) refuse_type(node, c);
    const std::int64_t value = node.as_integer()->get();
    checked(static_cast<double>(value), c);
    return value;
}

std::string string(const toml::node& node, const KeyContext& c) {
    if (!node.is_string()) refuse_type(node, c);
    return node.as_string()->get();
}

void real_or_text(const toml::node& node, const KeyContext& c, KeyValue& value) {
    if (c.key.type == KeyType::real_or_text && node.is_string())
        value.text = string(node, c);
    else
        value.real = real(node, c);
}

/// One of the words, or else a number, whole or not by the type.
void number_or_choice(const toml::node& node, const KeyContext& c, KeyValue& value) {
    const std::vector<std::string>& words = c.key.choices;
    const auto word = std::find(words.begin(), words.end(), node.value_or(std::string()));
    if (word != words.end())
        value.choice = static_cast<int>(word - words.begin());
    else if (c.key.type == KeyType::real_or_choice)
        value.real = real(node, c);
    else
        value.integer = integer(node, c);
}

std::string name(const toml::node& node, const KeyContext& c) {
    std::string text = string(node, c);
    if (text.size() > longest_name)
        refuse(c.place, fmt::format("{} has {} characters", c.path, text.size()),
               fmt::format("a name has at most {}", longest_name), "Shorten it?");
    const auto plain = [](unsigned char ch) { return std::isalnum(ch) || ch == '_' || ch == '-'; };
    if (text.empty() || !std::all_of(text.begin(), text.end(), plain))
        refuse(c.place, fmt::format("{} = {}", c.path, quote(text)), "must be letters, digits, _ and -", "Rename it?");
    return text;
}

int choice(const toml::node& node, const KeyContext& c, const std::vector<std::string>& choices) {
    const std::string text = string(node, c);
    const auto found = std::find(choices.begin(), choices.end(), text);
    if (found == choices.end())
        refuse(c.place, fmt::format("{} = {}", c.path, quote(text)), "must be one of " + listed(choices),
               suggest(text, choices));
    return static_cast<int>(found - choices.begin());
}

const toml::array& array(const toml::node& node, const KeyContext& c) {
    if (!node.is_array()) refuse_type(node, c);
    return *node.as_array();
}

std::vector<double> numbers(const toml::node& node, const KeyContext& c, int count) {
    const toml::array& list = array(node, c);
    if (static_cast<int>(list.size()) != count)
        refuse(c.place, fmt::format("{} has {} number{}", c.path, list.size(), list.size() == 1 ? "" : "s"),
               "must be " + type_text(c.key), fmt::format("Give {}?", count));
    std::vector<double> out;
    for (const toml::node& item : list)
        out.push_back(c.key.type == KeyType::per_axis ? static_cast<double>(integer(item, c)) : real(item, c));
    return out;
}

std::vector<double> per_axis(const toml::node& node, const KeyContext& c) {
    if (node.is_array()) return numbers(node, c, c.dimensions);
    return std::vector<double>(static_cast<std::size_t>(c.dimensions), static_cast<double>(integer(node, c)));
}

std::vector<double> pair(const toml::node& node, const KeyContext& c) {
    std::vector<double> ends = numbers(node, c, 2);
    if (!(ends[0] < ends[1]))
        refuse(c.place, fmt::format("{} = {}", c.path, text_of(node)), "must be two rising numbers", "Exchange them?");
    return ends;
}

const std::vector<std::string> axis_names{"x", "y", "z"};

std::vector<std::array<double, 2>> points(const toml::node& node, const KeyContext& c, std::size_t least) {
    const toml::array& list = array(node, c);
    if (list.size() < least)
        refuse(c.place, fmt::format("{} has {} points", c.path, list.size()), "must be " + type_text(c.key),
               "Add the missing corners?");
    std::vector<std::array<double, 2>> out;
    for (const toml::node& item : list) {
        const std::vector<double> xy = numbers(item, c, 2);
        out.push_back({xy[0], xy[1]});
    }
    return out;
}

/// "material.clay.su=2000.0", however its dots are written.
void add_settings(const toml::table& table, const std::string& prefix, std::vector<std::string>& all) {
    for (const auto& [key, node] : table) {
        const std::string path = prefix + std::string(key.str());
        if (const toml::table* inner = node.as_table())
            add_settings(*inner, path + ".", all);
        else
            all.push_back(path + "=" + text_of(node));
    }
}

std::vector<std::string> settings(const toml::node& node, const KeyContext& c) {
    if (!node.is_table()) refuse_type(node, c);
    std::vector<std::string> all;
    add_settings(*node.as_table(), "", all);
    return all;
}

std::vector<std::string> strings(const toml::node& node, const KeyContext& c) {
    std::vector<std::string> all;
    for (const toml::node& item : array(node, c)) all.push_back(string(item, c));
    return all;
}

bool truth(const toml::node& node, const KeyContext& c) {
    if (!node.is_boolean()) refuse_type(node, c);
    return node.as_boolean()->get();
}

}  // namespace

std::string place_of(const toml::node& node, const std::string& file) {
    const toml::source_region& source = node.source();
    if (source.path && (source.path->starts_with("--set") || source.path->starts_with("stage."))) return *source.path;
    if (source.begin.line == 0) return file;
    return fmt::format("{}:{}", file, source.begin.line);
}

std::string kind_of(const toml::node& node) {
    if (node.is_string()) return "a string";
    if (node.is_integer()) return fmt::format("the whole number {}", node.as_integer()->get());
    if (node.is_floating_point()) return fmt::format("the number {}", node.as_floating_point()->get());
    if (node.is_boolean()) return node.as_boolean()->get() ? "true" : "false";
    if (node.is_array()) return "a list";
    if (node.is_table()) return "a table";
    return "a date or time";
}

KeyValue read_value(const toml::node& node, const KeyContext& c) {
    KeyValue value;
    switch (c.key.type) {
        case KeyType::text:
        case KeyType::name:
            value.text = c.key.type == KeyType::name ? name(node, c) : string(node, c);
            break;
        case KeyType::choice:
            value.choice = choice(node, c, c.key.choices);
            value.text = c.key.choices[static_cast<std::size_t>(value.choice)];
            break;
        case KeyType::real:
        case KeyType::real_or_text:
        case KeyType::real_or_profile:
            real_or_text(node, c, value);
            break;
        case KeyType::real_or_choice:
        case KeyType::integer:
        case KeyType::integer_or_choice:
            number_or_choice(node, c, value);
            break;
        case KeyType::vector:
            value.numbers = numbers(node, c, c.dimensions);
            break;
        case KeyType::pair:
            value.numbers = pair(node, c);
            break;
        case KeyType::per_axis:
            value.numbers = per_axis(node, c);
            break;
        case KeyType::axes:
            for (const toml::node& item : array(node, c)) value.axes.push_back(choice(item, c, axis_names));
            break;
        case KeyType::words:
        case KeyType::settings:
            value.words = c.key.type == KeyType::words ? strings(node, c) : settings(node, c);
            break;
        case KeyType::points:
        case KeyType::line:
            value.points = points(node, c, c.key.type == KeyType::line ? 2 : 3);
            break;
        case KeyType::list:
            for (const toml::node& item : array(node, c)) value.numbers.push_back(real(item, c));
            break;
        case KeyType::truth:
            value.truth = truth(node, c);
            break;
    }
    return value;
}

KeyValue standard_value(const SceneKey& key, int dimensions) {
    toml::table parsed = toml::parse("v = " + *key.standard);
    toml::node& node = *parsed.get("v");
    if (key.type == KeyType::vector)  // written for three axes
        while (static_cast<int>(node.as_array()->size()) > dimensions) node.as_array()->pop_back();
    return read_value(node, {key, key.name, "default", dimensions});
}

}  // namespace moraine
