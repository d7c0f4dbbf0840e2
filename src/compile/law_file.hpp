#pragma once
// A constitutive law in a file of the user's: `law = "file"`, `source = "my_law.hpp"`.
//
// The file has `template <class Real> struct Law` in namespace moraine, as core/material/point.hpp says it. It is
// compiled with the loop over particles that every law has (core/particles/law_object.hpp) into a shared object, which
// is kept on disk, and becomes a law like others: find_law() knows it by a name that says its content, so that ranks,
// restarts and records tell two files apart. It is code, which may do whatever the user may: nobody loads it who was
// not asked to.

#include <filesystem>
#include <functional>
#include <string>

#include "compile/compile_cache.hpp"

namespace moraine {

/// What a scene may do besides being read.
struct CodeRights {
    bool allowed = false;                               ///< its laws in files are compiled and run
    CompileCache cache = CompileCache();                ///< where they are kept
    std::function<void(const std::string&)> tell = {};  ///< hears that one is being compiled
};

/// The name of the law in `file`, which messages call `path`. Throws CompilerError, InputError: what is wrong, in words
/// that go on after the file. Not collective.
std::string load_law(const std::filesystem::path& file, const std::string& path, const CodeRights& rights);

/// As a #line says it: the compiler's errors name the user's file and lines.
std::string quoted_path(const std::string& path);

}  // namespace moraine
