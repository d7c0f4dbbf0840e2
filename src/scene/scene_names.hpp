#pragma once
// Keys and tables of a scene that nobody knows: each is refused with the nearest valid key.

#include <toml++/toml.h>

#include <string>

namespace moraine {

/// Also refuses a table where a value is needed and the reverse, so that readers after it need not look.
/// Throws InputError.
void refuse_unknown_keys(const toml::table& root, const std::string& file);

/// What a table of a list is called in messages and --set: its name or face, else its number from 1.
std::string label_of(const toml::table& table, const std::string& list, int number);

}  // namespace moraine
