#pragma once
// JSON Schema (draft 7) of a scene, made from the table of keys: editors complete and check a scene while it is
// written.
//
// What it refuses the reader refuses, too. The reader knows more: how many numbers a vector has in this scene, names
// that must be there, and what must hold between keys. A table whose keys depend on one of them (law, shape, kind) has
// all of them, and a condition for each value of that one.

#include "io/json_text.hpp"

namespace moraine {

Json scene_schema();

}  // namespace moraine
