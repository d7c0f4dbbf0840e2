#pragma once
// --set KEY=VALUE: a key of the scene given on the command line.
//
// KEY is a dotted path; material.NAME.key, body.NAME.key, structure.NAME.key and wall.FACE.key address
// the tables of a list. VALUE is TOML, else a string. The value carries "--set KEY=VALUE" as its place,
// so that a wrong one is reported there and checked like any other.

#include <toml++/toml.h>

#include <string>

namespace moraine {

/// Throws InputError if the assignment has no KEY= or names a table that is not there. `by`: what gives it, "--set" or
/// "stage.NAME.set", the begin of its place.
void apply_set(toml::table& root, const std::string& assignment, const std::string& by = "--set");

/// "name" or "face": the key by which the tables of this list are addressed; empty: not a list.
std::string label_of_list(const std::string& table);

}  // namespace moraine
