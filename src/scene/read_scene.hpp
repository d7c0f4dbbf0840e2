#pragma once
// Reading a scene from TOML.
//
// What is not in the table of keys (scene_keys.hpp), has another type or is out of range is an error
// with file, line and the nearest valid key: a mistyped key that is ignored costs a day of computing.
// The scene that comes back has passed scene_check.hpp: it can be run.

#include <functional>
#include <string>
#include <vector>

#include "compile/law_file.hpp"
#include "core/scene_spec.hpp"

namespace moraine {

/// `sets` are KEY=VALUE, applied in order. `admit` sees the scene when all but its particles has been checked, and may
/// throw (predict/capacity.hpp): to go through them may take as long as to seed them. `rights`: of laws in files.
/// Throws InputError. Not collective: every rank reads.
Scene read_scene(const std::string& path, const std::vector<std::string>& sets = {},
                 const std::function<void(const Scene&)>& admit = {}, const CodeRights& rights = {});

/// The same of a text that has been read; `path` is what messages call it, and where its tables are. Not collective.
Scene parse_scene(const std::string& path, const std::string& text, const std::vector<std::string>& sets,
                  const std::function<void(const Scene&)>& admit, const CodeRights& rights = {});

}  // namespace moraine
