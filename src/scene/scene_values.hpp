#pragma once
// One TOML value against its key: type, range, choices. Wrong ones are refused with the expected type,
// the place and a suggestion.

#include <toml++/toml.h>

#include <string>

#include "io/input_error.hpp"
#include "scene/scene_keys.hpp"

namespace moraine {

/// "scene.toml:12", or "--set KEY=VALUE".
std::string place_of(const toml::node& node, const std::string& file);

/// "a string", "a table", ...
std::string kind_of(const toml::node& node);

/// `path` is the key as shown to people: body.clay.radius. `dimensions` is the length of vectors.
struct KeyContext {
    const SceneKey& key;
    std::string path;
    std::string place;
    int dimensions;
};

/// Throws InputError.
KeyValue read_value(const toml::node& node, const KeyContext& context);

/// The key's default, which must exist.
KeyValue standard_value(const SceneKey& key, int dimensions);

}  // namespace moraine
