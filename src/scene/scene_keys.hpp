#pragma once
// The table of keys of a scene: the one place that knows a key's name, type, unit, range, default and
// meaning. It drives reading (scene.cpp), unknown-key detection, range checks (scene_values.hpp) and
// the test of inputs/reference.toml, so that these cannot disagree.
//
// A default is TOML text and is read like a value of the file. The keys of a material's law come from
// core/material/laws.hpp.

#include <array>
#include <cstdint>
#include <limits>
#include <optional>
#include <stdexcept>
#include <string>
#include <vector>

#include "core/material/laws.hpp"
#include "core/scene_spec.hpp"

namespace moraine {

enum class KeyType {
    text,
    name,    ///< text of letters, digits, _ and -: it can be a part of --set paths
    choice,  ///< one of `choices`
    real,    ///< also written as a whole number
    real_or_text,
    real_or_choice,     ///< or one of `choices`
    real_or_profile,    ///< or a table with the keys of profile_rows()
    integer,            ///< whole number
    integer_or_choice,  ///< whole number, or one of `choices`
    vector,             ///< as many numbers as the scene has dimensions
    pair,               ///< two numbers, rising
    per_axis,           ///< a whole number, or one for each dimension
    axes,               ///< list of "x", "y", "z"
    words,              ///< list of strings
    points,             ///< list of [x, y], at least three
    line,               ///< list of [x, y], at least two
    list,               ///< list of numbers
    truth,              ///< true or false
    settings,           ///< a table of keys of the scene and values
};

struct KeyRange {
    double lower = -std::numeric_limits<double>::infinity();
    double upper = std::numeric_limits<double>::infinity();
    bool open_lower = false;  ///< the bound itself is not allowed
    bool open_upper = false;

    bool holds(double x) const {
        return (open_lower ? x > lower : x >= lower) && (open_upper ? x < upper : x <= upper);
    }
};

inline constexpr KeyRange above_zero{.lower = 0, .open_lower = true};
inline constexpr KeyRange from_zero{.lower = 0};
inline constexpr KeyRange from_one{.lower = 1};

struct SceneKey {
    std::string table = {};  ///< "", "domain", "body", "body.wave", ...
    std::string name = {};
    KeyType type = KeyType::real;
    std::string unit = "-";
    std::optional<std::string> standard = {};  ///< default as TOML; none: required; empty: may be absent
    KeyRange range = {};
    std::vector<std::string> choices =
        {};  ///< choice, real_or_choice, integer_or_choice: all; words: all, or empty where the scene decides
    std::vector<std::string> only = {};  ///< values of the table's selector that use the key; empty: all
    std::string meaning = {};

    bool required() const { return !standard; }
};

/// A value of the file, checked against its key; the members that its type names are set.
struct KeyValue {
    std::string text;                           ///< text, name, choice
    int choice = -1;                            ///< choice, or -1 of a number: position in the list
    double real = 0;                            ///< real, real_or_choice, real_or_profile
    std::int64_t integer = 0;                   ///< integer
    bool truth = false;                         ///< truth
    std::vector<double> numbers;                ///< vector, pair, per_axis, list
    std::vector<int> axes;                      ///< axes: 0, 1, 2
    std::vector<std::string> words;             ///< words; settings: KEY=VALUE
    std::vector<std::array<double, 2>> points;  ///< points, line

    Triple triple() const;
};

template <class Target>
struct KeyRow {
    SceneKey key;
    void (*set)(Target&, const KeyValue&);
};

/// Rows of which the first of a table names it.
template <class Target>
std::vector<KeyRow<Target>> in_tables(std::vector<KeyRow<Target>> rows) {
    for (std::size_t k = 1; k < rows.size(); ++k)
        if (rows[k].key.table.empty()) rows[k].key.table = rows[k - 1].key.table;
    return rows;
}

/// The key of that name among rows that have it.
template <class Target>
const SceneKey& key_of(const std::vector<KeyRow<Target>>& rows, const std::string& table, const std::string& name) {
    for (const KeyRow<Target>& row : rows)
        if (row.key.table == table && row.key.name == name) return row.key;
    throw std::logic_error("no key " + table + "." + name);
}

const std::vector<KeyRow<Scene>>& scene_rows();
/// Of [time], [rest] and [sleep].
const std::vector<KeyRow<Scene>>& time_rows();
const std::vector<KeyRow<MaterialSpec>>& material_rows();
/// Of the table that may stand for a property's number, "material.su".
const std::vector<KeyRow<ProfileSpec>>& profile_rows();
const std::vector<KeyRow<BodySpec>>& body_rows();
/// One [[wall]] and the face that it is about.
struct FacedWall {
    int face = 0;  ///< 2 axis + (upper ? 1 : 0)
    WallSpec wall;
    StructureSpec bed;  ///< law undrained or voellmy: a plane at the face is all that acts
};
const std::vector<KeyRow<FacedWall>>& wall_rows();
const std::vector<KeyRow<StructureSpec>>& structure_rows();
/// Of [[release]]: a body that is a layer.
const std::vector<KeyRow<BodySpec>>& release_rows();
const std::vector<KeyRow<BodySpec>>& inflow_rows();
/// Of [water].
const std::vector<KeyRow<Scene>>& water_rows();
/// Of [[table]].
struct TableSpec;
const std::vector<KeyRow<TableSpec>>& table_rows();
/// Of [[traction]].
struct TractionText;
const std::vector<KeyRow<TractionText>>& traction_rows();
const std::vector<KeyRow<Scene>>& shaking_rows();
/// Of [[stage]].
struct StageText;
const std::vector<KeyRow<StageText>>& stage_rows();
/// Of [hazard], and what hazard.maps may name.
const std::vector<KeyRow<Scene>>& hazard_rows();
const std::vector<std::string>& hazard_map_names();
/// Of [terrain]; its contact has the keys of a structure's.
const std::vector<KeyRow<StructureSpec>>& terrain_rows();
/// The table whose keys a table has: terrain.contact has those of structure.contact, those of properties that may be a
/// profile those of material.su, others their own.
std::string table_of_keys(const std::string& table);

/// The key of a law's parameter.
SceneKey parameter_key(const LawInfo& law, const Parameter& parameter);

/// Every key of a scene, in the order of the documentation.
std::vector<SceneKey> all_scene_keys();

/// The key whose value decides which others a table uses ("shape" of "body"); empty: none.
std::string selector_of(const std::string& table);

/// What output.labels may name.
const std::vector<std::string>& output_label_names();

/// What output.fields may name in this scene.
std::vector<std::string> output_field_names(const Scene& scene);

/// "(0, 1.5]", ">= 0"; empty when any number will do.
std::string range_text(const KeyRange& range);

/// "a number [s]", "one of ..."
std::string type_text(const SceneKey& key);

/// The key's line in the documentation: type, unit, range; default. Meaning.
std::string describe(const SceneKey& key);

}  // namespace moraine
