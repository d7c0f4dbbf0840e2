#pragma once
// Laws in files, before the keys of a scene are looked at: its materials of law "file" say their keys in their source.

#include <toml++/toml.h>

#include <string>

#include "compile/law_file.hpp"
#include "core/material/laws.hpp"

namespace moraine {

/// Loads them. The value of `source` becomes the law's name, as find_law() knows it. Throws InputError.
void load_laws(toml::table& root, const std::string& scene, const CodeRights& rights);

/// The law of a table of a material, after load_laws(); nullptr where it names none that is known.
const LawInfo* law_of(const toml::table& material);

}  // namespace moraine
