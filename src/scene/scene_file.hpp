#pragma once
// The text of a scene, before anything of it is understood.
//
// It is apart from the reading of keys because of several ranks only one may read: files differ between hosts that
// share no disk, and a pipe (/dev/stdin) has one reader. What would exhaust memory or the stack of the parser, which
// goes down and up once per level of a key, is refused here.

#include <string>

namespace moraine {

/// Levels of a dotted key; the deepest key of a scene has four.
constexpr int deepest_key = 32;

/// The whole file. Throws InputError, also where it is larger than any scene (4 MiB). Not collective.
std::string read_scene_file(const std::string& path);

/// Throws InputError if a key has more levels than `deepest_key`. Not collective.
void refuse_deep_keys(const std::string& text, const std::string& path);

}  // namespace moraine
