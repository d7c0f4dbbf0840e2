#pragma once
// The text of a scene, before anything of it is understood.
//
// It is apart from the reading of keys because of several ranks only one may read: files differ between hosts that
// share no disk, and a pipe (/dev/stdin) has one reader.

#include <string>

namespace moraine {

/// The whole file. Throws InputError. Not collective.
std::string read_scene_file(const std::string& path);

}  // namespace moraine
