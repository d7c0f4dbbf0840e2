#pragma once
// Reads the tables of a scene by rows of keys (scene_keys.hpp): each key in the order of its section, with what it is
// for, where it stands, and what it has if it is left out. Included by read_scene.cpp alone.

#include <fmt/format.h>
#include <toml++/toml.h>

#include <algorithm>
#include <optional>
#include <string>
#include <vector>

#include "io/input_error.hpp"
#include "scene/scene_file.hpp"
#include "scene/scene_keys.hpp"
#include "scene/scene_names.hpp"
#include "scene/scene_tables.hpp"
#include "scene/scene_values.hpp"

namespace moraine {

class TableReader {
  public:
    /// `dimensions` is read as tables are, and must outlive it.
    TableReader(const std::string& file, toml::table tables, const int& dimensions)
        : root(std::move(tables)), places(file), file_(file), dimensions_(dimensions) {}

    toml::table root;
    Places places;

    const std::string& file() const { return file_; }

    /// Null: it is not there.
    static const toml::table* section_table(const toml::table& parent, const std::string& name) {
        const toml::node* node = parent.get(name);
        return node ? node->as_table() : nullptr;  // refuse_unknown_keys has seen to the type
    }

    /// Calls read(table, path) for each table of a list.
    template <class F>
    void each_of(const std::string& list, const F& read) {
        const toml::node* node = root.get(list);
        if (!node) return;
        int number = 0;
        for (const toml::node& item : *node->as_array()) {
            const toml::table& table = *item.as_table();
            const std::string path = list + "." + label_of(table, list, ++number);
            if (places.has(path))
                refuse(place_of(item, file_), fmt::format("{} is there twice", path),
                       "the other is at " + places.of(path), "Rename one of them?");
            places.add(path, place_of(item, file_));
            read(table, path);
        }
    }

    template <class Target>
    void read_table(const toml::table* table, const std::string& section, const std::string& path,
                    const std::vector<KeyRow<Target>>& rows, Target& target) {
        if (table && !path.empty()) places.add(path, place_of(*table, file_));
        std::string selected;
        for (const KeyRow<Target>& row : rows) {
            if (row.key.table != section) continue;
            const std::optional<KeyValue> value = read_key(row.key, table, path, selected);
            if (!value) continue;
            row.set(target, *value);
            if (row.key.name == selector_of(section)) selected = value->text;
        }
    }

    std::optional<KeyValue> read_key(const SceneKey& key, const toml::table* table, const std::string& table_path,
                                     const std::string& selected) {
        const std::string path = table_path.empty() ? key.name : table_path + "." + key.name;
        const toml::node* node = table ? table->get(key.name) : nullptr;
        const bool used = key.only.empty() || std::find(key.only.begin(), key.only.end(), selected) != key.only.end();
        if (node && !used)
            refuse(place_of(*node, file_), path + " is not used",
                   fmt::format("it is for {} {}", selector_of(key.table), listed(key.only)),
                   fmt::format("Remove it, or set {}.{}?", table_path, selector_of(key.table)));
        if (!used) return std::nullopt;
        if (node) {
            places.add(path, place_of(*node, file_));
            if (node->is_table() && key.type == KeyType::real_or_profile) return std::nullopt;  // whoever knows its law
            return read_value(*node, {key, path, place_of(*node, file_), dimensions_});
        }
        if (key.required())
            refuse(place_of_table(table, table_path), path + " is missing", "must be " + type_text(key),
                   fmt::format("Add {} = ...{}?", key.name, table_path.empty() ? "" : " to this table"));
        if (key.standard->empty()) return std::nullopt;
        return standard_value(key, dimensions_);
    }

  private:
    /// Where a table that may be absent stands, or would.
    std::string place_of_table(const toml::table* table, const std::string& path) const {
        return table && !path.empty() ? place_of(*table, file_) : file_;
    }

    const std::string file_;
    const int& dimensions_;
};

}  // namespace moraine
