#pragma once
// What makes a scene the same scene: a restart may change time.end, output, balance, device and ranks, and nothing else
// but what it is told to (scene_changes.hpp).

#include <map>
#include <string>
#include <utility>
#include <vector>

#include "core/scene_spec.hpp"

namespace moraine {

/// Keys and values of all that a restart must not change, in a fixed order. Doubles as they read back.
std::vector<std::pair<std::string, std::string>> scene_identity(const Scene& scene);

/// The identity as text, one `key = value` per line, for a checkpoint's header.
std::string identity_text(const Scene& scene);

/// Keys and values of an identity's text.
std::map<std::string, std::string> entries_of(const std::string& identity);

/// What a value of the identity is in a scene: kinds, which it holds as numbers, by their words.
std::string in_words(const std::string& key, const std::string& value);

/// The first key, but for the allowed ones, in which `scene` differs from a stored identity, with both values; empty:
/// the same.
std::string first_difference(const Scene& scene, const std::string& stored,
                             const std::vector<std::string>& allowed = {});

}  // namespace moraine
